"""The development half of the benchmark: its laws do what a law promises, on rigs that are as they should be."""

import re
from functools import cache

import numpy as np
import pytest

from labrig.arrays import Floats
from labrig.bench._nature import (
    EFFECTS,
    Law,
    Path,
    Rig,
    Setting,
    simulate,
)
from labrig.bench.development import DEVELOPMENT
from labrig.bench.development._story import as_chain
from labrig.bench.development.rigs import Finger, Muscle, Plate, Shell

LAWS = [law for laws in DEVELOPMENT.laws.values() for law in laws] + list(DEVELOPMENT.outside)
AFTER_S = np.array([0.0, 0.1, 0.2, 0.35, 0.6, 1.0, 1.6, 2.4, 3.6])


def make_path(rig: Rig, seed: int = 0) -> Path:
    """Two sessions of 20 actuations by chance, held for 5 s, every sixth for 50 s; valves of 0.12 s."""
    random = np.random.default_rng(seed)
    count = 40
    hold_s = np.where(np.arange(count) % 6 == 5, 50.0, 5.0)
    begin_s = np.cumsum(hold_s) - hold_s + np.where(np.arange(count) >= 20, 300.0, 0.0)
    target = rig.high_kpa * random.uniform(0, 1, (count, len(rig.high_kpa)))
    target *= random.random(target.shape) < 0.6
    target[19] = 0.0
    hold_s[19] += 300.0
    age = [np.append(AFTER_S, np.geomspace(5, h - 1, 8)) if h > 10 else AFTER_S for h in hold_s]
    event = np.repeat(np.arange(count), [len(a) for a in age])
    hold = np.concatenate(age)
    start = np.vstack([np.zeros_like(target[:1]), target[:-1]])
    session = event // 20
    time_s = begin_s[event] + hold
    return Path(
        time_s=time_s,
        commanded_kpa=target[event],
        kpa=target[event] + (start - target)[event] * np.exp(-hold / 0.12)[:, None],
        event=event,
        hold_s=hold,
        session=session,
        session_s=time_s - begin_s[[0, 20]][session],
        tilt_deg=np.where(session == 0, 0.0, 30.0),
        payload_kg=np.where(session == 0, 0.0, 0.2),
        row=np.flatnonzero((hold >= 1.6) & (hold < 100)),
    )


def rigs() -> list[Rig]:
    """One rig of each kind that several chambers and markers have, and muscles of one and of two chambers."""
    muscles = [Muscle(np.random.default_rng(seed)) for seed in range(20)]
    few: list[Rig] = [next(m for m in muscles if len(m.chambers) == count) for count in (1, 2)]
    return [*(kind(np.random.default_rng(3)) for kind in (Shell, Plate, Finger)), *few]


RIGS = rigs()


def fits(law: type[Law], rig: Rig) -> bool:
    lacks = set() if rig.rest_mm is not None else {"markers"}
    return not law.needs & (lacks | (set() if len(rig.chambers) > 1 else {"several"}))


@cache
def untouched(number: int) -> tuple[Path, Floats]:
    """A campaign on one of `RIGS`, and what the rig shows in it without any law."""
    rig = RIGS[number]
    path = make_path(rig)
    return path, simulate(rig, [], path)


@pytest.mark.parametrize("kind", LAWS, ids=lambda law: law.__name__)
def test_a_law_changes_nothing_at_strength_0_and_more_the_stronger_it_is(kind: type[Law]) -> None:
    """A law's change is finite, and grows with its strength from nothing; some begin at a threshold.

    On a rig that hardly shows it (chambers that oppose each other bulge under no neighbour) it may do nothing.
    """
    shown = 0
    for number, rig in enumerate(RIGS):
        if fits(kind, rig):
            path, bare = untouched(number)
            law = kind(Setting(rig, path, np.random.default_rng(11)))
            shapes = (simulate(rig, [(law, s)], path) for s in (0.0, 0.3, 1.0, 2.0, 4.0))
            sizes = [np.sqrt(np.mean((shape - bare) ** 2)) for shape in shapes]
            assert np.isfinite(sizes).all()
            assert sizes[0] < 1e-9
            assert (np.diff(sizes) >= 0).all(), (rig.kind, sizes)
            assert sizes[4] > sizes[2] or sizes[4] == 0, (rig.kind, sizes)
            shown += sizes[4] > 0
    assert shown


