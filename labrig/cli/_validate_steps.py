"""What `labrig validate` does: run the procedure, or go on with it, then compare and report."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.table import Table

from labrig._errors import LabrigError
from labrig.api._validate import FORMS, validate
from labrig.cli._places import check_folder
from labrig.cli._run_steps import Request, do_resume, do_run
from labrig.log import read_run_yaml, summarise


@dataclass(frozen=True)
class ValidateRequest:
    """The options of `labrig validate`."""

    targets: tuple[Path, ...]
    rig: Path | None
    model: Path | None
    out: Path | None
    without: tuple[str, ...]
    refine: int
    unit: str
    seed: int
    realtime: bool


def do_validate(request: ValidateRequest) -> None:
    """Run the procedure in a new folder, then report there."""
    if not request.targets or request.model is None or request.rig is None:
        raise LabrigError(
            "name the targets, the rig with --rig and the model with --model (or a run with --resume)"
        )
    for form in request.without:
        if form not in FORMS:
            raise LabrigError(f"--without {form}: there are {' and '.join(FORMS)}")
    for path in (*request.targets, request.model):
        if "," in str(path):
            raise LabrigError(f"{path}: a name without a comma is needed")
        if not path.is_file():
            raise LabrigError(f"{path} does not exist")
    folder = request.out or _new_folder()
    check_folder(folder)
    arguments = [
        "--targets", ",".join(str(path.resolve()) for path in request.targets),
        "--model", str(request.model.resolve()),
        "--refine", str(request.refine),
    ]  # fmt: skip
    if request.without:
        arguments += ["--without", ",".join(request.without)]
    if request.unit:
        arguments += ["--unit", request.unit]
    do_run("validate", arguments, Request(request.rig, folder, request.seed, request.realtime, False, False))
    report(folder)


def do_report(run: Path, rig: Path | None) -> None:
    """Go on with a run that was not finished; report in either case."""
    if not run.is_dir():
        raise LabrigError(f"{run} is no run folder; `labrig runs` lists those in ./runs")
    if read_run_yaml(run).get("procedure") != "validate":
        raise LabrigError(f"{run} is no run of validate")
    if summarise(run).state != "completed":
        do_resume(run, Request(rig, run, 0, False, False, False))
    report(run)


def report(run: Path) -> None:
    """Compare, print, and write validation.json and report.html into the run's folder."""
    found = validate(run)
    _print(found.summary["realisations"])
    typer.echo(f"report: {found.save()}")


def _print(summaries: Sequence[dict[str, Any]]) -> None:
    table = Table(
        "target", "model", title="mean distance from the target, mm; differ: realised from predicted"
    )
    for column in ("hardware", "predicted", "realised", "differ", "markers", "refined"):
        table.add_column(column, justify="right")
    for one in summaries:
        refined = [again["realised_mm"]["mean"] for again in one["refined"] if again["realised_mm"]]
        table.add_row(
            one["target"],
            one["model"].removeprefix("the ").removesuffix(" model"),
            *(
                "-" if one[key] is None else f"{one[key]['mean']:.3f}"
                for key in (
                    "hardware_mm",
                    "predicted_mm",
                    "realised_mm",
                    "realised_against_predicted_mm",
                    "markers_against_predicted_mm",
                )
            ),
            f"{min([*refined, one['realised_mm']['mean']]):.3f} ({len(refined)})" if refined else "-",
        )
    Console().print(table)


def _new_folder() -> Path:
    from datetime import datetime

    return Path("runs") / f"{datetime.now():%Y%m%d-%H%M%S}-validate"
