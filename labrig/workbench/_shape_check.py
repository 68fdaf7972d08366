"""A shape checked against scans on the rig: its plan, its start as a process of its own, how it stands, going on."""

import json
import time
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.api._validate import check_forms, validate_arguments
from labrig.catalogue import list_runs
from labrig.log import read_run_yaml
from labrig.rig import is_simulated
from labrig.shape_contents import Realisation
from labrig.workbench._answers import answering, body_of, says
from labrig.workbench._desk import Desk
from labrig.workbench._ended import row_said
from labrig.workbench._jobs import Job
from labrig.workbench._live import alive, now
from labrig.workbench._moving import check_plan, free_rig, new_run, plan_of, refused, rig_of
from labrig.workbench._run import run_folder
from labrig.workbench._shape_files import chosen, models_of_shapes, targets_of, typed
from labrig.workbench._uploads import free_name

CHECKED, REPORT = "validation.json", "report.html"
COMMAND = "validate"
MOST_REFINED = 20
"""Scans more for each target, as the command has it."""
_LISTED = 12
_LATER_S = 1e12


def check_routes(desk: Desk) -> list[Route]:
    """`/api/shape/check`: GET how one stands; POST `plan`, `start`, `resume`."""
    posts = {
        "/plan": lambda request: _plan(desk, body_of(request)),
        "/start": lambda request: _start(desk, request),
        "/resume": lambda request: _resume(desk, request),
    }
    return [
        Route("/api/shape/check", answering(lambda r: _standing(desk, r.query_params.get("run", "")))),
        *(
            Route(f"/api/shape/check{name}", answering(work), methods=["POST"])
            for name, work in posts.items()
        ),
    ]


def checks_of(desk: Desk) -> list[dict[str, Any]]:
    """The runs of the folder that checked shapes, the newest first, with the mean distances, mm, of the first."""
    rows = [row_said(row) for row in list_runs(desk.folder) if row.procedure == COMMAND][:_LISTED]
    told = []
    for row in rows:
        found = _found(desk.folder / row.run)
        first = found[0]["realised_mm"] if found else None
        told.append(
            {
                "run": row.run,
                "started": row.started,
                "state": row.state,
                "targets": list(dict.fromkeys(each["target"] for each in found or [])),
                "realised_mm": first and first["mean"],
            }
        )
    return told


def _asked(desk: Desk, asked: dict[str, Any]) -> tuple[Path, Path, list[str], int, str]:
    """Target, model, forms to leave out, scans more, and the target's unit that a page names."""
    target = chosen(desk, asked.get("target"), targets_of(desk), "a target")
    model = chosen(desk, asked.get("model"), [each["name"] for each in models_of_shapes(desk)], "a model")
    without = [str(form) for form in asked.get("without") or []]
    check_forms(without)
    try:
        refine = int(asked.get("refine") or 0)
    except (TypeError, ValueError, OverflowError):
        refine = -1
    if not 0 <= refine <= MOST_REFINED:
        raise LabrigError(f"scans more: a whole number, 0 to {MOST_REFINED}, not {asked.get('refine')}")
    return target, model, without, refine, str(asked.get("unit") or "")


def _planned(desk: Desk, target: Path, model: Path, without: list[str], refine: int, unit: str) -> Any:
    """What the check would do; every set-point of it is held against the limits, and nothing is moved."""
    return plan_of(desk, COMMAND, validate_arguments([target], model, without, refine, unit), 0)


def _plan(desk: Desk, asked: dict[str, Any]) -> Any:
    """What the rig would do; a start sends back what was `asked`, and the plan's name with it."""
    config = rig_of(desk)
    given, stem = _asked(desk, asked), f"{time.strftime('%Y%m%d-%H%M%S')}-{COMMAND}"
    return {
        **_planned(desk, *given),
        "asked": {name: asked.get(name) for name in ("target", "model", "without", "refine", "unit")},
        "scanner": config.scanner is not None,
        "simulated": is_simulated(config),
        "out": f"runs/{free_name(desk.folder / 'runs', stem)}",
        "command": desk.command(_words(desk, *given)),
    }


