"""P3 to P6 of the source paper: what fixes a simulated model, measured on scans that nobody learned from."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from labrig.surface import Mesh, Warp, distances, grid, register
from labrig.surrogate import ForwardModel, Frames, Shot, WarpedModel, train_warp
from labrig.surrogate._network import Network
from labrig.surrogate._paper_warp import PAPER_C, PAPER_WARP, train_function
from labrig.surrogate._torch_training import train_network
from labrig.view._learning import draw_maps

from . import plots
from .rig import FRAMES, Bench

NEURONS = (4, 8, 12, 16, 24, 32, 48, 64, 96)
COUNTS = (5, 10, 15, 20, 25, 30, 35, 40)
ACROSS, TRIES = 67, 2
ICP = 15
"""Steps of the registration: it starts where the scan belongs, but for what the model is wrong by."""
FEW_SCANS = 6
SLACK = 1e-2
"""The linear system of N_mk, regularised: the best of 1e-10 to 1e-1 for it at 40 frames."""


@dataclass(frozen=True)
class Scores:
    """Mean and maximal distance, mm, of each scan (S,), and the mean by place (n, n)."""

    mean: np.ndarray
    largest: np.ndarray
    by_place: np.ndarray


def score(
    points: Callable[[np.ndarray, np.ndarray], np.ndarray], shots: list[Shot], across: int = ACROSS
) -> Scores:
    """Distances of predicted samples from scans, each brought onto the prediction by ICP first, as in the paper."""
    uv, triangles = grid(across, across)
    mean, largest, fields = [], [], []
    for shot, predicted in zip(shots, points(np.array([s.pressure_kpa for s in shots]), uv), strict=True):
        placed = register(
            shot.mesh, Mesh(predicted, triangles), start=(np.eye(3), np.zeros(3)), iterations=ICP
        )
        off = distances(predicted, shot.mesh.moved(placed.rotation, placed.translation_mm))
        size = np.where(off.beyond, np.nan, np.abs(off.signed_mm))
        mean.append(np.nanmean(size))
        largest.append(np.nanmax(size))
        fields.append(size.reshape(across, across).T)
    stacked = np.array(fields)
    known = np.isfinite(stacked).sum(axis=0)
    field = np.where(known > 0, np.nansum(stacked, axis=0) / np.maximum(known, 1), np.nan)
    return Scores(np.array(mean), np.array(largest), field)


def p3(bench: Bench, seeds: int) -> dict[str, Any]:
    """Neurons of N_rbf against the error, 40 frames."""
    forward, error, trained = (
        bench.forward("paper"),
        np.zeros((seeds, len(NEURONS))),
        np.zeros((seeds, len(NEURONS))),
    )
    for s in range(seeds):
        frames, _ = bench.captures(s + 1)
        uv = forward.markers(frames.marker_names)
        for k, neurons in enumerate(NEURONS):
            head = train_function(forward, frames, s, replace(PAPER_WARP, hidden=(neurons, neurons)))
            model = WarpedModel(forward, uv, PAPER_C, head)
            error[s, k] = score(model.points, bench.held_out(s + 1)).mean.mean()
            off = model.points(frames.pressure_kpa, uv) - frames.position_mm
            trained[s, k] = np.linalg.norm(off[frames.captured], axis=1).mean()
    series = {"held-out scans": error, "markers learned from": trained}
    plots.curves(series, NEURONS, ("neurons in each of 2 layers", "mean error, mm"), bench.folder / "p3.png")
    best = NEURONS[int(error.mean(axis=0).argmin())]
    return {
        "title": "P3: neurons of N_rbf, 40 frames, mean error on held-out scans, mm",
        "head": ["neurons in each of 2 layers", *map(str, NEURONS)],
        "rows": [
            ["held-out scans", *(f"{v:.2f}" for v in error.mean(axis=0))],
            ["markers learned from", *(f"{v:.2f}" for v in trained.mean(axis=0))],
        ],
        "notes": [
            f"{seeds} plants. The paper: overfits above about 50 neurons in all, 24 in each layer chosen. "
            f"Here the smallest held-out error is at {best} in each layer, and with 96 it is "
            f"{100 * (error.mean(axis=0)[-1] / error.mean(axis=0).min() - 1):.0f} % larger: no overfitting to speak of "
            "in 150 epochs of two batches each."
        ],
        "picture": "p3.png",
    }


def without_forward(forward: ForwardModel, frames: Frames, seed: int) -> Callable[..., np.ndarray]:
    """P4's alternative: markers from pressures by a network, then a warp of the resting shape."""
    whole = frames.take(frames.complete)
    marker_uv = forward.markers(frames.marker_names)
    rest = forward.points(np.zeros(len(forward.chamber_names)), marker_uv)[0]
    moved = (whole.position_mm - rest).reshape(len(whole), -1)
    net: Network = train_network(forward.fraction(whole.pressure_kpa), moved, PAPER_WARP, seed)

    def points(pressure: np.ndarray, uv: np.ndarray) -> np.ndarray:
        shape = forward.points(np.zeros(len(forward.chamber_names)), uv)[0]
        targets = net.value(forward.fraction(pressure)).reshape(len(pressure), -1, 3) + rest
        return np.stack([Warp.through(rest, t, PAPER_C, SLACK).apply(shape) for t in targets])

    return points


