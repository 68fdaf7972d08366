"""Training of the sim-to-real correction, by labrig's own ways and those of the source paper."""

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface import Mesh, grid
from labrig.surrogate._captures import Frames, Shot
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._models import save_model
from labrig.surrogate._provenance import provenance
from labrig.surrogate._rig_frame import frame_of_markers
from labrig.surrogate._same_chambers import check_chambers
from labrig.surrogate._scans import frame_of
from labrig.surrogate._sim_to_real import GAIN_SD, learn_correction
from labrig.surrogate._warped import WarpedModel

WarpMethod = Literal["ours", "scans", "both", "function", "marker"]
METHODS: tuple[WarpMethod, ...] = ("ours", "scans", "both", "function", "marker")

ACROSS = " across the surface (how points move along it, scans alone do not show)"
_NOTHING_LEFT_OUT = "nothing was left out, so how far it is off is not known: that takes "
_TO_LEAVE_OUT = "two set-points and two markers"
_TO_LEAVE_OUT_WHOLE = "three set-points with every marker"
_FOLDS = 4
_MESH = 61


@dataclass(frozen=True)
class TrainedWarp:
    """A corrected model, and distances, mm, at held-out points: as simulated and as corrected; time, s.

    Both are of the same points, one after the other. `simulated_mm` is empty where there are no markers; both are where
    nothing could be left out: with a single set-point, or a single marker. From scans alone they are distances across
    the surface (`across`), without how points move along it. `notes`: what its data do not tell.
    """

    model: WarpedModel
    simulated_mm: Floats
    fixed_mm: Floats
    fit_s: float
    facts: dict[str, Any]
    notes: tuple[str, ...] = ()

    def save(self, path: str | Path) -> None:
        """Write the model, in one piece or not at all."""
        save_model(self.model, path)

    def __repr__(self) -> str:
        return "\n".join([f"TrainedWarp in {self.fit_s:.1f} s: {self.model!r}", *self.notes, self.left_out])

    @property
    def left_out(self) -> str:
        """How far off it is at what was left out of it, in a line."""
        if not len(self.fixed_mm):
            whole = self.model.head.kind == "marker"
            return _NOTHING_LEFT_OUT + (_TO_LEAVE_OUT_WHOLE if whole else _TO_LEAVE_OUT)
        before = f"{self.simulated_mm.mean():.3g} -> " if len(self.simulated_mm) else ""
        return f"left out: mean {before}{self.fixed_mm.mean():.3g} mm{ACROSS if self.across else ''}"

    @property
    def across(self) -> bool:
        """Whether its errors are across the surface only, as scans alone show them."""
        return self.model.doubt is not None and self.model.doubt.along is not None


