"""The portions of the development half: their rigs and laws do what they promise, and each is drawn from apart."""

import re
from functools import cache

import numpy as np
import pytest

from labrig.arrays import Floats
from labrig.bench import CLASSES, draw, half_of, make_rig
from labrig.bench._hide import has
from labrig.bench._learn import drawn_example, learn_all
from labrig.bench._nature import (
    EFFECTS,
    Half,
    Law,
    Path,
    Rig,
    Setting,
    simulate,
)
from labrig.bench._path import make_path
from labrig.bench._programmes import CONFOUNDED_DESIGNS, DESIGNS, make_plan
from labrig.bench.development import DEVELOPMENT
from labrig.bench.development.eighth import EIGHTH
from labrig.bench.development.fifth import FIFTH
from labrig.bench.development.fourth import FOURTH
from labrig.bench.development.seventh import SEVENTH
from labrig.bench.development.sixth import SIXTH
from labrig.bench.development.third import THIRD

PORTIONS = (THIRD, FOURTH, FIFTH, SIXTH, SEVENTH, EIGHTH)


def laws_of(half: Half) -> list[type[Law]]:
    """All laws of a half."""
    return [law for laws in half.laws.values() for law in laws] + list(half.outside)


LAWS = {law.__name__: (half, law) for half in PORTIONS for law in laws_of(half)}
_KINDS = {
    "third": ("trunk", "sheet", "wing", "boom"),
    "fourth": ("tower", "cuff", "bell", "bell"),
    "fifth": ("walker", "snake", "face", "face"),
    "sixth": ("tongue", "ray", "vine", "ray"),
    "seventh": ("auger", "spine", "auger", "spine"),
    "eighth": ("mattress", "tripod", "mattress", "lung"),
}
SEVERAL, OTHER, BENT, RUBS = ({half: kinds[i] for half, kinds in _KINDS.items()} for i in range(4))
"""Rigs of each portion: one with six chambers or more, and markers; another one; one whose walls are bent; one for
friction.
"""


def named(effect: str) -> list[str]:
    """The names of the laws of an effect, of all portions."""
    return [name for name, (_, law) in LAWS.items() if law.effect == effect]


@cache
def case(portion: str, kind: str, captures: int = 24) -> tuple[Rig, Path]:
    """A rig of a kind, always the same, and a small campaign on it in which all laws find what they need."""
    rig = half_of(portion).rigs[kind](np.random.default_rng(3))
    random = np.random.default_rng(4)
    plan = make_plan("sessions", random, rig.high_kpa, captures, True, True, 0.25, True, min_kpa=rig.low_kpa)
    return rig, make_path(plan)


def quickest(half: Half) -> list[str]:
    """Kinds of rigs of a half; the one that takes longest to compute comes last."""
    return sorted(half.rigs, key=lambda kind: kind == "trunk")


def law_on(name: str, rigs: dict[str, str] | str, seed: int = 11, captures: int = 24) -> tuple[Law, Path]:
    """A law of a name on the rig of a kind, which may be another one in each portion."""
    half, law = LAWS[name]
    rig, path = case(half.name, rigs if isinstance(rigs, str) else rigs[half.name], captures)
    return law(Setting(rig, path, np.random.default_rng(seed))), path


@cache
def untouched(portion: str, kind: str) -> Floats:
    """What the rig of a kind shows without any law, (R, K)."""
    rig, path = case(portion, kind)
    return simulate(rig, [], path)


def change(law: Law, path: Path) -> Floats:
    """What a law changes at the measured moments, (R, K)."""
    return simulate(law.rig, [(law, 1.0)], path) - simulate(law.rig, [], path)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_changes_nothing_at_strength_0_and_more_the_stronger_it_is(name: str) -> None:
    """On rigs that can have it a law's change is finite, none at 0, grows with the strength, and can be seen."""
    half, kind = LAWS[name]
    shown = 0
    for rig_kind in quickest(half):
        rig, path = case(half.name, rig_kind)
        if not kind.needs <= has(rig, path):
            continue
        law, _ = law_on(name, rig_kind)
        shapes = (simulate(rig, [(law, s)], path) for s in (0.0, 0.3, 1.0, 2.0, 4.0))
        sizes = [np.sqrt(np.mean((shape - untouched(half.name, rig_kind)) ** 2)) for shape in shapes]
        assert np.isfinite(sizes).all()
        assert sizes[0] < 1e-9
        assert (np.diff(sizes) >= -1e-9).all(), (rig_kind, sizes)
        assert sizes[4] > sizes[2] or sizes[4] == 0, (rig_kind, sizes)
        shown += sizes[2] > rig.noise
        if shown == 2:
            break
    assert shown == 2


