"""The places that errors are told for."""

import re
from dataclasses import replace

import numpy as np

from labrig.diagnosis import compare
from labrig.diagnosis._problem import prepared, rows_from
from labrig.diagnosis._where import places
from tests.diagnosis.test_records import DT_S, ROWS, model_of, record, swept


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


def test_a_record_is_told_by_stretches_and_speeds(tmp_path) -> None:
    """Of rows without holds no single one is told, but where in the record it fails, and how fast the input goes there:
    a sensor whose lag is proportional to the speed is worst where that is highest.
    """
    u = 40.0 * swept(3)
    y = 0.3 * u - 0.5 * np.gradient(u, DT_S) * 0.3 + 0.01 * np.random.default_rng(4).normal(size=ROWS)
    y[140:175] += 2.0  # 28 to 35 s of 140 s: a twentieth
    told = compare(record(u, y, "kPa", "mm"), model_of(tmp_path)).summary["where"]
    assert "capture" not in {place["group"] for place in told}
    stretches = [place["name"] for place in told if place["group"] == "stretch"]
    assert stretches[0] == "28 to 35 s"
    assert len(stretches) == 5
    speeds = [place for place in told if place["group"] == "input speed"]
    low = [float(place["name"].split(" to ")[0]) for place in speeds]
    assert low == sorted(low, reverse=True)
    assert all(place["name"].endswith(" kPa/s") for place in speeds)


def test_the_speed_of_an_input(tmp_path) -> None:
    """A sine's speed is that of its derivative, whichever way it goes; of captures that are held there is none."""
    t = np.arange(ROWS) * DT_S
    u = 20 + 20 * np.sin(2 * np.pi * t / 25)
    context = prepared(rows_from(record(u, 0.3 * u, "kPa", "mm")), model_of(tmp_path)).context
    there = np.abs(40 * np.pi / 25 * np.cos(2 * np.pi * t / 25))
    np.testing.assert_allclose(context.input_speed[1:-1, 0], there[1:-1], atol=0.02)


def test_two_rows_at_two_set_points_are_compared(make_lab) -> None:
    """No row is in the band between them, and that is no reason to end."""
    lab = make_lab(captures=2, rows_s=(3.0,), repeats=False)
    told = compare(lab.dataset(lab.predict(lab.u) + 1.0), lab.model()).summary["where"]
    bands = [place["name"] for place in told if place["group"] == "pressure band"]
    assert len(bands) <= 2
    assert told
