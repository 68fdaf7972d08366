"""Making many simulations: in rounds, each of which starts from what the rounds before it found.

Rounds double in size, so that nearly all shapes start from a good guess, and what a shape starts from depends on
the plan alone: a run gives the same bits with any number of workers, interrupted or not.
"""

import json
import shutil
import time
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypedDict
from zipfile import BadZipFile

import numpy as np
import yaml
from numpy.typing import NDArray

from labrig._durable import write_whole
from labrig._errors import LabrigError
from labrig._executor import Executor
from labrig.arrays import Floats
from labrig.physics._samples import sample_pressures
from labrig.physics._shell import Shell, Solution, load_shell
from labrig.physics._simulations import (
    DATA_FILE,
    SHELL_FILE,
    Failure,
    Simulations,
    open_simulations,
    write_arrays,
    write_simulations,
)
from labrig.physics._warm_start import LEAST_SHAPES, StartPredictor, nearest_state

_FIRST_ROUND, _PER_TASK, _LEARN_FROM = 32, 8, 512
_PARTS, _PLAN = "parts", "plan.npz"
_PART = ("number", "control_mm", "state", "residual", "converged", "cpu_s", "fault")
"""The arrays of a part; those of Jacobians beside them."""


class _Asked(TypedDict):
    """What a folder of simulations was asked for."""

    count: int
    jacobians: bool
    seed: int


@dataclass(frozen=True)
class _Task:
    """A few shapes to solve: their numbers (n,), pressures (n, C), and what predicts where to start."""

    shell: str
    number: NDArray[np.int64]
    pressure_kpa: Floats
    predictor: StartPredictor | None
    jacobians: bool


