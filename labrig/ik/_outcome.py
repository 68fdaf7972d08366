"""What a validation run showed: every scan and recording beside what was asked for and what the model expected."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.ik._batch import MEASURED, solver_of
from labrig.ik._descent import Pose
from labrig.ik._evaluate import ShapeModel
from labrig.ik._memory import marker_uv
from labrig.ik._models import ShellModel, SurfaceModel
from labrig.ik._solve import Solver
from labrig.ik._trial import SETTLE_S, Trial, make_trials
from labrig.shape_contents import Distances, Realisation, Registered
from labrig.surface import Mesh, Registration, grid

_COARSE = 23
"""Samples a side when the plant's own best is sought: each step solves the simulator anew."""


@dataclass(frozen=True)
class Attempt:
    """One realisation.

    Set-points (C,), kPa; heights (V,), mm, of the scanned surface over the target's vertices (None without a scan) and
    how the scan was registered; marker errors (M,), mm, in the rig's frame (NaN: not seen).
    """

    pressure_kpa: Floats
    height_mm: Floats | None
    registration: Registration | None
    marker_error_mm: Floats


@dataclass(frozen=True)
class Outcome:
    """One target with one form of the model: what the model expected, and what came of it, attempt by attempt.

    `hardware_mm` (V,): heights of the best that a simulated rig itself could do, had it no model; None on a real one,
    and where its simulator finds no equilibrium.
    """

    trial: Trial
    predicted_mm: Floats
    attempts: tuple[Attempt, ...]
    hardware_mm: Floats | None = None

    @property
    def best(self) -> Attempt:
        """The attempt whose scan is closest to the target."""
        return min(self.attempts, key=lambda one: mean_of(one.height_mm))

    def summary(self) -> Realisation:
        """Plain values: predicted against asked for, realised against asked for, realised against predicted, mm."""
        first = self.attempts[0]
        realised = first.height_mm
        between = None if realised is None else realised - self.predicted_mm
        return {
            "target": self.trial.name,
            "model": self.trial.form,
            "path": self.trial.approach.name,
            "pressure_kpa": np.round(first.pressure_kpa, 3).tolist(),
            "hardware_mm": figures(self.hardware_mm),
            "predicted_mm": figures(self.predicted_mm),
            "realised_mm": figures(realised),
            "realised_against_predicted_mm": figures(between),
            "markers_against_predicted_mm": figures(first.marker_error_mm),
            "compared": None if realised is None else _share(realised, self.predicted_mm),
            "registration": None if first.registration is None else _registration(first.registration),
            "refined": [
                {
                    "pressure_kpa": np.round(one.pressure_kpa, 3).tolist(),
                    "realised_mm": figures(one.height_mm),
                }
                for one in self.attempts[1:]
            ],
            "scans": len(self.attempts),
        }


def _share(realised_mm: Floats, predicted_mm: Floats) -> float:
    """The share of a target's vertices, of those opposite the predicted surface, that the realised one shows."""
    there = np.isfinite(predicted_mm)
    return round(float(np.isfinite(realised_mm[there]).mean()), 4) if there.any() else 0.0


def mean_of(height_mm: Floats | None) -> float:
    """Mean absolute height, mm; infinite without a scan."""
    return np.inf if height_mm is None else float(np.nanmean(np.abs(height_mm)))


def figures(height_mm: Floats | None) -> Distances | None:
    """Mean, 95 % and maximum of the absolute values, and the signed mean; None if nothing is known."""
    if height_mm is None or not np.isfinite(height_mm).any():
        return None
    known = height_mm[np.isfinite(height_mm)]
    absolute = np.abs(known)
    return {
        "mean": round(float(absolute.mean()), 4),
        "p95": round(float(np.quantile(absolute, 0.95)), 4),
        "max": round(float(absolute.max()), 4),
        "signed": round(float(known.mean()), 4),
    }


def _registration(found: Registration) -> Registered:
    return {
        "rms_mm": round(found.rms_mm, 4),
        "share": round(found.share, 4),
        "sd_mm": round(found.sd_mm, 4) if np.isfinite(found.sd_mm) else None,
        "iterations": found.iterations,
    }


