"""Commands: simulate."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app
from labrig.cli._places import check_folder


@app.command("simulate")
def simulate_command(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE", help="A rig.yaml with simulated.shell, a shell's YAML, or its name."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the simulations.")],
    count: Annotated[int, typer.Option(min=2, help="How many, corners of the range included.")] = 1000,
    jacobians: Annotated[bool, typer.Option("--jacobians", help="Derivatives by pressure as well.")] = False,
    seed: Annotated[
        int, typer.Option(min=0, max=2**31 - 1, help="Another seed spreads other pressures.")
    ] = 0,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 for one per core.")] = 0,
    cluster: Annotated[str | None, typer.Option(help="Address of a Dask scheduler, tcp://...")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where the folder was left.")] = False,
) -> None:
    """Solve the shell of a rig at many pressures, for models to be trained on."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from labrig.cli._console import new_console
    from labrig.physics import load_model_shell, simulate

    check_folder(out)
    shell = load_model_shell(source)
    console = new_console()
    columns = (
        TextColumn(f"simulating {shell.name}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("simulations", total=count)
        found = simulate(
            shell,
            out,
            count,
            jacobians=jacobians,
            seed=seed,
            workers=workers,
            cluster=cluster,
            resume=resume,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    failed = int((~found.converged).sum())
    lost = f", {failed} did not converge: see failures.json" if failed else ""
    typer.echo(f"{out}: {int(found.converged.sum())} simulations of {shell.name}{lost}")
