"""The portions of the development half: their rigs and laws do what they promise, and each is drawn from apart."""

import re

import numpy as np
import pytest

from labrig.bench import CLASSES, draw, half_of, make_rig
from labrig.bench import PORTIONS as NAMES
from labrig.bench._hide import has
from labrig.bench._learn import drawn_example, learn_all
from labrig.bench._nature import (
    EFFECTS,
    Half,
    Rig,
    simulate,
)
from labrig.bench._programmes import CONFOUNDED_DESIGNS, DESIGNS, make_plan
from labrig.bench.development import DEVELOPMENT
from tests.bench.portions import LAWS, PORTIONS, case, law_on, laws_of, quickest, untouched

THIRD, FOURTH, FIFTH, SIXTH, SEVENTH, EIGHTH, NINTH, TENTH, ELEVENTH, TWELFTH = PORTIONS


@pytest.mark.parametrize("name", LAWS)
def test_a_law_changes_nothing_at_strength_0_and_more_the_stronger_it_is(name: str) -> None:
    """On rigs that can have it a law's change is finite, none at 0, grows with the strength, and can be seen; all
    chance is in the making: a law does the same when asked again, and another seed makes another one.
    """
    half, kind = LAWS[name]
    shown = 0
    for rig_kind in (k for k in quickest(half) if kind.needs <= has(*case(half.name, k))):
        rig, path = case(half.name, rig_kind)
        law, _ = law_on(name, rig_kind)
        strengths = (1.0, 4.0) if shown else (0.0, 1.0, 4.0)
        shapes = [simulate(rig, [(law, s)], path) for s in strengths]
        sizes = [np.sqrt(np.mean((shape - untouched(half.name, rig_kind)) ** 2)) for shape in shapes]
        assert np.isfinite(sizes).all()
        assert sizes[0] < 1e-9 or shown
        assert sizes[-1] > sizes[-2] or sizes[-1] == 0, (rig_kind, sizes)
        if not shown:
            (same, _), (other, _) = law_on(name, rig_kind), law_on(name, rig_kind, seed=6)
            again, also, another = (simulate(each.rig, [(each, 1.0)], path) for each in (law, same, other))
            assert np.array_equal(shapes[1], again)
            assert np.array_equal(shapes[1], also)
            assert not np.array_equal(shapes[1], another)
        shown += sizes[-2] > rig.noise
        if shown == 2:
            break
    assert shown == (1 if "marker" in kind.needs else 2)  # of few sensors hardly any is a marker


@pytest.mark.parametrize("half", PORTIONS, ids=lambda half: half.name)
def test_every_effect_has_three_new_published_laws_and_four_more_have_no_effect(half: Half) -> None:
    """Each effect has three laws (of four portions two) or more, each with its source, and a name of its own."""
    assert set(half.laws) == set(EFFECTS)
    for effect, laws in half.laws.items():
        assert len(laws) >= (2 if half in (SEVENTH, TENTH, ELEVENTH, TWELFTH) else 3)
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
        assert np.mean(np.square(rig.noisier)) == pytest.approx(1.0)
        if rig.rest_mm is not None:
            own = [(k, 3 * o.marker + o.axis) for k, o in enumerate(rig.observables) if o.marker >= 0]
            seen, where = np.transpose(own)
            assert np.allclose(rig.rest_mm.ravel()[where], rig.at_rest[seen])


@pytest.mark.parametrize("kind", TWELFTH.rigs.values(), ids=lambda rig: rig.kind)
def test_few_sensors_of_several_units_each_see_the_rig_move(kind: type[Rig]) -> None:
    """Two to eight sensors of two or three units, each of which goes far beyond its own noise in random poses."""
    for seed in range(8):
        rig = kind(np.random.default_rng(seed))
        assert 2 <= len(rig.observables) <= 8
        assert 2 <= len({o.unit for o in rig.observables}) <= 3
        assert len(rig.marker_names) <= 2
        kpa = np.random.default_rng(1).uniform(rig.low_kpa, rig.high_kpa, (200, len(rig.chambers)))
        assert (rig.settled(kpa).std(axis=0) > 5 * rig.noise * rig.noisier).all()
        noises = rig.noise * np.broadcast_to(rig.noisier, len(rig.observables))
        assert len({(o.unit, round(n, 12)) for o, n in zip(rig.observables, noises, strict=True)}) == len(
            {o.unit for o in rig.observables}
        )


@pytest.mark.parametrize(
    ("half", "chambers", "numbers", "units", "both_ways"),
    [
        (THIRD, {1, 12}, (2, 100), {"mm", "N", "kPa", "deg"}, {"sheet"}),
        (FOURTH, {2, 8}, (2, 90), {"mm", "N", "V", "deg"}, set()),
        (FIFTH, {1, 12}, (2, 120), {"mm", "N", "dpt", "deg", "um/m"}, {"snake"}),
        (SIXTH, {1, 14}, (2, 100), {"mm", "ml", "N m", "um", "deg"}, {"ray"}),
        (SEVENTH, {1, 12}, (2, 80), {"mm", "l/min", "kPa"}, {"spine"}),
        (EIGHTH, {1, 12}, (2, 100), {"mm", "N", "ml"}, {"tripod"}),
        (NINTH, {2, 8}, (2, 80), {"mm", "deg"}, {"blown_dome"}),
        (TENTH, {3, 9}, (30, 80), {"mm"}, {"wheel"}),
        (ELEVENTH, {2, 12}, (2, 50), {"mm", "%"}, {"tail"}),
        (TWELFTH, {1, 4}, (2, 7), {"deg", "N", "mm", "1/m"}, {"hoist"}),
    ],
    ids=NAMES,
)
def test_rigs_are_as_unlike_as_laboratories(
    half: Half, chambers: set[int], numbers: tuple[int, int], units: set[str], both_ways: set[str]
) -> None:
    """From few chambers to many, from a number or two to a hundred, with and without markers, of several units."""
    drawn = [kind(np.random.default_rng(seed)) for kind in half.rigs.values() for seed in range(12)]
    assert chambers <= {len(rig.chambers) for rig in drawn}
    sizes = [len(rig.observables) for rig in drawn]
    fewest, most = numbers
    assert min(sizes) <= fewest
    assert most < max(sizes) <= 150
    assert {o.unit for rig in drawn for o in rig.observables} == units
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
    campaign = draw(name, 1, half.name, captures=24)
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