@pytest.mark.parametrize("name", LAWS)
def test_a_law_is_the_same_law_each_time(name: str) -> None:
    """All chance is in the making: a law does the same when asked again, and another seed makes another one."""
    half, kind = LAWS[name]
    rig_kind = next(k for k in quickest(half) if kind.needs <= has(*case(half.name, k)))
    (one, path), (same, _), (other, _) = (law_on(name, rig_kind, seed) for seed in (5, 5, 6))
    first, again, also, another = (simulate(law.rig, [(law, 1.0)], path) for law in (one, one, same, other))
    assert np.array_equal(first, again)
    assert np.array_equal(first, also)
    assert not np.array_equal(first, another)


@pytest.mark.parametrize("half", PORTIONS, ids=lambda half: half.name)
def test_every_effect_has_three_new_published_laws_and_four_more_have_no_effect(half: Half) -> None:
    """Each effect has three laws (of the seventh portion two) or more, each with its source, and a name of its own."""
    assert set(half.laws) == set(EFFECTS)
    for effect, laws in half.laws.items():
        assert len(laws) >= (2 if half is SEVENTH else 3)
        assert {law.effect for law in laws} == {effect}
    assert len(half.outside) >= 4
    assert not {law.effect for law in half.outside} & set(EFFECTS)
    assert all(re.search(r"\b(16|17|18|19|20)\d\d\b", law.__doc__ or "") for law in laws_of(half))
    older = (DEVELOPMENT, *PORTIONS[: PORTIONS.index(half)])
    new = {law.__name__ for law in laws_of(half)}
    assert not {law.__name__ for each in older for law in laws_of(each)} & new
    assert not {law.effect for each in older for law in each.outside} & {law.effect for law in half.outside}
    assert not {kind for each in older for kind in each.rigs} & set(half.rigs)


@pytest.mark.parametrize(
    "kind", [rig for half in PORTIONS for rig in half.rigs.values()], ids=lambda rig: rig.kind
)
def test_a_rig_rests_when_vented_and_moves_when_full(kind: type[Rig]) -> None:
    """Rigs by chance have matching shapes, rest when vented, give way by 1 when full, and move by many noises."""
    for seed in range(8):
        rig = kind(np.random.default_rng(seed))
        count = len(rig.chambers)
        assert rig.high_kpa.shape == rig.low_kpa.shape == (count,)
        assert (rig.low_kpa <= 0).all()
        assert np.allclose(rig.deflection(np.zeros((1, count))), 0)
        assert np.allclose(rig.deflection(rig.high_kpa[None]), 1)
        far = rig.settled(rig.high_kpa * np.array([[-0.1], [-3.0], [5.0]]))
        assert far.shape == (3, len(rig.observables))
        assert np.isfinite(far).all()
        assert np.abs(rig.settled(rig.high_kpa * np.eye(count)) - rig.at_rest).max() > 50 * rig.noise
        assert len({o.unit for o in rig.observables}) == 1
        if rig.rest_mm is not None:
            own = [3 * o.marker + o.axis for o in rig.observables]
            assert np.allclose(rig.rest_mm.ravel()[own], rig.at_rest)


@pytest.mark.parametrize(
    ("half", "chambers", "most", "units", "both_ways"),
    [
        (THIRD, {1, 12}, 100, {"mm", "N", "kPa", "deg"}, {"sheet"}),
        (FOURTH, {2, 8}, 90, {"mm", "N", "V", "deg"}, set()),
        (FIFTH, {1, 12}, 120, {"mm", "N", "dpt", "deg", "um/m"}, {"snake"}),
        (SIXTH, {1, 14}, 100, {"mm", "ml", "N m", "um", "deg"}, {"ray"}),
        (SEVENTH, {1, 12}, 80, {"mm", "l/min", "kPa"}, {"spine"}),
        (EIGHTH, {1, 12}, 100, {"mm", "N", "ml"}, {"tripod"}),
    ],
    ids=["third", "fourth", "fifth", "sixth", "seventh", "eighth"],
)
def test_rigs_are_as_unlike_as_laboratories(
    half: Half, chambers: set[int], most: int, units: set[str], both_ways: set[str]
) -> None:
    """From few chambers to many, from a number or two to a hundred, with and without markers, of several units."""
    drawn = [kind(np.random.default_rng(seed)) for kind in half.rigs.values() for seed in range(12)]
    assert chambers <= {len(rig.chambers) for rig in drawn}
    sizes = [len(rig.observables) for rig in drawn]
    assert min(sizes) <= 2
    assert most < max(sizes) <= 150
    assert {rig.observables[0].unit for rig in drawn} == units
    assert {rig.kind for rig in drawn if (rig.low_kpa < 0).any()} == both_ways


