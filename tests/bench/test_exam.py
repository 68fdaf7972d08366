"""The exam half: its laws are silent at strength 0, grow with it, name their sources, and know no diagnosis."""

import ast
import re
from functools import cache
from pathlib import Path as File

import numpy as np
import pytest

from labrig.bench._nature import EFFECTS, Law, Path, Rig, Setting, simulate
from labrig.bench.exam import EXAM

LAWS = [law for laws in EXAM.laws.values() for law in laws] + list(EXAM.outside)
FORBIDDEN = ("labrig.effects", "labrig.diagnosis", "labrig.bench.development", "labrig_drivers")


@cache
def rig_of(kind: str) -> Rig:
    """A rig of a kind, always the same."""
    return EXAM.rigs[kind](np.random.default_rng(3))


def path_of(
    rig: Rig, actuations: int = 40, step_s: tuple[float, ...] = (0.0, 0.1, 0.25, 0.5, 1.0, 1.6)
) -> Path:
    """Two sessions of random actuations: a fine grid after each, a measured row at 1.6 s and at the end of its hold."""
    random, chambers = np.random.default_rng(5), len(rig.chambers)
    time_s, told, got, event, hold_s, session, row = [], [], [], [], [], [], []
    now_s, before = 0.0, np.zeros(chambers)
    for number in range(actuations):
        if number == actuations // 2:
            now_s, before = now_s + 600.0, np.zeros(chambers)
        target = rig.high_kpa * random.uniform(0, 1, chambers) * (random.random(chambers) < 0.7)
        held_s = 60.0 if number % 8 == 5 else random.uniform(3.5, 7.0)
        for since_s in (*step_s, *np.linspace(2.0, held_s, 6)):
            time_s.append(now_s + since_s)
            told.append(target)
            got.append(target + (before - target) * np.exp(-since_s / 0.12))
            event.append(number)
            hold_s.append(since_s)
            session.append(int(number >= actuations // 2))
        row += [len(time_s) - 7, len(time_s) - 1]
        now_s, before = now_s + held_s + 0.05, target
    time, which = np.array(time_s), np.array(session)
    start_s = np.array([time[which == one][0] for one in which])
    turned = np.array(event) % 5
    return Path(
        time_s=time, commanded_kpa=np.array(told), kpa=np.array(got), event=np.array(event), hold_s=np.array(hold_s),
        session=which, session_s=time - start_s, tilt_deg=10.0 * turned - 20.0, payload_kg=0.05 * (turned % 3),
        row=np.array(row),
    )  # fmt: skip


@cache
def case_of(law: type[Law], kind: str, seed: int = 7) -> tuple[Rig, Path, Law]:
    """A rig, a path and a law of it."""
    rig = rig_of(kind)
    path = path_of(rig)
    return rig, path, law(Setting(rig, path, np.random.default_rng(seed)))


def change(case: tuple[Rig, Path, Law], strength: float) -> np.ndarray:
    """What a law changes of the observables at a strength."""
    rig, path, law = case
    return simulate(rig, [(law, strength)], path) - simulate(rig, [], path)


CASES = [(law, kind) for law in LAWS for kind in EXAM.rigs]


@pytest.mark.parametrize(("law", "kind"), CASES, ids=lambda one: getattr(one, "__name__", one))
def test_law_grows_from_nothing(law: type[Law], kind: str) -> None:
    """At strength 0 a law changes exactly nothing, and from there on ever more, always finite."""
    case = case_of(law, kind)
    assert np.array_equal(change(case, 0.0), np.zeros_like(change(case, 0.0)))
    sizes = [float(np.sqrt((change(case, strength) ** 2).mean())) for strength in (0.1, 0.3, 1.0, 2.0, 4.0)]
    assert np.isfinite(sizes).all()
    assert sizes[0] > 0
    assert (np.diff(sizes) > 0).all(), sizes


@pytest.mark.parametrize("law", LAWS, ids=lambda one: one.__name__)
def test_law_is_deterministic(law: type[Law]) -> None:
    """A law made twice from the same chance does the same, and doing it leaves no trace in it or in the path."""
    case = case_of(law, "arm")
    first = change(case, 1.0)
    again = law(Setting(case[0], case[1], np.random.default_rng(7)))
    assert np.array_equal(change(case, 1.0), first)
    assert np.array_equal(change((case[0], case[1], again), 1.0), first)


@pytest.mark.parametrize("effect", EFFECTS)
def test_every_effect_has_two_laws_with_sources(effect: str) -> None:
    """Every effect of the library has two laws or more, and each names the year in which it was published."""
    laws = EXAM.laws[effect]
    assert len(laws) >= 2
    assert all(law.effect == effect and re.search(r"\b(18|19|20)\d\d\b", law.__doc__ or "") for law in laws)


def test_outside_laws_have_names_of_their_own() -> None:
    """At least four laws lie outside the library, under other names than its effects."""
    names = {law.effect for law in EXAM.outside}
    assert len(names) >= 4
    assert not names & set(EFFECTS)


@pytest.mark.parametrize("kind", list(EXAM.rigs))
def test_rig_is_whole(kind: str) -> None:
    """A rig is at rest without pressure, about 1 at its limits, finite a little below zero, and has one unit."""
    rig = rig_of(kind)
    assert np.allclose(rig.deflection(np.zeros((1, len(rig.chambers)))), 0)
    assert np.allclose(rig.deflection(rig.high_kpa[None]), 1)
    assert np.isfinite(rig.settled(-0.05 * rig.high_kpa[None])).all()
    assert len({seen.unit for seen in rig.observables}) == 1
    assert rig.rest_mm is not None
    assert rig.rest_mm.shape == (len(rig.marker_names), 3)


@pytest.mark.parametrize("kind", list(EXAM.rigs))
@pytest.mark.parametrize("name", list(EXAM.wrong))
def test_wrong_base_is_wrong_by_choice(kind: str, name: str) -> None:
    """A wrong base is exact at 0, and ever more wrong above."""
    rig = rig_of(kind)
    kpa = path_of(rig).kpa
    base = EXAM.wrong[name](rig, np.random.default_rng(1))
    assert np.array_equal(base(kpa, 0.0), rig.settled(kpa))
    sizes = [float(np.abs(base(kpa, much) - rig.settled(kpa)).mean()) for much in (0.3, 1.0, 2.0)]
    assert 0 < sizes[0] < sizes[1] < sizes[2]


def test_exam_knows_no_diagnosis() -> None:
    """No file of the exam imports the library of effects, the diagnosis, the development half or the drivers."""
    files = list(File(__file__).parents[2].glob("labrig/bench/exam/*.py"))
    assert len(files) > 5
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith(FORBIDDEN)], file
