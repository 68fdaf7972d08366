"""What `labrig ik` does: solve every target, print a table, write JSON and the report."""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table

from labrig._errors import LabrigError
from labrig._executor import Executor
from labrig.api._ik import limits_kpa
from labrig.cli._places import check_folder, replaced
from labrig.ik import Solved, solve_files
from labrig.view import write_ik_report

_SHOWN = 40
_GAPS = 3
_SAID_S = 1.0


def do_ik(
    targets: Sequence[Path],
    model: Path,
    out: Path,
    rig: Path | None,
    unit: str | None,
    workers: int,
    cluster: str | None,
) -> None:
    """Raises `LabrigError` if the model is of no use, or if no target could be solved."""
    check_folder(out)
    limits = limits_kpa(rig, model) if rig is not None else None
    console = Console(stderr=True)
    columns = TextColumn("targets"), BarColumn(), MofNCompleteColumn()
    with (
        Executor(workers, cluster) as executor,
        Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as shown,
    ):
        task = shown.add_task("targets", total=len(targets))
        solved = solve_files(
            targets,
            model,
            unit,
            limits,
            executor,
            lambda done: shown.update(task, completed=done),
        )
    failed = [one for one in solved if one.result is None]
    if len(failed) == len(solved):
        raise LabrigError(failed[0].error + (f" (and {len(failed) - 1} more)" if len(failed) > 1 else ""))
    _print_table(solved)
    said = replaced(out / "report.html")
    out.mkdir(parents=True, exist_ok=True)
    _write_json(solved, model, out / "ik.json")
    report = write_ik_report(solved, str(model), out)
    for one in failed:
        typer.echo(f"labrig: {one.error}", err=True)
    typer.echo(f"report: {report}{said}")
    if failed:
        raise typer.Exit(2)


def _print_table(solved: Sequence[Solved]) -> None:
    console = Console()
    table = Table("target", title="distance between model and target, mm")
    for column in ("mean", "95 %", "max", "compared", "time, ms"):
        table.add_column(column, justify="right")
    table.add_column("at a limit")
    for one in solved[:_SHOWN]:
        name = Path(one.job.target).name
        if one.result is None or one.summary is None:
            table.add_row(name, "-", "-", "-", "-", "-", "not solved")
            continue
        distance, result = one.summary, one.result
        table.add_row(
            name,
            *(f"{distance[key]:.2f}" for key in ("mean_mm", "p95_mm", "max_mm")),
            f"{distance['share']:.0%}",
            f"{1e3 * (result.time_s + result.prepare_s):.0f}",
            ", ".join(result.limited),
        )
    console.print(table)
    compile_s = sum(one.result.compile_s for one in solved if one.result is not None)
    if compile_s > _SAID_S:
        typer.echo(f"compiling took {compile_s:.0f} s beside that: once on this computer")
    if len(solved) > _SHOWN:
        typer.echo(f"and {len(solved) - _SHOWN} more: see ik.json")
    if len(solved) == 1 and (result := solved[0].result) is not None:
        names = zip(result.chamber_names, result.pressure_kpa, strict=True)
        typer.echo("pressures, kPa: " + ", ".join(f"{name} {value:.1f}" for name, value in names))
        for note in result.notes:
            typer.echo(note)
        for gap in result.gaps[:_GAPS]:
            typer.echo(f"out of reach: the surface {gap.words}")


def _write_json(solved: Sequence[Solved], model: Path, path: Path) -> None:
    """All results as plain values, in one piece."""
    entries = []
    for one in solved:
        entry: dict[str, Any] = {"target": one.job.target}
        if one.result is None:
            entry["error"] = one.error
        else:
            entry |= one.result.to_dict()
            measured = one.summary or {}
            entry["measured_mm"] = {
                key.removesuffix("_mm"): round(value, 4) if np.isfinite(value) else None
                for key, value in measured.items()
            }
            if one.path is not None:
                entry["path"] = {
                    "name": one.path.name,
                    "setpoints_kpa": np.round(one.path.setpoints_kpa, 4).tolist(),
                    "holds_s": list(one.path.holds_s),
                }
        entries.append(entry)
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    partial.write_text(
        json.dumps({"model": str(model), "targets": entries}, indent=1) + "\n", encoding="utf-8"
    )
    partial.replace(path)
