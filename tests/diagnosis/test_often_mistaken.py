"""Values that are left out as mistaken are said where they are too many to be mistakes."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig


def rig(u: np.ndarray) -> np.ndarray:
    """An angle and a force of two pressures, (F, 2)."""
    return np.column_stack([0.9 * u[:, 0] - 0.4 * u[:, 1], 0.02 * u[:, 0] + 0.01 * u[:, 1]])


@pytest.mark.parametrize("every", [7, 60])
def test_interference_is_not_called_good(tmp_path: Path, every: int) -> None:
    """Beside spikes in every seventh row a right model is not "as good as the measurements"; in one of sixty it is."""
    rng = np.random.default_rng(5)
    u = np.repeat(rng.uniform(0, 60, (40, 2)).round(1), 3, axis=0)
    noise = np.array([0.2, 0.02])
    values = rig(u) + rng.normal(size=(120, 2)) * noise
    hit = np.arange(3, 120, every)
    values[hit] += 12 * noise * rng.choice([-1, 1], (len(hit), 1))
    table = pd.DataFrame(np.column_stack([u, values]), columns=["p1_kPa", "p2_kPa", "tip_deg", "force_N"])
    table.insert(0, "time_s", np.arange(120) * 2.0)
    found = labrig.diagnose(labrig.import_table(table, tmp_path / "run"), rig)
    assert found.verdict == "nothing_missing"
    said = found.headline()
    notes = " ".join(found.warnings)
    if every == 7:
        assert found.summary["left_out_share"] > 0.1
        assert found.summary["track_record"] is None
        assert said.startswith("Nothing is missing beside 1")
        assert "in 11 of 80 rows: what makes them, such as interference, is in no verdict; find it" in notes
    else:
        assert said.startswith("Nothing is missing: the model is as good as the measurements")
        assert "interference" not in notes