def simulate(
    shell: Shell,
    folder: str | Path,
    count: int = 1000,
    *,
    jacobians: bool = False,
    seed: int = 0,
    workers: int = 0,
    cluster: str | None = None,
    resume: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Simulations:
    """Solve a shell at the corners of its range and at spread pressures, `count` in all, into a folder.

    `workers`, `cluster`: see `Executor`. `resume` goes on where a folder was left. `progress(done, count)` is called
    as shapes come in. What does not converge is listed in the folder's failures.json; parts that a power cut has torn
    are solved again. Raises `LabrigError` for a folder that is in use or belongs to other simulations, and if nothing
    converged.
    """
    folder = Path(folder)
    asked: _Asked = {"count": count, "jacobians": jacobians, "seed": seed}
    with Executor(workers, cluster) as executor:
        pressure, kind = _plan(shell, folder, asked, resume, executor)
        if (folder / DATA_FILE).is_file():
            return open_simulations(folder)
        report = progress or (lambda done, count: None)
        found = _run(shell, folder, pressure, jacobians, executor, report)
    return _gather(shell, folder, pressure, kind, jacobians, found)


def _plan(
    shell: Shell, folder: Path, asked: _Asked, resume: bool, executor: Executor
) -> tuple[Floats, list[str]]:
    """The pressures of a folder: made now, or those that it was begun with."""
    if asked["count"] < 2:
        raise LabrigError(f"--count {asked['count']}: at least 2 simulations are needed")
    text = yaml.safe_dump(shell.content(), sort_keys=False, default_flow_style=None, allow_unicode=True)
    plan = folder / _PARTS / _PLAN
    shell_file = folder / SHELL_FILE
    if shell_file.exists() or (folder / DATA_FILE).exists():
        if not resume:
            raise LabrigError(
                f"{folder}: holds simulations already; --resume goes on, or name another folder"
            )
        same = shell_file.is_file() and shell_file.read_text(encoding="utf-8") == text
        known = json.loads((folder / "plan.json").read_text(encoding="utf-8")) if same else {}
        if known != asked:
            raise LabrigError(
                f"{folder}: was begun with another shell, count, seed or --jacobians; name another folder"
            )
        if (folder / DATA_FILE).is_file():
            return np.empty((0, 0)), []
        if (begun := _whole(plan, ("pressure_kpa", "kind"))) is not None:  # else the same is drawn again
            return begun["pressure_kpa"], [str(k) for k in begun["kind"]]
    (folder / _PARTS).mkdir(parents=True, exist_ok=True)
    pressure, kind = sample_pressures(shell, asked["count"], asked["seed"], executor)
    write_whole(folder / "plan.json", json.dumps(asked) + "\n")
    write_whole(shell_file, text)
    write_arrays(plan, {"pressure_kpa": pressure, "kind": np.array(kind)})
    return pressure, kind


def _run(
    shell: Shell,
    folder: Path,
    pressure: Floats,
    jacobians: bool,
    executor: Executor,
    progress: Callable[[int, int], None],
) -> dict[int, Path]:
    """Solve all that is not yet in a part; returns the part of each task by the number of its first shape."""
    order = np.random.default_rng(0).permutation(len(pressure))
    content = json.dumps(shell.content())
    parts: dict[int, Path] = {}
    places: list[Floats] = []
    states: list[NDArray[np.float32]] = []
    done, begin = 0, 0
    for size in _rounds(len(pressure)):
        numbers = order[begin : begin + size]
        begin += size
        learned = np.concatenate(places) if places else np.empty((0, pressure.shape[1]))
        predictor = None
        if len(learned) >= LEAST_SHAPES:
            predictor = StartPredictor.fit(learned[:_LEARN_FROM], np.concatenate(states)[:_LEARN_FROM])
        cut = [numbers[k : k + _PER_TASK] for k in range(0, size, _PER_TASK)]
        paths = [folder / _PARTS / f"part-{chunk[0]:06d}.npz" for chunk in cut]
        todo = [k for k, path in enumerate(paths) if not _is_part(path, cut[k], jacobians)]
        done += sum(len(cut[k]) for k in range(len(cut)) if k not in todo)
        progress(done, len(pressure))
        tasks = [_Task(content, cut[k], pressure[cut[k]], predictor, jacobians) for k in todo]
        for k, arrays in executor.map(solve_task, tasks):
            write_arrays(paths[todo[k]], arrays)
            done += len(tasks[k].number)
            progress(done, len(pressure))
        for path in paths:
            parts[len(parts)] = path
            with np.load(path, allow_pickle=False) as arrays:
                good = arrays["converged"]
                places.append(pressure[arrays["number"][good]] / shell.max_kpa)
                states.append(arrays["state"][good])
    return parts


def _whole(path: Path, names: tuple[str, ...]) -> dict[str, NDArray[Any]] | None:
    """The named arrays of an .npz file; None where there is no such file, or it is torn or lacks one."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in names}
    except (OSError, EOFError, KeyError, ValueError, BadZipFile, zlib.error):
        return None


def _is_part(path: Path, numbers: NDArray[np.int64], jacobians: bool) -> bool:
    """Whether a file holds, in one piece, the shapes of these numbers (n,)."""
    found = _whole(path, _PART if not jacobians else (*_PART, "jacobian"))
    return found is not None and np.array_equal(found["number"], numbers)


def _rounds(count: int) -> Iterator[int]:
    """Sizes of the rounds: 32, 32, 64, 128, ..."""
    done = 0
    while done < count:
        size = min(max(_FIRST_ROUND, done), count - done)
        done += size
        yield size


@lru_cache(maxsize=2)
def _shell_of(content: str) -> Shell:
    return load_shell(json.loads(content))


def solve_task(task: _Task) -> dict[str, NDArray[Any]]:
    """Solve the shapes of a task, wherever it runs; arrays by name, `fault` holding what did not converge."""
    shell = _shell_of(task.shell)
    shape = (len(task.number), *shell.spline.count, 3)
    out: dict[str, NDArray[Any]] = {
        "number": task.number,
        "control_mm": np.full(shape, np.nan),
        "state": np.zeros((len(task.number), shell.coordinates), np.float32),
        "residual": np.full(len(task.number), np.nan),
        "converged": np.zeros(len(task.number), bool),
        "cpu_s": np.zeros(len(task.number)),
    }
    if task.jacobians:
        out["jacobian"] = np.full((*shape, task.pressure_kpa.shape[1]), np.nan, np.float32)
    faults = [""] * len(task.number)
    places: list[Floats] = []
    states: list[Floats] = []
    for k, pressure in enumerate(task.pressure_kpa):
        begin = time.process_time()
        place = pressure / shell.max_kpa
        start = task.predictor(place) if task.predictor is not None else nearest_state(place, places, states)
        try:
            solution = _solved(shell, pressure, start)
            if task.jacobians:
                out["jacobian"][k] = shell.jacobian(solution)
        except LabrigError as error:
            faults[k] = str(error)
        else:
            out["control_mm"][k], out["state"][k] = solution.control_mm, solution.state
            out["residual"][k], out["converged"][k] = solution.residual, True
            places.append(place)
            states.append(solution.state)
        out["cpu_s"][k] = time.process_time() - begin
    out["fault"] = np.array(faults)
    return out


def _solved(shell: Shell, pressure: Floats, start: Floats | None) -> Solution:
    """From the guess, or else from rest."""
    try:
        return shell.solve(pressure, start)
    except LabrigError:
        if start is None:
            raise
        return shell.solve(pressure)


def _gather(
    shell: Shell, folder: Path, pressure: Floats, kind: list[str], jacobians: bool, parts: dict[int, Path]
) -> Simulations:
    """All parts as one file; the parts are thrown away."""
    count = len(pressure)
    shape = (count, *shell.spline.count, 3)
    control, residual, cpu = np.full(shape, np.nan), np.full(count, np.nan), np.zeros(count)
    converged = np.zeros(count, bool)
    jacobian = np.full((*shape, pressure.shape[1]), np.nan, np.float32) if jacobians else None
    failures: list[Failure] = []
    for path in parts.values():
        with np.load(path, allow_pickle=False) as arrays:
            number = arrays["number"]
            control[number], residual[number] = arrays["control_mm"], arrays["residual"]
            converged[number], cpu[number] = arrays["converged"], arrays["cpu_s"]
            if jacobian is not None:
                jacobian[number] = arrays["jacobian"]
            for k, fault in zip(number, arrays["fault"], strict=True):
                if fault:
                    failures.append(
                        {"number": int(k), "pressure_kpa": pressure[k].tolist(), "reason": str(fault)}
                    )
    if not converged.any():
        raise LabrigError(
            f"{folder}: none of {count} simulations converged; the first: {failures[0]['reason']}"
        )
    simulations = Simulations(
        pressure, control, np.array(kind), residual, converged, jacobian, cpu, shell.content()
    )
    write_simulations(simulations, sorted(failures, key=lambda failure: failure["number"]), folder)
    shutil.rmtree(folder / _PARTS, ignore_errors=True)
    return simulations
