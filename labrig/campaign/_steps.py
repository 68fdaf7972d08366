"""What a procedure yields, and what it gets back: small frozen values, no devices."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from numbers import Real
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.run_contents import Advice


class StepError(LabrigError):
    """A step was made of what it can't be made of; the message says of what."""


@dataclass(frozen=True)
class Step:
    """One thing to do; see the subclasses."""

    kind: ClassVar[str] = ""

    def __post_init__(self) -> None:
        """A time without an end would hold the pressures for ever: raises `LabrigError`, as of what is no time.

        Numbers of NumPy's become plain ones, and what stands for a text becomes one: a step is kept in the log.
        """
        for name in ("duration_s", "timeout_s"):
            time_s = getattr(self, name, 0.0)
            if not isinstance(time_s, Real) or not 0 <= float(time_s) < math.inf:
                raise StepError(
                    f"{type(self).__name__}({name}={time_s!r}): give a time in s that ends, 0 or more"
                )
            if not isinstance(time_s, int | float):
                object.__setattr__(self, name, float(time_s))
        for name in ("label", "repeat"):
            given = getattr(self, name, "")
            if not isinstance(given, str | int | float | None):
                object.__setattr__(self, name, str(given))

    def to_dict(self) -> dict[str, Any]:
        """The step as plain values, its kind first."""
        return {"kind": self.kind, **asdict(self)}


@dataclass(frozen=True)
class Actuate(Step):
    """Bring the chambers to `pressure_kpa`, shape (C,), in the rig's order; answered by `Actuated`.

    The way there respects each chamber's slew limit. The runner does not wait for the pressures to arrive.
    """

    kind: ClassVar[str] = "actuate"
    pressure_kpa: Sequence[float] | Floats
    label: str = ""

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "pressure_kpa", tuple(float(value) for value in self.pressure_kpa))
        except (TypeError, ValueError):
            raise StepError(
                f"Actuate({self.pressure_kpa!r}): give numbers in kPa in the rig's order of chambers; "
                "rig.setpoint(c1=30) makes them of names"
            ) from None
        super().__post_init__()


@dataclass(frozen=True)
class Settle(Step):
    """Wait `duration_s` while everything is logged; answered by `Settled`, which says how still it became."""

    kind: ClassVar[str] = "settle"
    duration_s: float = 3.0


@dataclass(frozen=True)
class Record(Step):
    """Record for `duration_s`: one capture; answered by `Recording`.

    Captures with the same non-empty `repeat` are repeats of one set-point. The pressures must hold through the
    recording; where they may `sag`, because that is what one wants to see, only its beginning is checked.
    """

    kind: ClassVar[str] = "record"
    duration_s: float = 1.0
    repeat: str = ""
    label: str = ""
    sag: bool = False


@dataclass(frozen=True)
class Scan(Step):
    """Take a 3D scan, waiting `timeout_s` for it at most; answered by `Scanned`."""

    kind: ClassVar[str] = "scan"
    timeout_s: float = 120.0
    label: str = ""


@dataclass(frozen=True)
class Note(Step):
    """Write a line into the log; answered by None."""

    kind: ClassVar[str] = "note"
    text: str

    def __post_init__(self) -> None:
        if not isinstance(self.text, str):
            object.__setattr__(self, "text", str(self.text))


@dataclass(frozen=True)
class Vent(Step):
    """Vent every chamber and confirm it by reading; answered by `Vented`."""

    kind: ClassVar[str] = "vent"


@dataclass(frozen=True)
class Ask(Step):
    """Ask who follows the run (`Watching.adviser`) how to go on, after so many captures; answered by `Answered`.

    The answer is in the log, so that a run which is resumed gets the same one.
    """

    kind: ClassVar[str] = "ask"
    captures: int = 0


STEP_KINDS: dict[str, type[Step]] = {
    kind.kind: kind for kind in (Actuate, Settle, Record, Scan, Note, Vent, Ask)
}


def step_from_dict(fields: dict[str, Any]) -> Step:
    """The inverse of `Step.to_dict`."""
    values = {key: value for key, value in fields.items() if key != "kind"}
    return STEP_KINDS[fields["kind"]](**values)


@dataclass(frozen=True)
class Actuated:
    """When the actuation began, and what was commanded, kPa, shape (C,)."""

    time_s: float
    pressure_kpa: tuple[float, ...]


@dataclass(frozen=True)
class Settled:
    """How still it was.

    The median and the fastest marker's speed over the last 0.5 s (NaN without markers), and the largest difference
    between the pressures commanded and measured.
    """

    took_s: float
    speed_mm_s: float = math.nan
    fastest_mm_s: float = math.nan
    pressure_error_kpa: float = math.nan


@dataclass(frozen=True)
class Recording:
    """One capture as it was recorded: N frames of M markers (NaN: not seen), P samples of C pressures.

    `missed` names the chambers that did not follow; the capture does not count then (`on_miss: skip` in rig.yaml).
    """

    time_s: Floats
    position_mm: Floats
    pressure_time_s: Floats
    pressure_kpa: Floats
    missed: tuple[str, ...] = ()

    @property
    def mean_mm(self) -> Floats:
        """The mean position of each marker over the frames that saw it, (M, 3); NaN if none did."""
        return _mean(self.position_mm)

    @property
    def mean_kpa(self) -> Floats:
        """The mean measured pressure of each chamber, (C,)."""
        return _mean(self.pressure_kpa)

    @property
    def seen(self) -> Floats:
        """The share of frames that saw each marker, (M,)."""
        if not len(self.position_mm):
            return np.zeros(self.position_mm.shape[1])
        return np.isfinite(self.position_mm).all(axis=2).mean(axis=0)


def _mean(values: Floats) -> Floats:
    finite = np.isfinite(values)
    count = finite.sum(axis=0)
    total = np.where(finite, values, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


@dataclass(frozen=True)
class Scanned:
    """A scan: its files as the scanner left them, their common hash, its size, and the registration error.

    `files` are relative to `folder`, the run's, which is None in a dry run: there is no scan then; their numbers are in
    `unit`. `missed` is as for a `Recording`.
    """

    files: tuple[str, ...]
    sha256: str
    vertices: int
    triangles: int
    registration_error_mm: float = math.nan
    unit: str = "mm"
    missed: tuple[str, ...] = ()
    folder: Path | None = field(default=None, repr=False, compare=False)

    @property
    def mesh_file(self) -> Path | None:
        """The file with the surface; None in a dry run."""
        return self.folder / self.files[0] if self.folder is not None and self.files else None


@dataclass(frozen=True)
class Vented:
    """A confirmed vent: the last pressures read, kPa, and how long it took."""

    pressure_kpa: tuple[float, ...]
    took_s: float


@dataclass(frozen=True)
class Answered:
    """What the adviser said, as plain values; empty where nobody advises, or there is nothing new."""

    content: Advice = field(default_factory=Advice)


Result = Actuated | Settled | Recording | Scanned | Vented | Answered | None


@dataclass(frozen=True)
class Completed:
    """A step that is done: its number, what was asked, what came out, and when.

    `waited_s` is how long the pressures were held between the step before and this one.
    """

    index: int
    step: Step
    result: Result = None
    started_s: float = 0.0
    ended_s: float = 0.0
    replayed: bool = field(default=False)
    waited_s: float = 0.0

    @property
    def took_s(self) -> float:
        """How long it took, s."""
        return max(0.0, self.ended_s - self.started_s)
