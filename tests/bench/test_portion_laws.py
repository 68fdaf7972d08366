"""What single laws of the portions promise: a leak, creep, a delay, friction, coupling, a frame."""

import numpy as np
import pytest

from labrig.bench._nature import Path, Setting, simulate
from labrig.bench._path import make_path
from labrig.bench._programmes import make_plan
from tests.bench.portions import (
    BENT,
    LAWS,
    OTHER,
    RUBS,
    SEVERAL,
    WITH_A_MARKER,
    case,
    change,
    law_on,
    named,
)


def _holds(path: Path) -> list[tuple[int, int]]:
    """First and last moment of each actuation that is held for ten seconds or more."""
    begins = np.flatnonzero(np.diff(path.event, prepend=-1))
    ends = np.append(begins[1:], len(path.event)) - 1
    late = [int(b + np.argmax(path.hold_s[b : e + 1] > 1.5)) for b, e in zip(begins, ends, strict=True)]
    return [(b, int(e)) for b, e in zip(late, ends, strict=True) if path.hold_s[e] - path.hold_s[b] > 10]


IN_SIGHT = (
    "CrackInTheWhole",
    "Pinholes",
    "OneEuroFilter",
    "HeavyBody",
    "AveragingSensor",
    "NarrowChannel",
    "AlphaBetaTracker",
    "AmplifiersLowPass",
    "OldReadings",
)
"""Leaks and delays that act in what is seen, not in a chamber's pressure or wall."""


@pytest.mark.parametrize("name", [name for name in named("leak") if name not in IN_SIGHT])
def test_a_leak_brings_a_held_pressure_nearer_to_the_rooms(name: str) -> None:
    """Within a hold a leak takes pressure away, or vacuum; only a pocket that is full, or a valve that tops it up,
    gives some back to a chamber.
    """
    for rigs in (SEVERAL, OTHER):
        found, path = law_on(name, rigs, 1)
        left = found.pressure(path, path.kpa, 1.0)
        lost = [np.abs(left[e]) - np.abs(left[b]) for b, e in _holds(path)]
        high = np.abs(path.kpa).max()
        assert np.min(lost) < -0.02 * high
        assert np.max(lost) < 1e-3 * high or name in ("HiddenPocket", "ToppedUp")


def test_a_hidden_pocket_fills_up_and_gives_back() -> None:
    """What a chamber loses to a pocket ends at the pocket's share, and some of it comes back once it is vented."""
    rig, _ = case("third", "trunk")
    plan = make_plan("one_hold", np.random.default_rng(0), rig.high_kpa, 100)
    plan.capture(np.zeros(6), 120.0, 6)
    path = make_path(plan)
    found = LAWS["HiddenPocket"][1](Setting(rig, path, np.random.default_rng(1)))
    takes = found._takes  # pyright: ignore[reportAttributeAccessIssue]
    held = path.event == 0
    left = found.pressure(path, path.kpa, 1.0)
    np.testing.assert_allclose(left[held][-1], path.kpa[held][-1] / (1 + takes), rtol=1e-3)
    assert (left[-1][takes > 0] > 0.01 * rig.high_kpa[takes > 0]).all()
    assert (left[-1] < path.kpa[held][-1] - left[held][-1] + 1e-6).all()


@pytest.mark.parametrize("name", [*named("creep"), *IN_SIGHT[:2]])
def test_creep_goes_on_under_load(name: str) -> None:
    """Of a vented rig that is filled and held, the change grows through the hold, ever slower."""
    half, law = LAWS[name]
    rig, _ = case(half.name, SEVERAL[half.name])
    plan = make_plan("one_hold", np.random.default_rng(0), rig.high_kpa, 20)
    path = make_path(plan)
    found = law(Setting(rig, path, np.random.default_rng(1)))
    size = np.linalg.norm(change(found, path), axis=1)
    assert (np.diff(size) > -1e-9).all()
    assert size[8] - size[0] > size[-1] - size[-9] > 0


@pytest.mark.parametrize("name", IN_SIGHT[2:])
def test_what_is_seen_late_has_caught_up_at_the_end_of_a_long_hold(name: str) -> None:
    """What a filter or a heavy body lags behind just after an actuation is hardly there fourteen seconds later."""
    found, path = law_on(name, BENT, 1, captures=40)
    off, held_s = np.abs(change(found, path)).max(axis=1), path.hold_s[path.row]
    assert off[held_s < 3].max() > 3 * found.rig.noise
    assert off[held_s > 14].max() < 0.1 * off[held_s < 3].max()


@pytest.mark.parametrize("name", [name for name in named("delay") if name not in IN_SIGHT])
def test_delay_is_over_at_the_end_of_a_long_hold(name: str) -> None:
    """What a delay changes just after an actuation is gone ten seconds later."""
    found, path = law_on(name, BENT, 1, captures=40)
    rig = found.rig
    deflection = found.wall(path, path.kpa, rig.deflection(found.pressure(path, path.kpa, 0.6)), 0.6)
    off = np.abs(deflection - rig.deflection(path.kpa)).max(axis=1)
    holds = _holds(path)
    assert max(off[b] for b, _ in holds) > 0.02
    assert max(off[e] for _, e in holds if path.hold_s[e] > 14) < 1e-3


BETWEEN_WALLS = ("RubsOnItsNeighbour",)
"""Friction of what moves unlike its neighbour; here all chambers are filled alike."""


