"""Labels of repeats that number them, and do not name them."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from xarray import Dataset

_ONE_PLACE = 0.1
"""Share of a chamber's range by which the set-points of one label may differ: an input may be a sensor's reading."""


def drop_counts(dataset: "Dataset", column: str) -> list[str]:
    """Take the labels of repeats off an imported campaign if equal ones of a session are at different set-points, as
    where each visit of a set-point is numbered 1, 2, 3; returns what to say of it.

    Captures with equal set-points count as repeats then, as where nothing is labelled.
    """
    labels, places, session = (dataset[name].values for name in ("repeat", "commanded", "session"))
    apart = _ONE_PLACE * np.ptp(places, axis=0)
    for label, of in dict.fromkeys(zip(labels.tolist(), session.tolist(), strict=True)):
        own = places[(labels == label) & (session == of)]
        if label and (np.ptp(own, axis=0) > apart).any():
            dataset["repeat"] = dataset["repeat"].copy(data=np.full_like(labels, ""))
            return [
                f"column {column!r} says {label!r} at different set-points: it numbers repeats, and does not say which "
                "captures repeat each other; captures with equal set-points are taken for repeats"
            ]
    return []
