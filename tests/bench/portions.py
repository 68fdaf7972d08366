"""Rigs, campaigns and laws of the portions, as their tests share them."""

from functools import cache

import numpy as np

from labrig.arrays import Floats
from labrig.bench import PORTIONS as NAMES
from labrig.bench import half_of
from labrig.bench._nature import Half, Law, Path, Rig, Setting, simulate
from labrig.bench._path import make_path
from labrig.bench._programmes import make_plan

PORTIONS = tuple(half_of(name) for name in NAMES)


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
    "ninth": ("blown_dome", "two_segment_arm", "blown_dome", "two_segment_arm"),
    "tenth": ("wheel", "fan", "cilia", "fan"),
    "eleventh": ("truss", "honeycomb", "lantern", "lantern"),
    "twelfth": ("elbow", "clasp", "hoist", "fingertip"),
}
SEVERAL, OTHER, BENT, RUBS = ({half: kinds[i] for half, kinds in _KINDS.items()} for i in range(4))
"""Rigs of each portion: one with six chambers or more, and markers (if it has such); another one; one whose walls are
bent; one for friction.
"""
WITH_A_MARKER = {"twelfth": "neck"}
"""Rigs of portions in which hardly any have one."""


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
