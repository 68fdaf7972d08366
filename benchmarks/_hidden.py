"""What is hidden in a blind campaign, at the rows that a diagnosis works on."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._dataset import _padded
from labrig.bench._draw import Campaign
from labrig.effects import rows_of


def at_rows(campaign: Campaign, change: Floats) -> Floats:
    """A change of the observables (R, K), capture by capture, at the rows (F, K) of a diagnosis, 0 where unseen."""
    dataset = campaign.dataset.copy(deep=True)
    seen = dataset["position_mm" if "position_mm" in dataset else "observed"]
    counts = np.isfinite(dataset["hold_s"].values).sum(axis=1)
    values = _padded(change, counts).reshape(seen.shape)
    seen.values[...] = np.where(np.isfinite(seen.values), values, np.nan)
    return np.nan_to_num(rows_of(dataset).values)