def p4(bench: Bench, seeds: int) -> dict[str, Any]:
    """Without N_fk: markers from pressures, and the resting shape warped to them."""
    forward = bench.forward("paper")
    names = (
        "without N_fk: markers, then warp the resting shape",
        "simulated (N_fk)",
        "N_fk and N_rbf",
        "labrig",
    )
    mean, largest = np.zeros((seeds, 4)), np.zeros((seeds, 4))
    maps: dict[str, np.ndarray] = {}
    for s in range(seeds):
        frames, _ = bench.captures(s + 1)
        models = (
            without_forward(forward, frames, s),
            forward.points,
            train_warp(forward, frames, method="function", seed=s, calibrate=False).model.points,
            train_warp(bench.forward(), frames).model.points,
        )
        for k, points in enumerate(models):
            found = score(points, bench.held_out(s + 1))
            mean[s, k], largest[s, k] = found.mean.mean(), found.largest.mean()
            if s == 0:
                maps[("without N_fk", "simulated", "N_rbf", "labrig")[k]] = found.by_place
    draw_maps(maps, "mean error, mm", bench.folder / "p4.png")
    return {
        "title": "P4: without N_fk; held-out scans, mm",
        "head": ["model", "mean", "plants", "largest, mean over scans"],
        "rows": [
            [
                name,
                f"{mean[:, k].mean():.2f}",
                f"{mean[:, k].min():.2f} to {mean[:, k].max():.2f}",
                f"{largest[:, k].mean():.1f}",
            ]
            for k, name in enumerate(names)
        ],
        "notes": ["The paper: much larger errors without N_fk (shown as colours, no figure)."],
        "picture": "p4.png",
    }


def p5(bench: Bench, seeds: int) -> dict[str, Any]:
    """The simulated against the fixed model on scans of set-points that were not learned from."""
    names = (
        "N_rbf (paper)",
        "labrig, markers",
        "labrig, 10 scans, no markers",
        "labrig, markers and 10 scans",
        "labrig, markers, pressures as simulated",
    )
    cut = np.zeros((seeds, 4, len(names)))
    cut_largest = np.zeros_like(cut)
    all_cut, mean = np.zeros((seeds, len(names))), np.zeros((seeds, len(names) + 1))
    maps: dict[str, np.ndarray] = {}
    for s in range(seeds):
        frames, scans = bench.captures(s + 1)
        held = bench.held_out(s + 1)
        ours, paper = bench.forward(), bench.forward("paper")
        models = [
            train_warp(paper, frames, method="function", seed=s, calibrate=False).model,
            train_warp(ours, frames).model,
            train_warp(ours, None, scans, method="scans").model,
            train_warp(ours, frames, scans, method="both").model,
            train_warp(ours, frames, gain_sd=1e-6).model,
        ]
        simulated = score(paper.points, held)
        mean[s, 0] = simulated.mean.mean()
        for k, model in enumerate(models):
            found = score(model.points, held)
            cut[s, :, k] = 100 * (found.mean / simulated.mean - 1)[:4]
            cut_largest[s, :, k] = 100 * (found.largest / simulated.largest - 1)[:4]
            all_cut[s, k] = 100 * (found.mean.mean() / simulated.mean.mean() - 1)
            mean[s, k + 1] = found.mean.mean()
            if s == 0:
                maps |= {"simulated": simulated.by_place, names[k].replace("labrig, ", ""): found.by_place}
        if s == 0:
            confidence = {"markers and scans": models[3].confidence, "scans alone": models[2].confidence}
            draw_maps(confidence, "confidence", bench.folder / "p5_confidence.png", 1.0, good=True)
    draw_maps(maps, "mean error, mm", bench.folder / "p5.png")
    rows = [
        ["the paper, average error", "-30.4", "-53.5", "-32.1", "-33.5", "", ""],
        ["the paper, maximal error", "-6.7", "-44.0", "-50.6", "-60.6", "", ""],
        ["simulated model", "", "", "", "", "", f"{mean[:, 0].mean():.2f}"],
    ]
    for k, name in enumerate(names):
        rows.append(
            [f"{name}, average", *(f"{v:.1f}" for v in cut[:, :, k].mean(axis=0)),
             f"{all_cut[:, k].mean():.1f} ({all_cut[:, k].min():.1f} to {all_cut[:, k].max():.1f})",
             f"{mean[:, k + 1].mean():.2f}"]
        )  # fmt: skip
        rows.append([f"{name}, maximal", *(f"{v:.1f}" for v in cut_largest[:, :, k].mean(axis=0)), "", ""])
    held_count = len(bench.held_out(1))
    return {
        "title": "P5: change of the error from simulated to fixed, %, at four random actuations that were scanned",
        "head": ["model", "A1", "A2", "A3", "A4", f"all {held_count} scans (plants)", "mean error, mm"],
        "rows": rows,
        "notes": [
            f"Mean of {seeds} plants; 40 frames, about 45 % of them incomplete; scans are brought onto the model by "
            "ICP before errors are measured, as in the paper. Asked for: at least 50 % lower on average.",
            "The last model may not correct the pressures that count: all is learned as a field.",
        ],
        "picture": "p5.png",
    }