def train_warp(
    forward: ForwardModel,
    frames: Frames | None = None,
    shots: list[Shot] | None = None,
    method: WarpMethod = "ours",
    seed: int = 0,
    calibrate: bool = True,
    gain_sd: float = GAIN_SD,
) -> TrainedWarp:
    """Learn how the rig differs from the forward model.

    `ours` uses the markers of `frames`, `scans` scans alone, `both` both; `function` and `marker` are the source
    paper's networks N_rbf and N_mk, whose errors are measured by leaving out a quarter of the set-points at a time
    where `calibrate`. `gain_sd`: how far, by labrig's methods, pressures may count otherwise than simulated. Raises
    `LabrigError` when there is nothing of what the method needs.
    """
    shots = shots or []
    if method in ("ours", "both", "function", "marker") and frames is None:
        raise LabrigError(f"sim2real: the method {method} needs markers; the run has none")
    if method in ("scans", "both") and not shots:
        raise LabrigError(f"sim2real: the method {method} needs scans; the run has none")
    started = time.process_time()
    rotation, translation, notes = frame_of_markers(forward, frames)
    if frames is not None:
        frames = replace(frames, position_mm=(frames.position_mm - translation) @ rotation)
        check_chambers(forward, frames)
    shots = [replace(s, mesh=s.mesh.moved(rotation.T, -rotation.T @ translation)) for s in shots]
    if method in ("scans", "both"):
        shots, slide = _placed(forward, shots)
        notes = (*notes, *slide)
    if method in ("function", "marker"):
        assert frames is not None
        model, left_out, simulated, facts = _paper(forward, frames, method, seed, calibrate)
    else:
        merged = None if method == "scans" or frames is None else frames.merged()
        correction = learn_correction(forward, merged, [] if method == "ours" else shots, gain_sd)
        known = np.isfinite(correction.left_out_mm)  # frames first, then scans at set-points of their own
        model, left_out, facts = correction.model, correction.left_out_mm[known], correction.facts
        simulated = np.zeros(0) if merged is None else _off(forward, merged, known[: len(merged)])
    about = {
        "frames": 0 if frames is None else len(frames),
        "complete_frames": 0 if frames is None else int(frames.complete.sum()),
        "captured_points": 0 if frames is None else int(frames.captured.sum()),
        "scans": len(shots) if method in ("scans", "both") else 0,
    }
    facts = provenance("sim2real", {"method": method, "seed": seed}) | facts | about
    if notes:
        facts["notes"] = list(notes)
    model = replace(model, rotation=rotation, translation_mm=translation, provenance=facts)
    return TrainedWarp(model, simulated, left_out, time.process_time() - started, facts, notes)


def _paper(
    forward: ForwardModel, frames: Frames, method: str, seed: int, calibrate: bool
) -> tuple[WarpedModel, Floats, Floats, dict[str, Any]]:
    from labrig.surrogate._paper_warp import PAPER_C, train_function, train_marker

    train = train_function if method == "function" else train_marker
    uv = forward.markers(frames.marker_names)
    model = WarpedModel(forward, uv, PAPER_C, train(forward, frames, seed))
    group = frames.set_points()
    fold = (np.random.default_rng(seed).permutation(group.max() + 1) % _FOLDS)[group]
    errors, simulated = [np.zeros(0)], [np.zeros(0)]
    several = frames.captured.any(axis=0).sum() > 1  # one marker says nothing of the rest of the surface
    for k in range(_FOLDS if calibrate and several else 0):
        if (fold == k).all() or not (fold == k).any():
            continue  # there is nothing to learn from, or nothing to leave out
        try:
            part = WarpedModel(forward, uv, PAPER_C, train(forward, frames.take(fold != k), seed))
        except LabrigError:
            continue  # too few complete frames are left
        beside = frames.take(fold == k)
        errors.append(_off(part, beside))
        simulated.append(_off(forward, beside))
    left_out = np.concatenate(errors)
    off = left_out
    if calibrate and not left_out.size:
        off = _off(forward, frames)  # no less is known than how far the simulation is off
    deviation = float(np.quantile(off, 0.95)) / 1.96 if off.size else 1.0
    return replace(model, noise_mm=deviation), left_out, np.concatenate(simulated), {"c_per_mm2": PAPER_C}


def _off(model: ForwardModel | WarpedModel, frames: Frames, which: NDArray[np.bool_] | None = None) -> Floats:
    """How far a model's markers are from where they were captured, mm, frame by frame; all, or `which` (F, M)."""
    off = model.points(frames.pressure_kpa, model.markers(frames.marker_names)) - frames.position_mm
    return np.linalg.norm(off[frames.captured if which is None else which], axis=1)


def _placed(forward: ForwardModel, shots: list[Shot]) -> tuple[list[Shot], tuple[str, ...]]:
    """The scans in the simulator's frame, and what is not known of that."""
    uv, triangles = grid(_MESH, _MESH)
    shapes = forward.points(np.array([shot.pressure_kpa for shot in shots]), uv)
    rotation, translation, notes = frame_of(shots, [Mesh(points, triangles) for points in shapes])
    return [replace(shot, mesh=shot.mesh.moved(rotation, translation)) for shot in shots], notes