def outcomes(run: str | Path) -> list[Outcome]:
    """Read a run of the procedure validate and compare; what was not realised yet is left out.

    Raises `LabrigError` for another kind of run, or one whose targets or model are gone.
    """
    from labrig.campaign import Actuate, Record, Scan, read_completed
    from labrig.log import read_run_yaml

    run = Path(run)
    facts = read_run_yaml(run)
    if facts.get("procedure") != "validate":
        raise LabrigError(f"{run} is no run of validate: {facts.get('procedure') or 'it has no run.yaml'}")
    given = facts["parameters"]
    rig = facts["rig"]
    low, high = (np.array([float(c[key]) for c in rig["chambers"]]) for key in ("min_kpa", "max_kpa"))
    chambers = tuple(str(c["name"]) for c in rig["chambers"])
    trials = make_trials(
        given["targets"], given["model"], given["unit"], given["without"], chambers, low, high
    )
    setpoints: dict[str, list[Floats]] = {}
    markers: dict[str, Floats] = {}
    scans: dict[str, tuple[Path, str]] = {}
    for done in read_completed(run):
        if getattr(done.result, "missed", ()):  # its pressures did not follow: it is no realisation
            continue
        label = getattr(done.step, "label", "")
        if isinstance(done.step, Actuate):
            setpoints.setdefault(label, []).append(np.array(done.step.pressure_kpa))
        elif isinstance(done.step, Record):
            markers[label] = done.result.mean_mm  # type: ignore[union-attr]
        elif isinstance(done.step, Scan):
            scans[label] = done.result.mesh_file, done.result.unit  # type: ignore[union-attr, assignment]
    found: list[Outcome] = []
    plant = simulated_plant(rig, Path(str(facts.get("rig_file", ""))).parent, low, high)
    best: dict[str, Floats | None] = {}
    for planned in trials:
        commanded = setpoints.get(f"{planned.number}/0")
        if commanded is None:
            continue
        # what was done counts, even if labrig would choose otherwise today
        holds = planned.approach.holds_s
        holds = holds if len(holds) == len(commanded) else (SETTLE_S,) * len(commanded)
        trial = planned.along(
            replace(planned.approach, setpoints_kpa=planned.of_rig(np.array(commanded)), holds_s=holds)
        )
        expected = _expected_markers(trial, tuple(rig["markers"]))
        attempts = []
        while (label := f"{trial.number}/{len(attempts)}") in markers:
            height, registration = None, None
            if label in scans:
                surface, registration = trial.placed(trial.read_scan(*scans[label]))
                height = trial.heights(surface)
            error = np.linalg.norm(markers[label] - expected, axis=1)
            known = error if not attempts else np.full(len(error), np.nan)
            attempts.append(Attempt(setpoints[label][-1], height, registration, known))
        if not attempts:
            continue
        target = trial.solved.job.target
        if plant is not None and target not in best:
            tried = [one.pressure_kpa for one in attempts]
            best[target] = None
            with suppress(LabrigError):  # a yardstick is missing then, and the report is not
                best[target] = hardware_best(trial, plant, low, high, tried)
        found.append(Outcome(trial, trial.heights(trial.predicted), tuple(attempts), best.get(target)))
    if not found:
        raise LabrigError(f"{run}: no target was realised yet")
    return found


def simulated_plant(rig: dict[str, Any], folder: Path, low: Floats, high: Floats) -> ShapeModel | None:
    """What a simulated rig really is within its limits, hidden effects aside; None for a real one."""
    simulated = rig.get("simulated")
    if not simulated:
        return None
    from labrig.physics import has_shell, plant_shell, reduced_surface

    if has_shell(rig):
        return ShellModel(plant_shell(rig, folder), low, high)
    return SurfaceModel(reduced_surface(rig), high, low)


def hardware_best(
    trial: Trial, plant: ShapeModel, low: Floats, high: Floats, tried: Sequence[Floats]
) -> Floats:
    """Heights (V,), mm, over the target, of the best that a plant can do: the yardstick of every model.

    The plant's chambers, the limits and what was `tried` are in the rig's order.

    It is sought from the model's pressures and from half of every range; what was `tried` on the rig is a candidate.
    """
    result = trial.solved.result
    assert result is not None
    begin = Pose(result.rotation, result.translation_mm)
    solver = Solver(plant, low, high, _COARSE)
    searched = result.pressure_kpa[list(trial.order)]
    starts = (np.clip(searched, solver.low, solver.high), solver.half_kpa)
    found = [solver.solve(trial.target, begin, start) for start in starts]
    found += [Solver(plant, p, p, _COARSE).solve(trial.target, begin, p) for p in tried]
    uv, triangles = grid(MEASURED, MEASURED)
    heights = []
    for one in found:
        points = np.asarray(plant.points(one.pressure_kpa[None], uv), float)[0]
        heights.append(trial.heights(Mesh(one.to_target(points), triangles)))
    return min(heights, key=mean_of)


def _expected_markers(trial: Trial, names: tuple[str, ...]) -> Floats:
    """Where the model has the rig's markers at the trial's actuation, (M, 3), mm; NaN for those it does not know."""
    solver, memory = solver_of(trial.solved.job)
    shape: Any = solver.model
    own = list(getattr(shape, "marker_names", ()))
    known = [name in own for name in names]
    expected = np.full((len(names), 3), np.nan)
    if any(known):
        assert trial.solved.result is not None
        pressure, displaced = trial.approach.setpoints_kpa[-1], np.zeros((len(own), 3))
        if memory is not None:
            pressure, displaced = memory.after(trial.approach)
        which = [own.index(name) for name in names if name in own]
        points = np.asarray(shape.points(pressure[None], marker_uv(shape)[which]))[0]
        expected[known] = points + displaced[which]
    return expected
