"""Commands: validate."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app


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
    resume: Annotated[
        Path | None, typer.Option(metavar="RUN", help="Resume a validation, or write its report again.")
    ] = None,
) -> None:
    """Realise shapes on the rig, scan them, and compare with what was asked for and what the model expected.

    Each target: inverse kinematics, actuate, 3 s, markers, scan, registration, signed distances. The report lies in
    the run's folder. The procedure is `validate`: it is logged, vents, and resumes like any other.
    """
    from labrig.cli._validate_steps import ValidateRequest, do_report, do_validate

    if resume is not None:
        if targets or model is not None or out is not None:
            from labrig._errors import LabrigError

            raise LabrigError("--resume goes on with what the run was; it takes no targets, --model or --out")
        do_report(resume, rig)
        return
    do_validate(
        ValidateRequest(
            tuple(targets or ()), rig, model, out, tuple(without or ()), refine, unit, seed, realtime
        )
    )
