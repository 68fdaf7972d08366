"""Commands: train."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app
from labrig.cli._group import Group

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
    from labrig.cli._train_steps import forward

    forward(simulations, output, method, paper, share, seed, slopes, out)


@train.command("sim2real")
def train_sim2real(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Run folder with markers, scans, or both.")],
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
    from labrig.cli._train_steps import sim2real

    sim2real(run, model, output, method, frames, seed, out)
