"""What the train commands do."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import typer

from labrig import LabrigError
from labrig.cli._places import check_file, check_folder, replaced

if TYPE_CHECKING:
    from labrig.surrogate import Trained, TrainedWarp, WarpedModel

_NAMES = {"gaussian": "gaussian process", "network": "network ensemble", "paper": "paper's network"}
_HEAD = ("method", "slopes", "mean", "p95", "p99", "max", "in 95 %", "fit")


def forward(
    simulations: Path,
    output: Path,
    method: str,
    paper: bool,
    share: float,
    seed: int,
    slopes: bool,
    out: Path,
) -> None:
    """Train a forward model, print how it does, and write it with its report."""
    from labrig.physics import open_simulations
    from labrig.surrogate import save_model, train_forward, training_set
    from labrig.surrogate._train_forward import Method

    check_file(output)
    check_folder(out)
    if method not in get_args(Method):
        raise LabrigError(f"--method {method}: choose one of {', '.join(get_args(Method))}")
    data = training_set(open_simulations(simulations), simulations)
    if not slopes:
        data = data.without_slopes()
    wanted = [method, *(["paper"] if paper and method != "paper" else [])]
    trained = {name: train_forward(data, name, share, seed) for name in wanted}  # type: ignore[arg-type]
    of_model, of_report = replaced(output), replaced(out / "report.html")
    save_model(trained[method].model, output)
    rows = [_row(name, one, data.slopes is not None) for name, one in trained.items()]
    _print(_HEAD, rows, f"{len(data)} simulations, errors in mm on those that were not learned from")
    _report_forward(trained, rows, out, simulations, output)
    typer.echo(f"{output}: forward model of {len(data.chamber_names)} chambers{of_model}")
    typer.echo(f"report: {out / 'report.html'}{of_report}")


def _row(name: str, one: "Trained", slopes: bool) -> list[str]:
    e = one.errors
    return [
        _NAMES[name],
        "yes" if slopes and name != "paper" else "no",
        *(f"{e[key]:.3f}" for key in ("mean_mm", "p95_mm", "p99_mm")),
        f"{e['max_mm']:.2f}",
        f"{100 * e['coverage_95']:.1f} %",
        f"{one.fit_s:.1f} s",
    ]


def _report_forward(
    trained: "dict[str, Trained]", rows: list[list[str]], out: Path, simulations: Path, output: Path
) -> None:
    import numpy as np

    from labrig.view._learning import Learning, draw_lines, draw_maps, write_learning

    out.mkdir(parents=True, exist_ok=True)
    _write_json(
        out / "forward.json", {name: one.errors | {"fit_s": one.fit_s} for name, one in trained.items()}
    )
    maps = {_NAMES[name]: one.measured.by_place for name, one in trained.items()}
    level = np.linspace(0.0, 1.0, 101)
    lines = {"ideal": (100 * level, 100 * level)}
    for name, one in trained.items():
        lines[_NAMES[name]] = (100 * _normal_share(level), 100 * _share_within(one.measured.ratio, level))
    first = next(iter(trained.values()))
    learning = Learning(
        f"Forward model: {first.errors['mean_mm']:.3f} mm on shapes it had not seen",
        f"Learned from {simulations.name}, written to {output.name}.",
        [("Errors, mm, over all samples of the test shapes", _HEAD, rows)],
        [
            "An error is the distance between the predicted and the simulated place of a sample of the surface.",
            "Intervals are of these distances: the share that lies within 1.96 standard deviations.",
        ],
        {
            "Where on the surface": draw_maps(maps, "mean error, mm", out / "error_map.png"),
            "Intervals": draw_lines(lines, ("interval, %", "samples inside, %"), out / "calibration.png"),
        },
    )
    write_learning(learning, out)


def _normal_share(level: Any) -> Any:
    """The share of a normal deviate within 0 to 3 standard deviations, on the grid of levels."""
    from scipy.special import erf

    return erf(3.0 * level / 2.0**0.5)


def _share_within(percentiles: Any, level: Any) -> Any:
    """The share of ratios within the same numbers of standard deviations."""
    import numpy as np

    return np.interp(3.0 * level, percentiles, level)


def _print(head: tuple[str, ...], rows: list[list[str]], title: str) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title)
    for index, name in enumerate(head):
        table.add_column(name, justify="left" if index == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    Console().print(table)


def _write_json(path: Path, content: Any) -> None:
    partial = path.with_name(path.name + ".part")
    partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    partial.replace(path)


def sim2real(
    run: Path, model: Path, output: Path, method: str, frames: int | None, seed: int, out: Path
) -> None:
    """Train the sim-to-real correction of a forward model on a run, print how it does, and write it with its report."""
    import labrig
    from labrig.surrogate import METHODS, frames_of, load_forward, save_model, shots_of, train_warp

    check_file(output)
    check_folder(out)
    if method not in METHODS:
        raise LabrigError(f"--method {method}: choose one of {', '.join(METHODS)}")
    forward = load_forward(model)
    dataset = labrig.open_run(run)
    captured = None
    if method != "scans":
        captured = frames_of(dataset, forward.chamber_names)
        captured = captured.take(slice(0, frames)) if frames else captured
    scans = shots_of(run, forward.chamber_names) if method in ("scans", "both") else []
    trained = train_warp(forward, captured, scans, method, seed)  # type: ignore[arg-type]
    of_model, of_report = replaced(output), replaced(out / "report.html")
    save_model(trained.model, output)
    rows = _fix_rows(trained)
    _print(_FIX_HEAD, rows, f"{run.name}, method {method}: errors in mm at held-out points")
    _report_fix(trained, rows, out, run, output, method)
    typer.echo(f"{output}: the corrected model{of_model}")
    typer.echo(f"report: {out / 'report.html'}{of_report}")


_FIX_HEAD = ("model", "mean", "p95", "max", "points")


def _fix_rows(trained: "TrainedWarp") -> list[list[str]]:
    import numpy as np

    rows = []
    for name, errors in (("as simulated", trained.simulated_mm), ("corrected", trained.fixed_mm)):
        if errors.size:
            values = (errors.mean(), np.quantile(errors, 0.95), errors.max())
            rows.append([name, *(f"{value:.3f}" for value in values), str(errors.size)])
    return rows


def _report_fix(
    trained: "TrainedWarp", rows: list[list[str]], out: Path, run: Path, output: Path, method: str
) -> None:
    import numpy as np

    from labrig.surface import grid
    from labrig.view._learning import Learning, draw_maps, write_learning

    out.mkdir(parents=True, exist_ok=True)
    facts, model = trained.facts, trained.model
    _write_json(
        out / "sim2real.json", {"table": [dict(zip(_FIX_HEAD, row, strict=True)) for row in rows], **facts}
    )
    uv, _ = grid(41, 41)
    pressure = 0.5 * (model.low_kpa + model.high_kpa)
    moved = model.points(pressure, uv)[0] - _untouched(model, pressure, uv)
    shift = np.linalg.norm(moved, axis=1).reshape(41, 41).T
    deviation = model.sd_mm(pressure, uv)[0].reshape(41, 41).T
    pictures = {
        "How far the correction moves the surface (all chambers at half pressure)": draw_maps(
            {"corrected against simulated": shift}, "mm", out / "fix.png"
        ),
        "Uncertainty of the correction": draw_maps(
            {"standard deviation": deviation}, "mm", out / "deviation.png"
        ),
    }
    if facts["scans"]:
        confidence = {"confidence": model.confidence}
        pictures["Where scans support it"] = draw_maps(confidence, "", out / "confidence.png", 1.0, good=True)
    used = f"{facts['frames']} frames ({facts['complete_frames']} complete), {facts['captured_points']} markers seen"
    learning = Learning(
        f"Sim-to-real correction: {rows[-1][1]} mm error at held-out points"
        if rows
        else "Sim-to-real correction",
        f"Learned from {run.name} by {method}, {used}, {facts['scans']} scans; written to {output.name}.",
        [("Errors, mm", _FIX_HEAD, rows)],
        [
            "Held out: a quarter of the set-points at a time; with labrig's own methods also a quarter of the markers."
        ],
        pictures,
    )
    write_learning(learning, out)


def _untouched(model: "WarpedModel", pressure: Any, uv: Any) -> Any:
    """The surface (P, 3) as the simulator has it, in the rig's frame."""
    from dataclasses import replace

    head = model.forward.head
    base = replace(model.forward, head=getattr(head, "base", head))
    return base.points(pressure, uv)[0] @ model.rotation.T + model.translation_mm
