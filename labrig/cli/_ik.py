"""Commands: ik."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli._app import app
from labrig.cli._places import check_folder, replaced

if TYPE_CHECKING:
    from labrig.ik import Solved

_SHOWN = 40
_GAPS = 3
_SAID_S = 1.0


@app.command()
def ik(
    targets: Annotated[
        list[Path], typer.Argument(metavar="TARGET...", help="Shapes: OBJ, PLY, STL, or points in XYZ.")
    ],
    model: Annotated[
        Path, typer.Option("--model", help="forward.pt, sim2real.pt, or a model file (model.yaml).")
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")] = Path("ik"),
    rig: Annotated[Path | None, typer.Option(help="A rig file, for its limits.")] = None,
    unit: Annotated[
        str | None, typer.Option(help="Unit of the targets (mm, cm, m, inch), where it is not clear.")
    ] = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 for one per core.")] = 1,
    cluster: Annotated[str | None, typer.Option(help="Address of a Dask scheduler, tcp://...")] = None,
) -> None:
    """Find the pressures that bring a surface closest to given shapes, and where it cannot follow them."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    import labrig
    from labrig._executor import Executor
    from labrig.cli._console import new_console
    from labrig.ik import write_solved
    from labrig.view import write_ik_report

    check_folder(out)
    console = new_console(stderr=True)
    columns = TextColumn("targets"), BarColumn(), MofNCompleteColumn()
    with (
        Executor(workers, cluster) as executor,
        Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as shown,
    ):
        task = shown.add_task("targets", total=len(targets))
        solved = labrig.solve_ik(
            targets,
            model,
            rig=rig,
            unit=unit,
            executor=executor,
            progress=lambda done: shown.update(task, completed=done),
        )
    failed = [one for one in solved if one.result is None]
    if len(failed) == len(solved):
        more = f" (and {len(failed) - 1} more)" if len(failed) > 1 else ""
        raise labrig.LabrigError(failed[0].error + more)
    _print_table(solved)
    said = replaced(out / "report.html")
    report = write_ik_report(solved, str(model), out)
    write_solved(solved, model, out / "ik.json")
    for one in failed:
        name = Path(one.job.target).name
        typer.echo(f"labrig: {one.error}" if name in one.error else f"labrig: {name}: {one.error}", err=True)
    typer.echo(f"report: {report}{said}")
    if failed:
        raise typer.Exit(2)


def _print_table(solved: "Sequence[Solved]") -> None:
    from rich.table import Table

    from labrig.cli._console import new_console

    console = new_console()
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
