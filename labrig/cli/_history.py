"""Commands: history, check."""

from pathlib import Path
from typing import Annotated

import typer

from labrig._errors import LabrigError
from labrig.cli._app import app
from labrig.cli._places import check_folder, replaced

_ModelOption = Annotated[Path, typer.Option("--model", help="The model file (model.yaml).")]
_RunsOption = Annotated[Path, typer.Option("--runs", help="The folder that holds the rig's runs.")]
_OutOption = Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")]


@app.command()
def history(
    rig: Annotated[
        str, typer.Argument(metavar="RIG", help="The rig's name, as its runs have it, or its rig.yaml.")
    ],
    model: _ModelOption,
    runs: _RunsOption = Path("runs"),
    where: Annotated[
        str | None,
        typer.Option(metavar="CONDITION", help="Only runs of which it is true, as in labrig runs."),
    ] = None,
    out: _OutOption = Path("history"),
) -> None:
    """Show how a rig aged over all its runs: effects, noise, leaks, sensors, markers; and what changed, since when.

    Only changes that are more than chance are named: for a rig that stays as it is, whose runs scatter independently
    of each other, the chance that any is ever named is 5 % at most, however often you look. Dates are UTC.
    """
    import labrig
    from labrig.cli._history_steps import print_history, reading_progress

    check_folder(out)
    with reading_progress() as progress:
        found = labrig.history(rig, model, runs=runs, where=where, progress=progress)
    print_history(found)
    said = replaced(out / "report.html")
    typer.echo(f"report: {found.save(out)}{said}")


@app.command("check", context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def check_rig(
    context: typer.Context,
    rig: Annotated[Path, typer.Option("--rig", help="The rig file.")],
    model: _ModelOption,
    runs: _RunsOption = Path("runs"),
    out: _OutOption = Path("history"),
    resume: Annotated[
        Path | None, typer.Option(metavar="RUN", help="Go on with a check that was interrupted.")
    ] = None,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Let a rig that is simulated here take as long as a real one.")
    ] = False,
) -> None:
    """Run the morning's check (about 3 minutes), add it to the rig's history, and say what changed.

    It records an ordinary run with the tag check: rest, some set-points again and again, one long hold. Its parameters
    are options, as those of `labrig run check --help`. It measures the physics of a rig whose devices work; whether
    they do, and are wired right, is what `labrig rig check` tries.
    """
    from labrig.cli._history_steps import do_check, go_on_with_check

    check_folder(out)
    check_folder(runs, "--runs")
    if resume is None:
        do_check(rig, model, runs, out, context.args, realtime)
    elif context.args or realtime:
        raise LabrigError(
            "--resume goes on with what the check was; it takes no parameters and no --realtime"
        )
    else:
        go_on_with_check(rig, model, runs, out, resume)
