"""A half of the benchmark that is small, so that what is tested is the benchmark and not its rigs and laws."""

import numpy as np
import pytest

from labrig.arrays import Floats
from labrig.bench import _halves
from labrig.bench._nature import (
    Half,
    Law,
    Observable,
    Path,
    Rig,
    Setting,
)


class Pads(Rig):
    """Three chambers under five markers; the walls yield less and less."""

    kind = "pads"
    noise = 0.1

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = ("a", "b", "c")
        self.high_kpa = np.array([60.0, 50.0, 40.0])
        self.marker_names = tuple(f"m{k + 1}" for k in range(5))
        self.observables = tuple(
            Observable(f"{m}.{a}", "mm", k, axis)
            for k, m in enumerate(self.marker_names)
            for axis, a in enumerate("xyz")
        )
        self.rest_mm = random.uniform(0.0, 100.0, (5, 3))
        self.reach = random.normal(size=(3, 15)) * np.tile([1.0, 1.0, 6.0], 5)

    def deflection(self, kpa: Floats) -> Floats:
        x = kpa / self.high_kpa
        return 1.4 * x / (1.0 + 0.4 * np.abs(x))

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        return self.rest_mm.ravel() + deflection @ self.reach


class Cell(Pads):
    """One chamber that pushes on a load cell."""

    kind = "cell"
    noise = 0.2

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers, self.high_kpa = ("p",), np.array([60.0])
        self.observables, self.rest_mm, self.marker_names = (Observable("force", "N"),), None, ()
        self.reach = random.uniform(20.0, 40.0, (1, 1))

    def shape(self, deflection: Floats) -> Floats:
        return deflection @ self.reach


class Flat(Pads):
    """Two chambers, and four markers that a camera sees in its own plane, in pixels."""

    kind = "flat"
    noise = 0.3

    def __init__(self, random: np.random.Generator) -> None:
        super().__init__(random)
        self.chambers, self.high_kpa = ("a", "b"), np.array([60.0, 50.0])
        self.marker_names = self.marker_names[:4]
        self.rest_mm = random.uniform(0.0, 100.0, (4, 3)) * [1.0, 1.0, 0.0]
        self.observables = tuple(
            Observable(f"{m}.{a}", "px", k, axis)
            for k, m in enumerate(self.marker_names)
            for axis, a in enumerate("xy")
        )
        self.reach = 4.0 * random.normal(size=(2, 8))

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        return 5.0 * self.rest_mm[:, :2].ravel() + deflection @ self.reach


class Slow(Law):
    """Walls go on yielding, and forget (one Kelvin-Voigt element)."""

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self.tau_s = float(setting.random.uniform(10.0, 40.0))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        state, out = np.zeros(deflection.shape[1]), np.empty_like(deflection)
        for k, step in enumerate(np.diff(path.time_s, prepend=path.time_s[0])):
            state = deflection[k] + (state - deflection[k]) * np.exp(-step / self.tau_s)
            out[k] = deflection[k] + 0.2 * strength * state
        return out


class Gain(Law):
    """Regulators give a share too much."""

    effect = "regulator"

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * (1.0 + 0.1 * strength)


class Wander(Law):
    """What is seen moves along x with time."""

    effect = "drift"
    needs = frozenset({"markers"})

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        along = np.array([o.axis == 0 for o in self.rig.observables])
        return values + strength * np.outer(path.time_s / 600.0, along)


class Weight(Law):
    """The markers sag along y where the base is turned."""

    effect = "gravity"
    needs = frozenset({"tilt", "markers"})

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        along = np.array([o.axis == 1 for o in self.rig.observables])
        return values + strength * np.outer(np.sin(np.radians(path.tilt_deg)), along)


class Tired(Law):
    """Every actuation leaves the walls a little softer."""

    effect = "fatigue"

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection * (1.0 + 0.1 * strength * (path.event / max(path.event[-1], 1))[:, None])


def bent(rig: Rig, random: np.random.Generator):
    """A base whose chambers follow another curve."""
    turn = random.uniform(0.2, 0.4, len(rig.chambers))

    def predict(kpa: Floats, how_wrong: float) -> Floats:
        x = np.clip(kpa / rig.high_kpa, 0.0, 1.0)
        return rig.settled(kpa * (1.0 + 0.2 * how_wrong * turn * (x - 0.5)))

    return predict


STUB = Half(
    "development",
    {"pads": Pads, "cell": Cell, "flat": Flat},
    {"creep": [Slow], "regulator": [Gain], "drift": [Wander], "gravity": [Weight]},
    [Tired],
    {"bent": bent},
)


@pytest.fixture(autouse=True)
def _small_half(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests of this folder draw from the small half, whichever they ask for."""
    monkeypatch.setitem(_halves.LOADED, "development", STUB)
    monkeypatch.setitem(_halves.LOADED, "exam", STUB)