def p6(bench: Bench, seeds: int) -> dict[str, Any]:
    """Function prediction against marker prediction as frames grow."""
    names = ("marker prediction (N_mk)", "function prediction (N_rbf)", "N_mk, system regularised", "labrig")
    mean = np.full((seeds, len(names), len(COUNTS)), np.nan)
    complete = np.zeros((seeds, len(COUNTS)))
    simulated = np.zeros(seeds)
    for s in range(seeds):
        frames, _ = bench.captures(s + 1)
        held, paper, ours = bench.held_out(s + 1)[:FEW_SCANS], bench.forward("paper"), bench.forward()
        simulated[s] = score(paper.points, held).mean.mean()
        for j, count in enumerate(COUNTS):
            few = frames.take(slice(0, count))
            complete[s, j] = few.complete.sum()
            tries = range(TRIES)
            marker = [train_warp(paper, few, method="marker", seed=t, calibrate=False).model for t in tries]
            function = [
                train_warp(paper, few, method="function", seed=t, calibrate=False).model for t in tries
            ]
            slack = [replace(m, head=replace(m.head, slack=SLACK)) for m in marker]
            groups = (marker, function, slack, [train_warp(ours, few).model])
            for k, models in enumerate(groups):
                mean[s, k, j] = np.mean([score(m.points, held, 40).mean.mean() for m in models])
    series = {name: mean[:, k] for k, name in enumerate(names)}
    series["simulated"] = np.repeat(simulated[:, None], len(COUNTS), axis=1)
    plots.curves(
        series,
        COUNTS,
        ("captured frames", "mean error on held-out scans, mm"),
        bench.folder / "p6.png",
        log=True,
    )
    wins = int((mean[:, 1] < mean[:, 0]).sum())
    ours_wins = int((mean[:, 3] < mean[:, 1]).sum())
    return {
        "title": "P6: mean error on held-out scans as captured frames grow, mm",
        "head": ["method", *map(str, COUNTS)],
        "rows": [
            ["frames with every marker", *(f"{v:.1f}" for v in complete.mean(axis=0))],
            *([name, *(f"{v:.2f}" for v in mean[:, k].mean(axis=0))] for k, name in enumerate(names)),
        ],
        "notes": [
            f"{seeds} plants, networks {TRIES} times each, {FEW_SCANS} held-out scans; as simulated: "
            f"{simulated.mean():.2f} mm. Better in so many of {mean[:, 0].size} cases (plant and number of frames): "
            f"function prediction than marker prediction {wins}, than that with a regularised system "
            f"{int((mean[:, 1] < mean[:, 2]).sum())}; labrig than function prediction {ours_wins}.",
            "The paper: a smaller error of function prediction with every number of frames. Its linear system for the "
            "warp meets the predicted markers exactly, through bells (c = 3e-5) that are wide for markers this close: "
            "where N_mk is a little off, the surface between is far off. The regularised system (slack "
            f"{SLACK:g}, about the best for it) is not the paper's; it shows how much of the gap is this alone.",
        ],
        "picture": "p6.png",
    }


__all__ = ["FRAMES", "p3", "p4", "p5", "p6", "score"]