@pytest.mark.parametrize("kind", LAWS, ids=lambda law: law.__name__)
def test_a_law_is_the_same_law_each_time(kind: type[Law]) -> None:
    """All chance is in the making: a law does the same when asked again, and one made of the same seed does too."""
    rig = next(r for r in RIGS if fits(kind, r))
    path = make_path(rig)
    one, other = (kind(Setting(rig, path, np.random.default_rng(5))) for _ in range(2))
    first = simulate(rig, [(one, 1.0)], path)
    assert np.array_equal(first, simulate(rig, [(one, 1.0)], path))
    assert np.array_equal(first, simulate(rig, [(other, 1.0)], path))
    assert not np.array_equal(
        first, simulate(rig, [(kind(Setting(rig, path, np.random.default_rng(6))), 1.0)], path)
    )


def test_every_effect_has_three_published_laws_and_four_more_have_no_effect() -> None:
    """Each effect has three laws or more under its own name, each with its source; four or more are outside."""
    assert set(DEVELOPMENT.laws) == set(EFFECTS)
    for effect, laws in DEVELOPMENT.laws.items():
        assert len(laws) >= 3
        assert {law.effect for law in laws} == {effect}
    assert len(DEVELOPMENT.outside) >= 4
    assert not {law.effect for law in DEVELOPMENT.outside} & set(EFFECTS)
    assert all(re.search(r"\b(16|17|18|19|20)\d\d\.", law.__doc__ or "") for law in LAWS)


@pytest.mark.parametrize("kind", DEVELOPMENT.rigs.values(), ids=lambda rig: rig.kind)
def test_a_rig_rests_when_vented_and_moves_when_full(kind: type[Rig]) -> None:
    """Rigs by chance have matching shapes, rest when vented, give way by 1 when full, and move by many noises."""
    for seed in range(12):
        rig = kind(np.random.default_rng(seed))
        count = len(rig.chambers)
        assert rig.high_kpa.shape == (count,)
        assert np.allclose(rig.deflection(np.zeros((1, count))), 0)
        assert np.allclose(rig.deflection(rig.high_kpa[None]), 1)
        low = rig.settled(-0.1 * rig.high_kpa[None])
        assert low.shape == (1, len(rig.observables))
        assert np.isfinite(low).all()
        assert np.abs(rig.settled(rig.high_kpa * np.eye(count)) - rig.at_rest).max() > 50 * rig.noise
        if rig.rest_mm is not None:
            assert np.allclose(rig.rest_mm.ravel(), rig.at_rest)


@pytest.mark.parametrize("name", DEVELOPMENT.wrong)
def test_a_wrong_base_is_right_at_0_and_ever_more_wrong(name: str) -> None:
    """A base that is wrong in form is exact at 0, and its error grows with how wrong it is, on every rig."""
    for rig in RIGS:
        kpa = make_path(rig).kpa
        base = DEVELOPMENT.wrong[name](rig, np.random.default_rng(2))
        sizes = [
            np.sqrt(np.mean((base(kpa, wrong) - rig.settled(kpa)) ** 2)) for wrong in (0.0, 0.2, 0.5, 1.0)
        ]
        assert sizes[0] < 1e-12
        assert (np.diff(sizes) > 0).all()


def test_a_chain_follows_its_compliance() -> None:
    """Chains of elements follow power laws of every steepness from a second on, and yield 1 in a minute."""
    time_s = np.geomspace(0.1, 4000, 80)
    random = np.random.default_rng(0)
    for begins_s, power in zip(10 ** random.uniform(-1, 1, 40), random.uniform(-0.5, 0.8, 40), strict=True):
        compliance = ((1 + time_s / begins_s) ** power - 1) / power
        tau_s, yields = as_chain(compliance, time_s)
        assert (yields > 0).all()
        expected = compliance / np.interp(60.0, time_s, compliance)
        chain, late = -np.expm1(-time_s[:, None] / tau_s) @ yields, time_s > 1
        assert chain[late] == pytest.approx(expected[late], abs=0.03 * expected[-1])