@pytest.mark.parametrize("design", [*DESIGNS, *CONFOUNDED_DESIGNS])
def test_a_rig_that_is_driven_both_ways_gets_set_points_of_both_signs(design: str) -> None:
    """Programmes stay between the limits, and where the lower ones are below zero they go there."""
    random, high, low = np.random.default_rng(2), np.array([20.0, 30.0]), np.array([-10.0, -30.0])
    plans = [make_plan(design, random, high, 30, min_kpa=low) for _ in range(4)]
    told = np.concatenate([np.array(plan.capture_kpa) for plan in plans])
    assert (told >= low - 1e-9).all()
    assert (told <= high + 1e-9).all()
    assert (told < -1.0).any()
    assert (told > 1.0).any()
    one_way = make_plan(design, random, high, 30)
    assert np.min(one_way.capture_kpa) >= 0


@pytest.mark.parametrize("name", CLASSES)
@pytest.mark.parametrize("half", PORTIONS, ids=lambda half: half.name)
def test_a_campaign_of_each_class_is_drawn_from_one_portion(half: Half, name: str) -> None:
    """Campaigns of every class have rigs and laws of their portion alone, as large as the class says."""
    kind = CLASSES[name]
    for seed in range(2):
        campaign = draw(name, seed, half.name, captures=24)
        truth = campaign.truth
        assert truth["half"] == half.name
        assert truth["rig"] in half.rigs
        assert set(truth["laws"]) <= {law.__name__ for law in laws_of(half)}
        assert len(truth["effects"]) == kind.effects
        for floors in truth["amplitudes"].values():
            assert 0.97 * kind.floors[0] < floors < 1.03 * kind.floors[1]
        data, rig = campaign.dataset, make_rig(truth["base"])
        np.testing.assert_array_equal(data["chamber_min"].values, rig.low_kpa)
        for part in (data, campaign.fresh):
            assert (part["commanded"].values >= part["chamber_min"].values - 1e-9).all()
            assert (part["commanded"].values <= part["chamber_max"].values + 1e-9).all()


@pytest.mark.parametrize("half", PORTIONS, ids=lambda half: half.name)
def test_the_development_half_is_drawn_from_as_before(half: Half) -> None:
    """Each portion has a name of its own to be drawn by, and none of it is in the development half."""
    assert half_of(half.name) is half
    assert not set(laws_of(DEVELOPMENT)) & set(laws_of(half))


# What single laws promise.


def _holds(path: Path) -> list[tuple[int, int]]:
    """First and last moment of each actuation that is held for ten seconds or more."""
    begins = np.flatnonzero(np.diff(path.event, prepend=-1))
    ends = np.append(begins[1:], len(path.event)) - 1
    late = [int(b + np.argmax(path.hold_s[b : e + 1] > 1.5)) for b, e in zip(begins, ends, strict=True)]
    return [(b, int(e)) for b, e in zip(late, ends, strict=True) if path.hold_s[e] - path.hold_s[b] > 10]


@pytest.mark.parametrize("name", named("leak"))
def test_a_leak_brings_a_held_pressure_nearer_to_the_rooms(name: str) -> None:
    """Within a hold a leak takes pressure away, or vacuum; only a pocket that is full gives some back to a chamber."""
    for rigs in (SEVERAL, OTHER):
        found, path = law_on(name, rigs, 1)
        left = found.pressure(path, path.kpa, 1.0)
        lost = [np.abs(left[e]) - np.abs(left[b]) for b, e in _holds(path)]
        high = np.abs(path.kpa).max()
        assert np.min(lost) < -0.02 * high
        assert np.max(lost) < 1e-3 * high or name == "HiddenPocket"


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


