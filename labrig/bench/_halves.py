"""The halves of the benchmark by name, and rigs from plain data."""

from importlib import import_module

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.bench._nature import Half, Rig
from labrig.bench.records import RigRecipe

HALVES = ("development", "exam")
PORTIONS = {
    "third": "labrig.bench.development.third",
    "fourth": "labrig.bench.development.fourth",
    "fifth": "labrig.bench.development.fifth",
    "sixth": "labrig.bench.development.sixth",
    "seventh": "labrig.bench.development.seventh",
    "eighth": "labrig.bench.development.eighth",
    "ninth": "labrig.bench.development.ninth",
    "tenth": "labrig.bench.development.tenth",
    "eleventh": "labrig.bench.development.eleventh",
    "twelfth": "labrig.bench.development.twelfth",
}
"""Portions of a half that are drawn from apart, by name, and where they are."""
DRAWN_FROM = (*HALVES, *PORTIONS)
LOADED: dict[str, Half] = {}
"""Halves that are in use; others are imported when they are asked for."""


def half_of(name: str) -> Half:
    """The half, or the portion, of that name."""
    if name not in LOADED:
        if name not in DRAWN_FROM:
            raise LabrigError(f"bench: there is no half '{name}' (known: {', '.join(DRAWN_FROM)})")
        LOADED[name] = getattr(import_module(PORTIONS.get(name, f"labrig.bench.{name}")), name.upper())
    return LOADED[name]


def make_rig(recipe: RigRecipe) -> Rig:
    """The rig of a recipe {half, rig, rig_seed, linear}; with `linear`, a map of degree 1 is the whole of it."""
    half = half_of(recipe["half"])
    if recipe["rig"] not in half.rigs:
        raise LabrigError(f"bench: the half {half.name} has no rig '{recipe['rig']}'")
    rig = half.rigs[recipe["rig"]](np.random.default_rng(recipe["rig_seed"]))
    return Linear(rig) if recipe.get("linear") else rig


class Linear(Rig):
    """A rig whose walls give way, and whose observables follow them, in proportion."""

    kind = "linear"

    def __init__(self, rig: Rig) -> None:
        self.kind = rig.kind  # pyright: ignore[reportAttributeAccessIssue]
        self.chambers, self.high_kpa = rig.chambers, rig.high_kpa
        self.observables, self.marker_names = rig.observables, rig.marker_names
        self.rest_mm, self.noise, self.noisier = rig.rest_mm, rig.noise, rig.noisier
        self._low_kpa = rig.low_kpa
        half = np.diag(0.5 * self.high_kpa)  # each chamber alone, half full
        walls = rig.deflection(half)
        self._give = np.linalg.solve(half, walls)
        self._rest = rig.at_rest
        self._reach = np.linalg.lstsq(walls, rig.shape(walls) - self._rest, rcond=None)[0]

    @property
    def low_kpa(self) -> Floats:
        """The lower limits (C,)."""
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        """How far each chamber's wall gives way, (T, C)."""
        return np.asarray(np.asarray(kpa, dtype=float) @ self._give, dtype=float)

    def shape(self, deflection: Floats) -> Floats:
        """The observables (T, K)."""
        return self._rest + deflection @ self._reach
