"""Folders of simulations: many solved shapes of one shell, as arrays."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from labrig._durable import put_at, write_whole
from labrig._errors import LabrigError
from labrig._yaml import read_yaml
from labrig.arrays import Floats
from labrig.surface import Spline

SHELL_FILE, DATA_FILE, FAILURES_FILE = "shell.yaml", "simulations.npz", "failures.json"


class Failure(TypedDict):
    """A shape that has no solution, and why."""

    number: int
    pressure_kpa: list[float]
    reason: str


@dataclass(frozen=True)
class Simulations:
    """N solved shapes of a shell with C chambers.

    `pressure_kpa` (N, C); `control_mm` (N, n_u, n_v, 3), NaN where not `converged` (N,); `kind` (N,) `corner` or
    `halton`; `residual` (N,); `jacobian` (N, n_u, n_v, 3, C), mm/kPa, or None; `cpu_s` (N,) processor time of each;
    `shell` the content of its file.
    """

    pressure_kpa: Floats
    control_mm: Floats
    kind: NDArray[np.str_]
    residual: Floats
    converged: NDArray[np.bool_]
    jacobian: NDArray[np.float32] | None
    cpu_s: Floats
    shell: dict[str, Any]

    @property
    def chamber_names(self) -> tuple[str, ...]:
        """The chambers, in the order of the pressures."""
        return tuple(chamber["name"] for chamber in self.shell["chambers"])

    @property
    def spline(self) -> Spline:
        """The surface that the control points are of."""
        n_u, n_v = self.shell["control_points"]
        return Spline((n_u, n_v), self.shell["degree"])


def open_simulations(path: str | Path) -> Simulations:
    """The simulations of a folder that `labrig simulate` has made.

    Raises `LabrigError` if it holds none, or they are not complete or not readable.
    """
    folder = Path(path)
    if not (folder / DATA_FILE).is_file():
        started = (folder / SHELL_FILE).is_file()
        hint = (
            "its simulations are not complete: labrig simulate ... --resume"
            if started
            else "make it: labrig simulate"
        )
        raise LabrigError(f"{folder}: holds no {DATA_FILE} ({hint})")
    try:
        with np.load(folder / DATA_FILE, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
        shell = read_yaml(folder / SHELL_FILE, "shell")
        made = Simulations(**{"jacobian": None, **found}, shell=shell)
        _check(made)
        return made
    except (OSError, EOFError, ValueError, TypeError, BadZipFile) as error:
        raise LabrigError(
            f"{folder}: cannot be read as simulations ({' '.join(str(error).split())})"
        ) from None


def _check(made: Simulations) -> None:
    """Raise `ValueError` where arrays do not belong together, or what converged has numbers that are none."""
    count, chambers, shape = len(made.converged), len(made.chamber_names), (*made.spline.count, 3)
    wanted = {"pressure_kpa": (count, chambers), "control_mm": (count, *shape)}
    if made.jacobian is not None:
        wanted["jacobian"] = (count, *shape, chambers)
    for name, size in wanted.items():
        values = np.asarray(getattr(made, name))
        if values.shape != size:
            raise ValueError(f"{name} is {values.shape}, and {size} by shell.yaml and converged")
        if values.dtype.kind not in "fiu":
            raise ValueError(f"{name} is of {values.dtype}, not of real numbers")
        bad = np.flatnonzero(made.converged & ~np.isfinite(values.reshape(count, -1)).all(axis=1))
        if len(bad):
            raise ValueError(
                f"{name} of number {bad[0]} has values that are no numbers: take it out of `converged`"
            )


def write_simulations(simulations: Simulations, failures: list[Failure], folder: Path) -> None:
    """Write the data and the list of failures, whole or not at all; the shell's file is there already."""
    arrays = {
        name: getattr(simulations, name) for name in Simulations.__dataclass_fields__ if name != "shell"
    }
    write_whole(folder / FAILURES_FILE, json.dumps(failures, indent=1) + "\n")
    write_arrays(folder / DATA_FILE, {name: a for name, a in arrays.items() if a is not None})


def write_arrays(path: Path, arrays: dict[str, Any]) -> None:
    """An .npz file: whoever reads it never sees half of it; after a power cut it may be gone."""
    partial = path.with_suffix(".partial.npz")
    with partial.open("wb") as file:
        np.savez(file, **arrays)
    put_at(partial, path)
