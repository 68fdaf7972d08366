"""Commands: train."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli._app import app
from labrig.cli._group import Group
from labrig.cli._places import check_file, check_folder, replaced

if TYPE_CHECKING:
    from labrig.view import Table

train = typer.Typer(
    help="Train the forward model on simulations, and its sim-to-real correction on a run of the rig.",
    cls=Group,
)
app.add_typer(train, name="train")

OutputOption = Annotated[Path, typer.Option("-o", "--output", help="The model file to write.")]
ReportOption = Annotated[Path, typer.Option("--out", help="Folder for the report.")]


@train.command("forward")
def train_forward(
    simulations: Annotated[Path, typer.Argument(metavar="SIMS", help="Folder that labrig simulate made.")],
    output: OutputOption,
    method: Annotated[str, typer.Option(help="gaussian, network, or paper.")] = "gaussian",
    paper: Annotated[bool, typer.Option("--paper", help="Also train the source paper's network.")] = False,
    share: Annotated[
        float,
        typer.Option(min=0.01, max=0.99, help="Training fraction: the share of the simulations to train on."),
    ] = 0.7,
    seed: Annotated[int, typer.Option(min=0, help="Seed for the split and for network training.")] = 0,
    slopes: Annotated[bool, typer.Option(help="Use derivatives, if the simulations have them.")] = True,
    out: ReportOption = Path("train"),
) -> None:
    """Train the forward model, pressures to shape, and test it on held-out simulations."""
    import labrig
    from labrig.surrogate import save_model
    from labrig.view import forward_table, write_forward_report

    check_file(output)
    check_folder(out)
    trained = [
        labrig.train_forward(simulations, method=name, share=share, seed=seed, slopes=slopes)
        for name in dict.fromkeys([method, "paper"] if paper else [method])
    ]
    model = trained[0].model
    of_model, of_report = replaced(output), replaced(out / "report.html")
    save_model(model, output)
    count = model.provenance["source"]["count"]
    table = forward_table(trained)
    _print(table, f"{count} simulations, errors in mm on those that were not learned from")
    report = write_forward_report(trained, output.name, out)
    for note in trained[0].notes:
        typer.echo(f"labrig: {note}", err=True)
    typer.echo(f"{output}: forward model of {len(model.chamber_names)} chambers{of_model}")
    typer.echo(f"report: {report}{of_report}")


@train.command("sim2real")
def train_sim2real(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Run folders with markers, scans, or both.")
    ],
    model: Annotated[Path, typer.Option("--forward", help="The forward model (labrig train forward).")],
    output: OutputOption,
    method: Annotated[
        str, typer.Option(help="ours (markers), scans, both, or the paper's function and marker.")
    ] = "ours",
    frames: Annotated[
        int | None, typer.Option(min=2, help="Use only so many frames, the first ones.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed for network training (function, marker).")] = 0,
    out: ReportOption = Path("train"),
) -> None:
    """Train the sim-to-real correction: how the rig's shapes differ from the simulated ones."""
    import labrig
    from labrig.surrogate import save_model
    from labrig.view import sim2real_table, write_sim2real_report

    check_file(output)
    check_folder(out)
    of = ", ".join(run.name for run in runs)
    trained = labrig.train_sim2real(runs, model, method=method, frames=frames, seed=seed)
    of_model, of_report = replaced(output), replaced(out / "report.html")
    save_model(trained.model, output)
    if len(trained.fixed_mm):
        where = ", across the surface" if trained.across else ""
        _print(sim2real_table(trained), f"{of}, method {method}: errors in mm{where}, at held-out points")
    else:
        typer.echo(trained.left_out)
    report = write_sim2real_report(trained, of, method, output.name, out)
    for note in trained.notes:
        typer.echo(f"labrig: {note}", err=True)
    typer.echo(f"{output}: the corrected model{of_model}")
    typer.echo(f"report: {report}{of_report}")


def _print(words: "Table", title: str) -> None:
    from rich.table import Table

    from labrig.cli._console import new_console

    table = Table(title=title)
    for index, name in enumerate(words.head):
        table.add_column(name, justify="left" if index == 0 else "right", no_wrap=True)
    for row in words.rows:
        table.add_row(*row)
    new_console().print(table)