@pytest.mark.parametrize("name", named("creep"))
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


def test_a_filter_of_what_is_seen_has_caught_up_at_the_end_of_a_long_hold() -> None:
    """What the cameras' filter lags behind just after an actuation is hardly there fourteen seconds later."""
    found, path = law_on("OneEuroFilter", BENT, 1, captures=40)
    off, held_s = np.abs(change(found, path)).max(axis=1), path.hold_s[path.row]
    assert off[held_s < 3].max() > 3 * found.rig.noise
    assert off[held_s > 14].max() < 0.1 * off[held_s < 3].max()


@pytest.mark.parametrize("name", [name for name in named("delay") if name != "OneEuroFilter"])
def test_delay_is_over_at_the_end_of_a_long_hold(name: str) -> None:
    """What a delay changes just after an actuation is gone ten seconds later."""
    found, path = law_on(name, BENT, 1, captures=40)
    rig = found.rig
    deflection = found.wall(path, path.kpa, rig.deflection(found.pressure(path, path.kpa, 0.6)), 0.6)
    off = np.abs(deflection - rig.deflection(path.kpa)).max(axis=1)
    holds = _holds(path)
    assert max(off[b] for b, _ in holds) > 0.02
    assert max(off[e] for _, e in holds if path.hold_s[e] > 14) < 1e-3


@pytest.mark.parametrize("name", named("friction"))
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


REACHING = ("LinearCrosstalk", "PinholedSeptum", "BulgingPartition")
"""Laws of coupling by which what fills one chamber reaches another."""


@pytest.mark.parametrize("name", REACHING)
def test_what_fills_one_chamber_reaches_a_vented_one(name: str) -> None:
    """Some chamber that is vented gives way because another one is full."""
    found, path = law_on(name, SEVERAL, 1)
    rig, alone = found.rig, 0.95 * np.diag(found.rig.high_kpa)
    pressures = found.pressure(path, alone, 1.0)
    walls = found.wall(path, pressures, rig.deflection(pressures), 1.0)
    others = walls - np.diag(np.diag(walls))
    assert np.abs(others).max() > 0.01
    assert np.allclose(found.wall(path, 0 * alone, rig.deflection(0 * alone), 1.0), 0)


@pytest.mark.parametrize("name", [name for name in named("coupling") if name not in REACHING])
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


LATER = ("TripodKicked", "TurningAxisElsewhere")
"""Frames that are moved at one moment, or by the tilt."""


@pytest.mark.parametrize("name", LATER)
def test_a_frame_that_moves_later_moves_all_markers_as_one_body(name: str) -> None:
    """What moves is the frame: distances between markers stay; before the moment, or without a tilt, nothing moved."""
    found, path = law_on(name, SEVERAL, 1)
    rig = found.rig
    with_it, without = (simulate(rig, laws, path) for laws in ([(found, 1.0)], []))
    apart = [np.linalg.norm(np.diff(v.reshape(len(v), -1, 3), axis=1), axis=2) for v in (with_it, without)]
    np.testing.assert_allclose(*apart, rtol=1e-6, atol=1e-6 * np.abs(without).max())
    moved = np.abs(with_it - without).max(axis=1)
    assert moved.min() < 1e-9 < rig.noise < moved.max()


@pytest.mark.parametrize("name", [n for n in (*named("frame"), *named("rest_shape")) if n not in LATER])
def test_frames_and_rest_shapes_are_there_at_rest(name: str) -> None:
    """What is wrong with a frame or a rest shape is seen of the vented body too, and hardly depends on pressure."""
    found, path = law_on(name, BENT, 1)
    off = change(found, path)
    first = off[path.session[path.row] == 0]
    assert np.std(first, axis=0).max() < 0.5 * np.abs(first.mean(axis=0)).max()


def test_spectra_are_learnt_from_both_portions() -> None:
    """Of one campaign of each portion the spectra are those of both of its effects, and its own where alone."""
    (ours, ours_example), (theirs, theirs_example) = (
        drawn_example(5, half) for half in ("development", "third")
    )
    assert ours_example is not None
    assert theirs_example is not None
    assert ours != theirs
    both = learn_all({"development": [5], "third": [5]})
    assert both == learn_all({"development": [5]}) | learn_all({"third": [5]})
    assert {key.split()[0] for key in both} >= {ours, theirs}
