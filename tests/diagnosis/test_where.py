"""The places that errors are told for."""

import numpy as np

from labrig.diagnosis._problem import prepared, rows_from
from labrig.diagnosis._where import places


def regions(lab) -> dict[str, list[int]]:
    """The observables of each region of a surface."""
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
    found = places(ready.context, ready.regression.counted)
    return {p.name: np.flatnonzero(p.columns).tolist() for p in found if p.group == "region"}


def test_a_marker_is_over_one_chamber_with_all_its_axes(make_lab) -> None:
    """The axes of a marker are not told apart; one marker alone, the tip of an arm, has no regions."""
    over = regions(make_lab(markers=6))
    assert list(over) == ["over c1", "over c2", "over c3"]
    for own in over.values():
        assert len(own) % 3 == 0
        assert all(k // 3 in {j // 3 for j in own if j % 3 == 0} for k in own)
    arm = make_lab(markers=1)
    arm.reach[:] = 20.0 * np.eye(3) + 1.0  # each chamber bends it another way
    assert regions(arm) == {}
