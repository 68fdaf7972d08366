"""What a forward model learns from: pressures, control points, and slopes if there are any."""

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface import Spline
from labrig.surrogate._odd import copies, odd_ones, said_of

if TYPE_CHECKING:
    from labrig.physics import Simulations

FEWEST = 12
"""Simulations below which nothing is learned."""


@dataclass(frozen=True)
class TrainingSet:
    """Shapes by pressure: `pressure_kpa` (N, C), `control_mm` (N, nu, nv, 3), `slopes` (N, nu, nv, 3, C) mm/kPa."""

    chamber_names: tuple[str, ...]
    low_kpa: Floats
    high_kpa: Floats
    spline: Spline
    pressure_kpa: Floats
    control_mm: Floats
    slopes: NDArray[Any] | None = None
    marker_names: tuple[str, ...] = ()
    marker_uv: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    source: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.pressure_kpa)

    @property
    def fraction(self) -> Floats:
        """Pressures as fractions of each chamber's range, (N, C)."""
        return (self.pressure_kpa - self.low_kpa) / (self.high_kpa - self.low_kpa)

    @property
    def flat(self) -> Floats:
        """Control points, one row a shape, (N, D)."""
        return self.control_mm.reshape(len(self), -1)

    def flat_slopes(self) -> NDArray[Any] | None:
        """Slopes by the fraction of the range, (N, D, C), or None."""
        if self.slopes is None:
            return None
        return self.slopes.reshape(len(self), -1, len(self.low_kpa)) * (self.high_kpa - self.low_kpa)

    def take(self, index: NDArray[Any]) -> "TrainingSet":
        """Some of the shapes."""
        slopes = None if self.slopes is None else self.slopes[index]
        return replace(
            self, pressure_kpa=self.pressure_kpa[index], control_mm=self.control_mm[index], slopes=slopes
        )

    def without_slopes(self) -> "TrainingSet":
        """The same shapes, their slopes not known."""
        return replace(self, slopes=None)

    def split(self, share: float, seed: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Indices to learn from (a `share` of all) and to test on, by chance.

        Raises `LabrigError` when too few are left to learn from, or none to test on.
        """
        order = np.random.default_rng(seed).permutation(len(self))
        count = round(share * len(self))
        if count < FEWEST or count >= len(self):
            raise LabrigError(
                f"forward: {len(self)} simulations with a share of {share:g} leave {count} to learn from and "
                f"{len(self) - count} to test on; at least {FEWEST} and 1 are needed"
            )
        return order[:count].astype(np.int64), order[count:].astype(np.int64)


def training_set(simulations: "Simulations", path: str | Path = "") -> TrainingSet:
    """What is of use in a folder of simulations: those that converged, without copies.

    Its `notes` name those that do not belong to the others, by their numbers in the file. Raises `LabrigError` when
    there are too few.
    """
    from labrig.physics import load_shell

    shell = load_shell(simulations.shell)
    kept, copied, notes = _looked_over(simulations, np.asarray(shell.max_kpa, float))
    if kept.sum() < FEWEST:
        raise LabrigError(
            f"{path or 'simulations'}: only {int(kept.sum())} simulations converged"
            f"{f' and are no copies ({copied} are)' if copied else ''}; {FEWEST} are needed"
        )
    control = np.asarray(simulations.control_mm)[kept]
    pressure = np.asarray(simulations.pressure_kpa, dtype=float)[kept]
    slopes = None if simulations.jacobian is None else np.asarray(simulations.jacobian)[kept]
    return TrainingSet(
        chamber_names=tuple(shell.chamber_names),
        low_kpa=np.zeros(len(shell.chamber_names)),
        high_kpa=np.asarray(shell.max_kpa, dtype=float),
        spline=simulations.spline,
        pressure_kpa=pressure,
        control_mm=control.astype(float),
        slopes=slopes,
        marker_names=tuple(shell.marker_names),
        marker_uv=np.asarray(shell.marker_uv, dtype=float),
        source={
            "simulations": Path(path).name,
            "simulations_sha256": sha256_of_arrays(pressure, control, slopes),
            "shell": simulations.shell,
            "count": int(kept.sum()),
            "not_converged": int((~np.asarray(simulations.converged, dtype=bool)).sum()),
            **({"copies": copied} if copied else {}),
        },
        notes=tuple(f"{path or 'simulations'}: {note}" for note in notes),
    )


def _looked_over(
    simulations: "Simulations", max_kpa: Floats
) -> tuple[NDArray[np.bool_], int, tuple[str, ...]]:
    """Which simulations are of use, (N,): that converged and are no copies; how many are; and what is odd."""
    kept = np.array(simulations.converged, dtype=bool)
    number = np.flatnonzero(kept)
    pressure = np.asarray(simulations.pressure_kpa, float)[kept]
    flat = np.asarray(simulations.control_mm, float)[kept].reshape(len(number), -1)
    copied, other = copies(pressure / max_kpa, flat)
    own = np.flatnonzero(~copied)
    found = odd_ones((pressure / max_kpa)[own], flat[own])
    odd = [(int(own[k]), missed, usual) for k, missed, usual in found]
    kept[number[copied]] = False
    return kept, int(copied.sum()), said_of(number, simulations.chamber_names, pressure, copied, other, odd)


def sha256_of_arrays(*arrays: NDArray[Any] | None) -> str:
    """One hash of the numbers in arrays, and of their shapes."""
    total = hashlib.sha256()
    for array in arrays:
        if array is not None:
            total.update(str((array.shape, array.dtype.str)).encode())
            total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()
