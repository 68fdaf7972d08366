"""Commands: validate."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from labrig._errors import LabrigError
from labrig.api._validate import validate_arguments
from labrig.cli._app import app
from labrig.cli._places import check_folder
from labrig.shape_contents import Realisation

_NARROW = 0.8
"""Share of a target that a scan shows, below which it is said beside the table."""


@app.command()
def validate(
    targets: Annotated[
        list[Path] | None, typer.Argument(metavar="TARGET...", help="Shapes: OBJ, PLY, STL, XYZ.")
    ] = None,
    rig: Annotated[Path | None, typer.Option(help="The rig file.")] = None,
    model: Annotated[
        Path | None, typer.Option("--model", help="forward.pt, sim2real.pt, or a model file.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="The run's folder; by default a new one in ./runs.")
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option(help="Realise the targets once more without: warp, effects.")
    ] = None,
    refine: Annotated[int, typer.Option(min=0, max=20, help="Scans more a target, to come closer.")] = 0,
    unit: Annotated[str, typer.Option(help="Unit of the targets, where it is not clear.")] = "",
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything that is random.")] = 0,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Let a rig that is simulated here take as long as a real one.")
    ] = False,
    attended: Annotated[
        bool,
        typer.Option(
            "--attended", help="Somebody watches in the workbench: a fault pauses instead of ending."
        ),
    ] = False,
    resume: Annotated[
        Path | None, typer.Option(metavar="RUN", help="Resume a validation, or write its report again.")
    ] = None,
) -> None:
    """Realise shapes on the rig, scan them, and compare with what was asked for and what the model expected.

    Each target: inverse kinematics, actuate, 3 s, markers, scan, registration, signed distances. The report lies in
    the run's folder. The procedure is `validate`: it is logged, vents, and resumes like any other.
    """
    from labrig.cli._run_steps import Request, do_run

    if resume is not None:
        if targets or model is not None or out is not None:
            raise LabrigError("--resume goes on with what the run was; it takes no targets, --model or --out")
        report(_finished(resume, rig, attended))
        return
    if not targets or model is None or rig is None:
        raise LabrigError(
            "name the targets, the rig with --rig and the model with --model (or a run with --resume)"
        )
    folder = out or Path("runs") / f"{datetime.now():%Y%m%d-%H%M%S}-validate"
    check_folder(folder)
    words = validate_arguments(targets, model, without or [], refine, unit)
    do_run("validate", words, Request(rig, folder, seed, realtime, False, False, attended=attended))
    report(folder)


def _finished(run: Path, rig: Path | None, attended: bool) -> Path:
    """A run of validate, gone on with where it was not finished."""
    from labrig.cli._run_steps import Request, do_resume
    from labrig.log import read_run_yaml, summarise

    if not run.is_dir():
        raise LabrigError(f"{run} is no run folder; `labrig runs` lists those in ./runs")
    if read_run_yaml(run).get("procedure") != "validate":
        raise LabrigError(f"{run} is no run of validate")
    if summarise(run).state != "completed":
        do_resume(run, Request(rig, run, 0, False, False, False, attended=attended))
    return run


def report(run: Path) -> None:
    """Compare, print, and write validation.json and report.html into the run's folder."""
    import labrig

    found = labrig.validate(run)
    _print(found.summary["realisations"])
    typer.echo(f"report: {found.save()}")


def _print(summaries: Sequence[Realisation]) -> None:
    from rich.table import Table

    from labrig.cli._console import new_console

    table = Table(
        "target",
        "model",
        title="mean distance, mm; best: the hardware's; differ: realised from predicted",
        padding=(0, 0, 0, 1),
    )
    for column in ("best", "predicted", "realised", "differ", "markers", "refined"):
        table.add_column(column, justify="right")
    for one in summaries:
        refined = [again["realised_mm"]["mean"] for again in one["refined"] if again["realised_mm"]]
        first = [one["realised_mm"]["mean"]] if one["realised_mm"] else []
        table.add_row(
            one["target"],
            one["model"].removeprefix("the ").removesuffix(" model"),
            *(
                "-" if found is None else f"{found['mean']:.3f}"
                for found in (
                    one["hardware_mm"],
                    one["predicted_mm"],
                    one["realised_mm"],
                    one["realised_against_predicted_mm"],
                    one["markers_against_predicted_mm"],
                )
            ),
            f"{min([*refined, *first]):.3f} ({len(refined)})" if refined else "-",
        )
    new_console().print(table)
    for one in summaries:
        if one["compared"] is not None and one["compared"] < _NARROW:
            typer.echo(
                f"{one['target']}, {one['model']}: the scan shows {one['compared']:.0%} of it, and nothing is known of "
                "the rest"
            )