def _start(desk: Desk, request: Request) -> Any:
    """Begin the check whose plan was shown, as a process of its own, which no page and no server holds."""
    if (no := refused(desk, request)) is not None:
        return no
    asked = body_of(request)
    given = _asked(desk, asked)
    config = free_rig(desk, asked)
    check_plan(_planned(desk, *given), asked.get("plan"))
    run = desk.name(new_run(desk, asked))
    words = [*_words(desk, *given), "--out", run, "--attended"]
    if is_simulated(config) and asked.get("realtime", True):
        words.append("--realtime")
    job = desk.jobs.start(words, f"check {given[0].name} on {config.name}", run)
    return says({"job": job.id, "run": run, "command": job.command}, 202)


def _resume(desk: Desk, request: Request) -> Any:
    """Go on with a check that was ended before its plan was, nothing is scanned twice; or, of one whose plan was done,
    compare what was scanned, which moves nothing.
    """
    asked = body_of(request)
    run = desk.name(run_folder(desk, str(asked.get("run") or "")))
    told = _standing(desk, run)
    if not told["can_resume"] and not told["can_compare"]:
        raise LabrigError(f"{run}: cannot be gone on with; look how it stands")
    words = [COMMAND, "--resume", run]
    if told["can_resume"]:
        if (no := refused(desk, request)) is not None:
            return no
        free_rig(desk, asked)
        words = resume_words(desk, run)
    job = desk.jobs.start(words, f"go on checking {Path(run).name}", run)
    return says({"job": job.id, "run": run, "command": job.command}, 202)


def resume_words(desk: Desk, run: str) -> list[str]:
    """The command that goes on with a check, to its report."""
    return [COMMAND, "--resume", run, "--rig", str(desk.rig_file), "--attended"]


def _words(desk: Desk, target: Path, model: Path, without: list[str], refine: int, unit: str) -> list[str]:
    words = [COMMAND, typed(desk, target), "--rig", str(desk.rig_file), "--model", typed(desk, model)]
    words += [word for form in without for word in ("--without", form)]
    words += ["--refine", str(refine)] if refine else []
    return words + (["--unit", unit] if unit else [])


def _standing(desk: Desk, run: str) -> dict[str, Any]:
    """How a check stands: whether it goes on, how its run ended and whether that vented, what it `found`."""
    job = next((each for each in desk.jobs.all() if each.run == run and each.words[:1] == (COMMAND,)), None)
    folder = desk.path(run)
    begun = (folder / "run.yaml").is_file()
    if job is None and not (begun and read_run_yaml(folder).get("procedure") == COMMAND):
        raise LabrigError(f"{run or 'no name'}: is no check of a shape in this folder")
    state = "done" if job is None else job.state
    told = {
        "run": run,
        "state": state,
        "job": "" if job is None else job.id,
        "command": "" if job is None else job.command,
        "measuring": run in alive(desk),
        "begun": begun,
        "why": _why(job) if job is not None and state == "failed" else "",
        "found": None,
        "ended": "",
        "vented": False,
        "can_resume": False,
        "can_compare": False,
    }
    if told["measuring"] or state == "running" or not begun:
        return told
    found, report = _found(folder), folder / REPORT
    try:
        ended = now(desk, run, _LATER_S, 10**9)
    except LabrigError as error:  # it left no log: nothing was moved
        return {**told, "begun": False, "why": told["why"] or str(error)}
    whole = ended["state"] == "completed"
    return {
        **told,
        "found": found,
        "chambers": _chambers(folder),
        "report": desk.name(report) if found and report.is_file() else "",
        "ended": ended["state"],
        "vented": ended.get("vented", False),
        "can_resume": found is None and not whole,
        "can_compare": found is None and whole,
    }


def _found(folder: Path) -> list[Realisation] | None:
    """What validation.json says; None where there is none that can be read."""
    try:
        found = json.loads((folder / CHECKED).read_text(encoding="utf-8"))["realisations"]
        return found if all(each["target"] and "realised_mm" in each for each in found) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _chambers(folder: Path) -> list[str]:
    """The chambers of a run's rig, in the order of its pressures."""
    return [str(chamber["name"]) for chamber in read_run_yaml(folder)["rig"]["chambers"]]


def _why(job: Job) -> str:
    return job.facts()["last"].removeprefix("labrig: ") or f"it was {job.state}"
