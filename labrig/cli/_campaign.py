"""Commands: run, runs, tag, note, show, recover, reveal."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig._errors import LabrigError
from labrig.cli._app import app
from labrig.cli._places import check_folder

if TYPE_CHECKING:
    from labrig.live import Settings

_RUN_SETTINGS = {"allow_extra_args": True, "ignore_unknown_options": True}
_RUN_NAME = typer.Argument(metavar="RUN", help="A run folder.")


@app.command(context_settings=_RUN_SETTINGS, add_help_option=False)
def run(
    context: typer.Context,
    procedure: Annotated[
        str,
        typer.Argument(
            metavar="PROCEDURE", help="A procedure's name, or a file (my_procedure.py, next.yaml)."
        ),
    ] = "",
    rig: Annotated[Path | None, typer.Option(help="The rig file.")] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="The run's folder; by default a new one in ./runs.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything that is random.")] = 0,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show the steps, the time and every broken limit; move nothing.")
    ] = False,
    resume: Annotated[Path | None, typer.Option(metavar="RUN", help="Resume an interrupted run.")] = None,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Let a rig that is simulated here take as long as a real one.")
    ] = False,
    live: Annotated[bool, typer.Option("--live", help="Watch in a window.")] = False,
    serve: Annotated[bool, typer.Option("--serve", help="Watch in a browser on this machine.")] = False,
    unattended: Annotated[
        bool,
        typer.Option(
            "--unattended",
            help="Nobody is near: only on a rig that vents by itself when this computer is gone.",
        ),
    ] = False,
    attended: Annotated[
        bool,
        typer.Option(
            "--attended", help="Somebody watches in the workbench: a fault pauses instead of ending."
        ),
    ] = False,
    model: Annotated[
        Path | None,
        typer.Option(
            help="Say first whether the rig is no longer what this model was fitted to (see labrig history); "
            "and while watching, show what its simulator predicts."
        ),
    ] = None,
    diagnose: Annotated[
        Path | None, typer.Option(metavar="MODEL", help="Diagnose this model beside the campaign.")
    ] = None,
    every: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="A diagnosis every N captures; by default 4.")
    ] = None,
    until: Annotated[
        str, typer.Option(help="End, vented, when it is settled, or at an error: settled, error=0.2mm.")
    ] = "",
    budget: Annotated[str, typer.Option(help="End, vented, before the rig took longer: 45min, 2h.")] = "",
    adapt: Annotated[
        bool, typer.Option("--adapt", help="Set-points that tell apart what is open, in place of the plan's.")
    ] = False,
    help: Annotated[bool, typer.Option("--help", help="Show this, or a procedure's parameters.")] = False,
) -> None:
    """Run a procedure: capture, check, hold, idle, pairs, programme, repeatability, survey, sweep, or one of your own.

    A procedure's parameters are options that follow its name; `labrig run PROCEDURE --help` lists them. Every limit
    is checked before anything moves, and however the run ends, the chambers are vented first. While it goes on,
    p pauses it (vented) and lets it go on, and so do SIGUSR1 and the workbench; Ctrl-C ends it.
    """
    from labrig.api._procedures import find_procedure, parameters_help, read_procedure
    from labrig.cli._run_steps import Request, do_dry_run, do_resume, do_run

    if help:
        typer.echo(context.get_help())
        if procedure:
            written = procedure.endswith((".yaml", ".yml"))
            kind = type(read_procedure(procedure, [])) if written else find_procedure(procedure)
            typer.echo("\n" + parameters_help(kind))
        return
    if attended and unattended:
        raise LabrigError("--attended or --unattended, not both")
    request = Request(rig, out, seed, realtime, live, serve, model, unattended, attended)
    follow = _follow_options(diagnose, every, until, budget, adapt)
    if resume is not None:
        if procedure or context.args or dry_run or out is not None:
            raise LabrigError(
                "--resume goes on with what the run was; it takes no procedure, parameters, --out or --dry-run"
            )
        if follow is not None:
            raise LabrigError(
                "--resume goes on with what the run was, its diagnosis too; leave --diagnose out"
            )
        do_resume(resume, request)
        return
    if not procedure:
        raise LabrigError("name a procedure (capture, ...; see labrig run --help), or a run with --resume")
    if rig is None:
        raise LabrigError("name the rig with --rig RIG.yaml")
    if dry_run:
        do_dry_run(procedure, context.args, request)
    else:
        do_run(procedure, context.args, replace(request, follow=follow))


def _follow_options(
    diagnose: Path | None, every: int | None, until: str, budget: str, adapt: bool
) -> "Settings | None":
    """What is asked of a live diagnosis; None where none is."""
    if diagnose is None:
        if every is not None or until or budget or adapt:
            raise LabrigError("--every, --until, --budget and --adapt are for --diagnose MODEL")
        return None
    from labrig.live import EVERY, Settings

    return Settings(str(diagnose.resolve()), every or EVERY, until, budget, adapt)


@app.command()
def runs(
    folder: Annotated[
        Path | None,
        typer.Argument(metavar="FOLDER", help="A folder that holds runs; else ./runs, or this one."),
    ] = None,
    where: Annotated[
        str | None,
        typer.Option(
            metavar="CONDITION",
            help="Only runs of which it is true: \"verdict == 'identified' and rig == 'lab'\".",
        ),
    ] = None,
    parquet: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write them to a Parquet file, with all columns.")
    ] = None,
) -> None:
    """List the runs in a folder: when, what, how far, how each ended, and what was found and said of it."""
    from labrig.cli._run_tables import print_runs

    print_runs(folder, where, parquet)


@app.command("tag")
def tag_run(
    run: Annotated[Path, _RUN_NAME],
    tags: Annotated[list[str], typer.Argument(metavar="TAG...", help="Words to find the run by.")],
    remove: Annotated[bool, typer.Option("--remove", help="Take them away.")] = False,
) -> None:
    """Give a run tags, kept in its folder."""
    from labrig.catalogue import tag

    kept = tag(run, tags, remove=remove)
    typer.echo(f"{run}: {', '.join(kept.tags) or 'no tags'}")


@app.command("rule-out")
def rule_out_in(
    run: Annotated[Path, _RUN_NAME],
    effect: Annotated[str, typer.Argument(metavar="EFFECT", help="The effect that could not act.")],
    session: Annotated[
        list[str] | None, typer.Option(help="Only in this session of the run; may be given again.")
    ] = None,
    remove: Annotated[bool, typer.Option("--remove", help="Take it back.")] = False,
) -> None:
    """Say of a run that an effect could not act in it, since somebody saw to that; kept in its folder.

    For a run in which an obstacle was taken away, the frame was registered anew, or pressures were set by a manometer.
    Diagnose it together with one in which the effect could act: what looks like it must be gone.
    """
    import labrig
    from labrig.catalogue import read_notes

    labrig.rule_out(run, effect, sessions=session or (), remove=remove)
    kept = read_notes(run).ruled_out_in_words
    typer.echo(f"{run}: {'ruled out: ' + kept if kept else 'nothing is ruled out'}")


@app.command("note")
def note_run(
    run: Annotated[Path, _RUN_NAME],
    text: Annotated[str, typer.Argument(metavar="TEXT", help="What is to be said of it, in quotes.")],
) -> None:
    """Write a note on a run, kept in its folder."""
    from labrig.catalogue import note

    kept = note(run, text)
    typer.echo(f"{run}: {len(kept.notes)} {'note' if len(kept.notes) == 1 else 'notes'}")


@app.command()
def show(run: Annotated[Path, _RUN_NAME]) -> None:
    """Show what a run is and holds: plan, steps, how still the markers were, what was lost."""
    from labrig.cli._run_tables import print_run

    print_run(run)


@app.command()
def recover(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder or an .mcap file.")],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The new run; by default RUN-recovered.")
    ] = None,
) -> None:
    """Copy all that is whole in a damaged run to a new one, and say what was lost."""
    from labrig._text import counted
    from labrig.log import recover as recover_run
    from labrig.log import summarise

    target = out or run.with_name(f"{run.name.removesuffix('.mcap')}-recovered")
    check_folder(target, "-o")
    lost = recover_run(run, target)
    for line in lost:
        typer.echo(f"lost: {line}")
    summary = summarise(target)
    typer.echo(
        f"{target}: {counted(summary.captures, 'capture')}, {counted(summary.steps_done, 'step')}; {run} is as it was"
    )


@app.command()
def reveal(run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder, or the demo's.")]) -> None:
    """Say what the simulated rig of a run hid."""
    from labrig_drivers.simulated import reveal as open_seal

    hidden = open_seal(run)
    effects = hidden.get("effects", [])
    if not effects:
        typer.echo("nothing was hidden")
    for effect in effects:
        size = f"{effect['amplitude']:g} {hidden.get('unit', 'mm')} rms"
        typer.echo(
            f"{effect['name']}: {size} over random set-points of the whole range; at others it is more or less"
        )
