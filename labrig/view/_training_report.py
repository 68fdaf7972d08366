"""The reports of trained models: tables and pictures of how far they are off, with the numbers as JSON beside them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.special import erf

from labrig._json import write_json
from labrig.surface import grid
from labrig.view._learning import Learning, draw_lines, draw_maps, write_learning

if TYPE_CHECKING:
    from labrig.surrogate import Trained, TrainedWarp, WarpedModel

_NAMES = {"gaussian": "gaussian process", "network": "network ensemble", "paper": "paper's network"}
_MAP = 41


class Table(NamedTuple):
    """A table of words: the names of its columns, and its rows."""

    head: tuple[str, ...]
    rows: list[list[str]]


def forward_table(trained: "Sequence[Trained]") -> Table:
    """How far forward models are off on the shapes that they did not see, mm; a row for each."""
    head = ("method", "slopes", "mean", "p95", "p99", "max", "in 95 %", "fit")
    return Table(head, [_forward_row(one) for one in trained])


def _forward_row(one: "Trained") -> list[str]:
    settings, e = one.model.provenance["settings"], one.errors
    return [
        _NAMES[settings["method"]],
        "yes" if settings["slopes"] and settings["method"] != "paper" else "no",
        *(f"{e[key]:.3f}" for key in ("mean_mm", "p95_mm", "p99_mm")),
        f"{e['max_mm']:.2f}",
        f"{100 * e['coverage_95']:.1f} %",
        f"{one.fit_s:.1f} s",
    ]


def write_forward_report(trained: "Sequence[Trained]", output: str, folder: Path) -> Path:
    """Write forward.json, report.html and its pictures into `folder` (made if it is missing); returns the page's path.

    The first of the models is the one that was written to `output`, the others stand beside it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    by_method = {one.model.provenance["settings"]["method"]: one for one in trained}
    errors = {name: one.errors | {"fit_s": one.fit_s} for name, one in by_method.items()}
    write_json(errors, folder / "forward.json")
    maps = {_NAMES[name]: one.measured.by_place for name, one in by_method.items()}
    level = np.linspace(0.0, 1.0, 101)
    lines = {"ideal": (100 * level, 100 * level)}
    for name, one in by_method.items():  # up to three standard deviations
        within = np.interp(3.0 * level, one.measured.ratio, level)
        lines[_NAMES[name]] = (100 * erf(3.0 * level / 2.0**0.5), 100 * within)
    first, table = trained[0], forward_table(trained)
    learning = Learning(
        f"Forward model: {first.errors['mean_mm']:.3f} mm on shapes it had not seen",
        f"Learned from {first.model.provenance['source']['simulations']}, written to {output}.",
        [("Errors, mm, over all samples of the test shapes", table.head, table.rows)],
        [
            "An error is the distance between the predicted and the simulated place of a sample of the surface.",
            "Intervals are of these distances: the share that lies within 1.96 standard deviations.",
            *first.notes,
        ],
        {
            "Where on the surface": draw_maps(maps, "mean error, mm", folder / "error_map.png"),
            "Intervals": draw_lines(lines, ("interval, %", "samples inside, %"), folder / "calibration.png"),
        },
    )
    return write_learning(learning, folder)


def sim2real_table(trained: "TrainedWarp") -> Table:
    """How far the model is off at what was left out of it in turn, mm: as simulated and as corrected."""
    rows = []
    for name, errors in (("as simulated", trained.simulated_mm), ("corrected", trained.fixed_mm)):
        if errors.size:
            values = (errors.mean(), np.quantile(errors, 0.95), errors.max())
            rows.append([name, *(f"{value:.3f}" for value in values), str(errors.size)])
    return Table(("model", "mean", "p95", "max", "points"), rows)


def write_sim2real_report(trained: "TrainedWarp", run: str, method: str, output: str, folder: Path) -> Path:
    """Write sim2real.json, report.html and its pictures into `folder` (made if it is missing); returns the page's path.

    `run` and `method` are what it was learned from and how, `output` the file that the model was written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    facts, model, table = trained.facts, trained.model, sim2real_table(trained)
    rows = [dict(zip(table.head, row, strict=True)) for row in table.rows]
    write_json({"table": rows, **facts}, folder / "sim2real.json")
    uv, _ = grid(_MAP, _MAP)
    pressure = 0.5 * (model.low_kpa + model.high_kpa)
    moved = model.points(pressure, uv)[0] - _untouched(model, pressure, uv)
    shift = np.linalg.norm(moved, axis=1).reshape(_MAP, _MAP).T
    deviation = model.sd_mm(pressure, uv)[0].reshape(_MAP, _MAP).T
    pictures = {
        "How far the correction moves the surface (all chambers at half pressure)": draw_maps(
            {"corrected against simulated": shift}, "mm", folder / "fix.png"
        ),
        "Uncertainty of the correction": draw_maps(
            {"standard deviation": deviation}, "mm", folder / "deviation.png"
        ),
    }
    if facts["scans"]:
        confidence = {"confidence": model.confidence}
        pictures["Where scans support it"] = draw_maps(
            confidence, "", folder / "confidence.png", 1.0, good=True
        )
    used = f"{facts['frames']} frames ({facts['complete_frames']} complete), {facts['captured_points']} markers seen"
    learning = Learning(
        f"Sim-to-real correction: {table.rows[-1][1]} mm error{' across the surface' if trained.across else ''} at "
        "held-out points"
        if table.rows
        else "Sim-to-real correction",
        f"Learned from {run} by {method}, {used}, {facts['scans']} scans; written to {output}.",
        [("Errors, mm", table.head, table.rows)],
        [
            "Left out: a quarter of the set-points at a time, and by labrig's own methods a quarter of the places."
            if table.rows
            else f"{trained.left_out[0].upper()}{trained.left_out[1:]}.",
            *(
                [
                    "Errors are across the surface: scans alone do not show how points move along it. The standard "
                    "deviation counts both, the latter as large as was to be expected."
                ]
                if trained.across
                else []
            ),
            *(f"{note[0].upper()}{note[1:]}." for note in trained.notes),
        ],
        pictures,
    )
    return write_learning(learning, folder)


def _untouched(model: "WarpedModel", pressure: Any, uv: Any) -> Any:
    """The surface (P, 3) as the simulator has it, in the rig's frame."""
    from dataclasses import replace

    head = model.forward.head
    base = replace(model.forward, head=getattr(head, "base", head))
    return base.points(pressure, uv)[0] @ model.rotation.T + model.translation_mm