@pytest.mark.parametrize("name", [name for name in named("friction") if name not in BETWEEN_WALLS])
def test_friction_is_behind_whichever_way_it_comes_from(name: str) -> None:
    """The same set-point is reached from below and from above with different shapes, and stays as it is in a hold."""
    half, law = LAWS[name]
    rig, _ = case(half.name, RUBS[half.name])
    plan = make_plan("one_level", np.random.default_rng(0), rig.high_kpa, 4)
    for level in (0.0, 0.5, 1.0, 0.5):
        plan.capture(level * rig.high_kpa, 6.0, 4)
    path = make_path(plan)
    found = law(Setting(rig, path, np.random.default_rng(1)))
    seen = simulate(rig, [(found, 1.0)], path)[-16:].reshape(4, 4, -1)
    apart = np.abs(seen[1, -1] - seen[3, -1]).max()
    assert apart > 5 * rig.noise
    assert np.abs(seen[:, -1] - seen[:, 0]).max() < 0.05 * apart


def test_masing_loops_close() -> None:
    """After a small loop inside a large one the body is where it would be without the small one."""
    law, _ = law_on("MasingBranches", "trunk")
    branches = law._branches  # pyright: ignore[reportAttributeAccessIssue]
    plain = branches(np.array([0.0, 2.0, -1.5, 1.0, 1.8]))
    again = branches(np.array([0.0, 2.0, -1.5, 1.0, 0.2, 0.6, 0.3, 1.0, 1.8]))
    assert again[-2:] == pytest.approx(plain[-2:])
    assert again[4] != pytest.approx(again[7])
    assert branches(np.array([0.0, 2.0, -1.5, 3.0]))[-1] == pytest.approx(branches(np.array([0.0, 3.0]))[-1])


REACHING = (
    "BeamOnElasticBed",
    "LinearCrosstalk",
    "PinholedSeptum",
    "BulgingPartition",
    "LeakyPartition",
    "SeptumBulges",
    "WallsTouch",
    "OnOneHalfSpace",
    "FrameFlexes",
    "WhiffleTree",
)
"""Laws of coupling by which what fills one chamber reaches another."""


@pytest.mark.parametrize("name", REACHING)
def test_what_fills_one_chamber_reaches_a_vented_one(name: str) -> None:
    """Some chamber that is vented gives way because another one is full."""
    found, path = law_on(name, SEVERAL, 1)
    rig, alone = found.rig, 0.95 * np.diag(found.rig.high_kpa)
    pressures = found.pressure(path, alone, 1.0)
    walls = found.wall(path, pressures, rig.deflection(pressures), 1.0)
    others = walls - np.diag(np.diag(walls))
    assert np.abs(others).max() > 0.002
    assert np.allclose(found.wall(path, 0 * alone, rig.deflection(0 * alone), 1.0), 0)


REMEMBERING = ("TankThatEmpties", "SqueezedInTheDeadBand")
"""Coupling by what was filled before: no chamber is alone there."""


@pytest.mark.parametrize(
    "name", [name for name in named("coupling") if name not in (*REACHING, *REMEMBERING)]
)
def test_coupling_does_nothing_to_a_chamber_alone(name: str) -> None:
    """Each chamber alone moves as modelled, at least within its limits; together they do not."""
    found, path = law_on(name, SEVERAL, 1)
    rig, count = found.rig, len(found.rig.chambers)
    alone = np.vstack([0.95 * rig.high_kpa * np.eye(count), rig.high_kpa * np.linspace(0.4, 0.95, count)])
    pressures = found.pressure(path, alone, 1.0)
    walls = found.wall(path, pressures, rig.deflection(pressures), 1.0)
    values = found.seen(path, walls, rig.shape(walls), 1.0)
    off = np.abs(values - rig.settled(alone)).max(axis=1)
    assert off[:-1].max() < 0.5 * rig.noise
    assert off[-1] > 3 * rig.noise


LATER = ("TripodKicked", "TurningAxisElsewhere", "CameraBumped", "CalibratedAnew", "MovedForAWhile")
"""Frames that are moved at one moment, or by the tilt."""
RIDING = ("ReferenceRides",)
"""Frames that the body moves."""


@pytest.mark.parametrize("name", LATER)
def test_a_frame_that_moves_later_moves_all_markers_as_one_body(name: str) -> None:
    """What moves is the frame: all distances between markers stay, or have one scale; before it, nothing moved."""
    found, path = law_on(name, SEVERAL, 1)
    rig = found.rig
    with_it, without = (simulate(rig, laws, path) for laws in ([(found, 1.0)], []))
    apart = [np.linalg.norm(np.diff(v.reshape(len(v), -1, 3), axis=1), axis=2) for v in (with_it, without)]
    scale = apart[0].sum(axis=1) / apart[1].sum(axis=1)
    np.testing.assert_allclose(apart[0], scale[:, None] * apart[1], atol=1e-6 * np.abs(without).max())
    moved = np.abs(with_it - without).max(axis=1)
    assert moved.min() < 1e-9 < rig.noise < moved.max()


@pytest.mark.parametrize(
    "name", [n for n in (*named("frame"), *named("rest_shape")) if n not in LATER + RIDING]
)
def test_frames_and_rest_shapes_are_there_at_rest(name: str) -> None:
    """What is wrong with a frame or a rest shape is seen of the vented body too, and hardly depends on pressure."""
    marked = "marker" in LAWS[name][1].needs
    found, path = law_on(name, BENT | WITH_A_MARKER if marked else BENT, 1)
    off = change(found, path)
    first = off[path.session[path.row] == 0]
    assert np.std(first, axis=0).max() < 0.5 * np.abs(first.mean(axis=0)).max()
