"""The places that errors are told for."""

import re
from dataclasses import replace

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


def test_bands_below_zero_are_read_as_ranges(make_lab) -> None:
    """A band of negative pressures is from one to the other: no minus sign stands beside a dash."""
    lab = make_lab()
    rows = rows_from(lab.dataset(lab.predict(lab.u) + lab.noise()))
    below = replace(
        rows,
        actuation=rows.actuation - 100.0,
        event_actuation=rows.event_actuation - 100.0,
        low=rows.low - 100.0,
        high=rows.high - 100.0,
    )
    ready = prepared(below, lab.model())
    found = places(ready.context, ready.regression.counted)
    names = [p.name for p in found if p.group in {"pressure band", "time in session"}]
    assert any(name.startswith("-") for name in names)
    assert all(re.fullmatch(r"\S+ to \S+ (kPa|s)", name) for name in names)
