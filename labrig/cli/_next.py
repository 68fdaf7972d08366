"""Commands: next, investigate."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app


@app.command("next")
def next_(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders or .mcap files.")],
    model: Annotated[Path, typer.Option("--model", help="The model file (model.yaml).")],
    rig: Annotated[Path, typer.Option("--rig", help="The rig that will measure it (rig.yaml).")],
    output: Annotated[Path, typer.Option("-o", "--output", help="The procedure file to write.")],
    minutes: Annotated[float, typer.Option(help="The longest that it may take, min.")] = 10.0,
    tolerance: Annotated[
        float | None, typer.Option(help="The smallest effect that matters, in the units of the run.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the procedure file.")] = False,
    out: Annotated[Path, typer.Option("--out", help="Folder for next.json and the report.")] = Path("next"),
) -> None:
    """Find the pressure programme that settles what a diagnosis leaves open, within the rig's limits.

    It becomes a procedure file: labrig run FILE --rig RIG.yaml --dry-run, then without --dry-run, then
    labrig diagnose with the runs so far and the new one.
    """
    from labrig.cli._next_steps import do_next

    do_next(runs, model, rig, output, minutes, tolerance, force, out)


@app.command()
def investigate(
    rig: Annotated[Path, typer.Option("--rig", help="The rig (rig.yaml).")],
    model: Annotated[Path, typer.Option("--model", help="The model file to question (model.yaml).")],
    budget: Annotated[float, typer.Option(min=1.0, help="Time on the rig, min.")] = 30.0,
    out: Annotated[Path, typer.Option("--out", help="Folder for runs, reports and the new model.")] = Path(
        "investigation"
    ),
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything that is random.")] = 0,
    highest: Annotated[
        float, typer.Option(min=0.1, max=1.0, help="Highest pressure of a campaign, share of the range.")
    ] = 0.85,
    resume: Annotated[bool, typer.Option("--resume", help="Resume an interrupted investigation.")] = False,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Let a rig that is simulated here take as long as a real one.")
    ] = False,
) -> None:
    """Measure, diagnose, measure what settles the doubt, and add what is missing, until settled or out of time."""
    from labrig.cli._investigate_steps import Settings, do_investigate

    do_investigate(Settings(rig, model, budget, out, seed, highest, realtime), resume)


__all__ = ["investigate", "next_"]
