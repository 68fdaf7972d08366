"""What natures are made of: rigs that respond to pressure, and the laws that they obey in secret.

The two halves of the benchmark, `development` and `exam`, fill these classes with rigs and laws of their own and share
nothing but this page. A campaign is simulated in four steps, each of which a law may change:

    commanded --valve--> kpa --Law.pressure--> kpa --Rig.deflection--> deflection --Law.wall--> deflection
              --Rig.shape--> values --Law.seen--> values
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from labrig.arrays import Floats, Ints


@dataclass(frozen=True)
class Observable:
    """One measured number: its name, its unit, and, of a marker, which one (index) and along which axis (0, 1, 2)."""

    name: str
    unit: str
    marker: int = -1
    axis: int = -1


class Rig(ABC):
    """A body that pressures deform at once, without memory: what remains when nothing is hidden.

    A subclass draws its own proportions from `random`, and sets: `chambers`, `high_kpa` (C,) the upper limits (the
    lower ones, `low_kpa`, are zero unless it says otherwise), `observables`, `rest_mm` (M, 3) where the markers are at
    rest (None without markers), `marker_names`, and `noise`, the usual noise of one row in the units of the
    observables. Observables may have several units; where some are measured better than others, `noisier` says so.
    """

    kind: ClassVar[str]
    chambers: tuple[str, ...]
    high_kpa: Floats
    observables: tuple[Observable, ...]
    marker_names: tuple[str, ...] = ()
    rest_mm: Floats | None = None
    noise: float
    noisier: Floats | float = 1.0
    """How many times the usual noise each observable (K,) has: root mean square 1."""

    @abstractmethod
    def __init__(self, random: np.random.Generator) -> None: ...

    @property
    def low_kpa(self) -> Floats:
        """The lower limits (C,): zero, or below it where a rig is driven both ways."""
        return np.zeros(len(self.chambers))

    @abstractmethod
    def deflection(self, kpa: Floats) -> Floats:
        """How far each chamber's wall gives way, (T, C) from pressures (T, C): 0 at rest, about 1 at full pressure.

        It must take any finite pressure, a little below zero and above the limit too, as the physics would.
        """

    @abstractmethod
    def shape(self, deflection: Floats) -> Floats:
        """The observables (T, K) of deflections (T, C)."""

    def settled(self, kpa: Floats) -> Floats:
        """The observables (T, K) under pressures (T, C), with nothing hidden."""
        return self.shape(self.deflection(np.asarray(kpa, dtype=float)))

    @property
    def at_rest(self) -> Floats:
        """The observables (K,) of the vented rig."""
        return self.settled(np.zeros((1, len(self.chambers))))[0]


@dataclass(frozen=True)
class Path:
    """What was done to a rig, at T moments in order: fine around each actuation, coarser along the holds.

    `commanded_kpa` (T, C) steps at each actuation; `kpa` (T, C) is what the valves let follow within about half a
    second; `event` (T,) numbers the actuations, `hold_s` (T,) is the time since the last one; `session` (T,) numbers
    the sessions, `session_s` (T,) is the time since the session's first actuation; `tilt_deg` (T,) how far the base
    is turned about x; `payload_kg` (T,) what hangs on the rig; `row` (R,) which of the moments are measured.
    """

    time_s: Floats
    commanded_kpa: Floats
    kpa: Floats
    event: Ints
    hold_s: Floats
    session: Ints
    session_s: Floats
    tilt_deg: Floats
    payload_kg: Floats
    row: Ints


@dataclass(frozen=True)
class Setting:
    """What a law knows when it draws its own parameters: the rig, the campaign to come, and chance."""

    rig: Rig
    path: Path
    random: np.random.Generator


class Law(ABC):
    """One law of nature, with parameters of its own drawn by chance when it is made.

    A subclass says in its docstring which law it is and where it is published; `effect` is the name by which it goes
    (one of EFFECTS, or, for what no list of usual suspects has, a name of its own). It changes one step or more of the
    simulation; `strength` multiplies what it changes: 0 nothing, 1 its natural size. The benchmark finds the strength
    at which the change of the observables, root mean square over all rows, each over its own noise, has the wanted
    size, so the change should grow steadily with it, and keep its character up to several times 1.
    """

    effect: ClassVar[str]
    needs: ClassVar[frozenset[str]] = frozenset()
    """What a rig must have: some of `markers` (three or more), `marker` (one at least), `angle`, `force` (a sensor in
    deg, in N), `several` (chambers), `curved` (a deflection that is not proportional to pressure, so that e.g. a
    tension is no mere gain), `holds` (long ones), `tilt`, `payload`."""

    def __init__(self, setting: Setting) -> None:
        self.rig = setting.rig

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """What the chambers get, (T, C), instead of `kpa`."""
        return kpa

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """How far the walls give way, (T, C), instead of `deflection`, which the true pressures `kpa` would make."""
        return deflection

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """What is there to be measured, (T, K), instead of `values`, at the walls' `deflection` (T, C)."""
        return values


EFFECTS = (
    "hysteresis",
    "creep",
    "regulator",
    "leak",
    "coupling",
    "stiffening",
    "gravity",
    "drift",
    "contact",
    "marker_slip",
    "frame",
    "delay",
    "friction",
    "rest_shape",
    "tension",
)
"""The effects that the library names."""

WrongForm = Callable[[Rig, np.random.Generator], Callable[[Floats, float], Floats]]
"""Makes, for a rig, a base that is wrong in form: (kpa (T, C), how wrong) -> values (T, K); at 0 it is exact."""


@dataclass(frozen=True)
class Half:
    """One half of the benchmark: its rigs, its laws by effect, its laws outside the library, its wrong bases."""

    name: str
    rigs: Mapping[str, type[Rig]]
    laws: Mapping[str, Sequence[type[Law]]]
    outside: Sequence[type[Law]]
    wrong: Mapping[str, WrongForm]


def simulate(rig: Rig, laws: Sequence[tuple[Law, float]], path: Path) -> Floats:
    """The observables (R, K) at the measured moments, under laws each with its strength."""
    kpa = path.kpa
    for law, strength in laws:
        kpa = law.pressure(path, kpa, strength)
    deflection = rig.deflection(kpa)
    for law, strength in laws:
        deflection = law.wall(path, kpa, deflection, strength)
    values = rig.shape(deflection)
    for law, strength in laws:
        values = law.seen(path, deflection, values, strength)
    return values[path.row]
