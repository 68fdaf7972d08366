"""Commands: investigate."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labrig.cli._app import app
from labrig.cli._complaints import StoppedError
from labrig.cli._places import check_folder
from labrig.cli._program import named
from labrig.contents import Proposed

if TYPE_CHECKING:
    from labrig.investigation import Reporter


@app.command()
def investigate(
    rig: Annotated[Path, typer.Option("--rig", help="The rig (rig.yaml).")],
    model: Annotated[Path, typer.Option("--model", help="The model file to question (model.yaml).")],
    runs: Annotated[
        list[Path] | None,
        typer.Argument(metavar="RUN...", help="Runs to begin with; else a first campaign is measured."),
    ] = None,
    budget: Annotated[
        float,
        typer.Option(help="Time on the rig, min. Without RUN: enough for a first campaign, on most rigs 4."),
    ] = 30.0,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for runs, reports and the new model.")
    ] = Path("investigation"),
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything that is random.")] = 0,
    highest: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            max=1.0,
            help="Highest pressure (or vacuum), as a share of the limit: 0.85, or with --resume what it was.",
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with an investigation that was interrupted.")
    ] = False,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Let a rig that is simulated here take as long as a real one.")
    ] = False,
) -> None:
    """Measure, diagnose, measure what settles the doubt, and add what is missing, until settled or out of time."""
    import labrig
    from labrig.cli._tables import print_investigation

    check_folder(out)
    words = [
        "investigate",
        *(runs or []),
        "--rig",
        rig,
        "--model",
        model,
        "--budget",
        f"{budget:g}",
        "--out",
        out,
    ]
    words += ["--seed", seed, *([] if highest is None else ["--highest", f"{highest:g}"])]
    again = named(*words, *(["--realtime"] if realtime else []), "--resume")
    try:
        found = labrig.investigate(
            runs or None,
            model,
            rig,
            out=out,
            budget_min=budget,
            seed=seed,
            highest=highest,
            resume=resume,
            realtime=realtime,
            reporter=_screen_reporter(again),
        )
    except KeyboardInterrupt as error:
        raise StoppedError(str(error) or "interrupted") from None
    print_investigation(found.summary)
    if found.model is not None:
        typer.echo(f"new model: {found.model.path}")
    typer.echo(f"report: {found.report}")


def _screen_reporter(again: str) -> "Reporter":
    """Prints each step, and shows the progress of each run; `again` is the command that goes on."""
    from labrig.campaign import Control, Watching
    from labrig.cli._run_screen import Screen
    from labrig.cli._tables import print_experiment
    from labrig.investigation import Lines

    class Terminal(Lines):
        def proposed(self, summary: Proposed) -> None:
            print_experiment(summary)

        @contextmanager
        def watching(self) -> Iterator[Watching]:
            control = Control()
            with Screen(control) as screen:
                yield Watching([screen], control)

        def how_to_resume(self, settings: Any) -> str:
            return again

    return Terminal(typer.echo)
