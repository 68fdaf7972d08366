"""What single laws and rigs of the portions promise, beside what all of their effect do."""

import numpy as np
import pytest

from labrig.bench._nature import Setting
from labrig.bench._path import make_path
from labrig.bench._programmes import make_plan
from tests.bench.portions import LAWS, case, change, law_on


def test_buckling_takes_either_side_with_the_same_load() -> None:
    """Aside from its threshold the body is pushed to one side at some times and to the other at others."""
    law, path = law_on("BucklesEitherWay", "wing")
    aside = change(law, path) @ law._aside  # pyright: ignore[reportAttributeAccessIssue]
    assert aside.min() < -1e-3
    assert aside.max() > 1e-3
    assert np.mean(np.abs(aside) < 1e-9) > 0.2


def test_a_sticky_stop_is_left_later_than_it_is_met() -> None:
    """Where a wall first meets the stop it has gone farther than where it is free again on its way back."""
    rig, _ = case("fourth", "toggle")
    plan = make_plan("one_level", np.random.default_rng(0), rig.high_kpa, 4)
    for level in (*np.linspace(0, 1, 40), *np.linspace(1, 0, 40)):
        plan.capture(level * rig.high_kpa, 4.0, 1)
    path = make_path(plan)
    law = LAWS["AdhesiveStop"][1](Setting(rig, path, np.random.default_rng(1)))
    free = rig.deflection(path.kpa)
    off = np.abs(law.wall(path, path.kpa, free, 1.0) - free).max(axis=1)[path.row][-80:] > 1e-9
    assert off[:40].sum() + 2 < off[40:].sum() < 40


def test_the_cells_of_a_cushion_share_one_weight() -> None:
    """Whatever the pressures, the load cells together carry the same."""
    rig, path = case("fourth", "cushion")
    total = rig.settled(path.kpa).sum(axis=1)
    np.testing.assert_allclose(total, total[0])


def test_a_cell_of_a_comb_takes_its_neighbours_along() -> None:
    """One full cell alone rises by less than with all the others, and a vented neighbour rises with it."""
    rig, _ = case("fifth", "comb")
    alone = rig.deflection(np.diag(rig.high_kpa))
    assert (np.diag(alone) < 0.8).all()
    assert alone.min() > 0
    assert (np.sort(alone, axis=1)[:, -2] > 0.05).all()


def test_a_loose_weight_is_waited_for_and_then_taken_along() -> None:
    """Beyond what it weighs a wall lacks the same, however far it goes; before it meets the weight it lacks nothing."""
    rig, path = case("fifth", "lens")
    law = LAWS["LiftedWeight"][1](Setting(rig, path, np.random.default_rng(1)))
    free = np.linspace(0, 1.5, 200)[:, None]
    lacks = (free - law.wall(path, free, free, 0.5))[:, 0]
    assert (np.diff(lacks) >= -1e-12).all()
    assert lacks[5] == 0
    assert lacks[-1] == pytest.approx(lacks[-40])
    assert lacks[-1] > 0.02


def test_a_stale_frame_is_what_was_seen_before_the_actuation() -> None:
    """In a few actuations the rows are between the truth and the last one before; in all the others they are right."""
    law, path = law_on("StaleFrames", "hand")
    rig = law.rig
    values = rig.settled(path.kpa)
    off = law.seen(path, rig.deflection(path.kpa), values, 50.0) - values
    touched = np.unique(path.event[np.abs(off).max(axis=1) > 1e-9])
    assert 0 < len(touched) < 0.5 * (path.event.max() + 1)
    first = path.event == touched[0]
    before = values[np.flatnonzero(first)[0] - 1]
    np.testing.assert_allclose((values + off)[first], np.broadcast_to(before, values[first].shape), atol=0.5)


def test_a_tongue_keeps_its_length_times_its_width() -> None:
    """Squeezed across, a tongue is longer, and thinner by the root of that, ring by ring."""
    rig, _ = case("sixth", "tongue")
    sides = rig._sides  # pyright: ignore[reportAttributeAccessIssue]
    squeezed = rig.high_kpa * (np.arange(len(rig.chambers)) >= sides)
    places = rig.settled(np.stack([0.0 * squeezed, squeezed])).reshape(2, -1, 3)
    assert places[1, :, 2].max() > 1.1 * places[0, :, 2].max()
    wide = np.linalg.norm(places[..., :2], axis=2)
    assert (wide[1] < wide[0]).all()


def test_nothing_gets_into_a_round_bar() -> None:
    """No marker comes nearer to the bar than it is at rest, or than the bar is thick; at rest none is touched."""
    law, path = law_on("RoundBar", "ray")
    rig = law.rig
    before, after = (
        law._past(values.reshape(len(values), -1, 3), law._far_mm * np.exp(-law._sooner))[2]  # pyright: ignore[reportAttributeAccessIssue]
        for values in (rig.settled(path.kpa), law.seen(path, path.kpa, rig.settled(path.kpa), 1.0))
    )
    thick = law._thick_mm  # pyright: ignore[reportAttributeAccessIssue]
    assert (before < thick - 1e-3).any()
    assert (after > thick - 1e-6).all()
    rest = rig.at_rest[None]
    np.testing.assert_allclose(law.seen(path, rest, rest, 1.0), rest)


def test_a_flag_is_shut_at_low_loads() -> None:
    """Vented, and below the load at which the loops begin, a wall is where it would be without them."""
    law, path = law_on("FlagLoops", "suit")
    off = law.pressure(path, path.kpa, 1.0) - path.kpa
    low = path.kpa / law.rig.high_kpa < law._above  # pyright: ignore[reportAttributeAccessIssue]
    assert np.abs(off[low]).max() < 1e-9
    assert np.abs(off).max() > 1e-2 * law.rig.high_kpa.max()
