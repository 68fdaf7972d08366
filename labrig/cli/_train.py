"""Commands: train."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app
from labrig.cli._group import Group

train = typer.Typer(
    help="Learn the forward model from simulations, and its fix from a run of the rig.", cls=Group
)
app.add_typer(train, name="train")

OutputOption = Annotated[Path, typer.Option("-o", "--output", help="The model file to write.")]
ReportOption = Annotated[Path, typer.Option("--out", help="Folder for the report.")]


@train.command("forward")
def train_forward(
    simulations: Annotated[Path, typer.Argument(metavar="SIMS", help="Folder that labrig simulate made.")],
    output: OutputOption,
    method: Annotated[str, typer.Option(help="gaussian, network, or paper.")] = "gaussian",
    paper: Annotated[bool, typer.Option("--paper", help="The source paper's network beside it.")] = False,
    share: Annotated[float, typer.Option(min=0.01, max=0.99, help="Part that is learned from.")] = 0.7,
    seed: Annotated[int, typer.Option(min=0, help="Another seed is another split.")] = 0,
    slopes: Annotated[bool, typer.Option(help="Use derivatives, if the simulations have them.")] = True,
    out: ReportOption = Path("train"),
) -> None:
    """Learn which shape the simulator makes of which pressures; measured on shapes it did not see."""
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
    frames: Annotated[int | None, typer.Option(min=2, help="Learn from the first frames only.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Chance of the paper's networks.")] = 0,
    out: ReportOption = Path("train"),
) -> None:
    """Learn how the rig's shapes differ from the simulated ones."""
    from labrig.cli._train_steps import sim2real

    sim2real(run, model, output, method, frames, seed, out)
