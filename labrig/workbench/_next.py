"""What to measure next, and two models on the same run: the parts of Watch that come before and after the rig."""

import json
from pathlib import Path
from typing import Any

from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.workbench._answers import answering, body_of, says
from labrig.workbench._desk import Desk
from labrig.workbench._jobs import command_line
from labrig.workbench._run import models_of, results_folder, run_folder


def routes(desk: Desk) -> list[Route]:
    """`/api/next`, `/api/versus`: GET what is known, POST to have it computed as a job."""
    return [
        Route("/api/next", answering(lambda r: _next(desk, r.query_params))),
        Route("/api/next", answering(lambda r: _propose(desk, body_of(r))), methods=["POST"]),
        Route("/api/versus", answering(lambda r: _versus(desk, r.query_params))),
        Route("/api/versus", answering(lambda r: _compare(desk, body_of(r))), methods=["POST"]),
    ]


def _run_and_model(desk: Desk, asked: Any) -> tuple[str, str, Path]:
    run = str(asked.get("run") or "")
    folder = run_folder(desk, run)
    models = [desk.name(path) for path in models_of(desk, folder)]
    model = str(asked.get("model") or (models[0] if models else ""))
    if not model:
        raise LabrigError(f"{run} has no model yet: choose or make one first")
    desk.existing(model)
    return run, model, results_folder(desk, folder, model)


def _next_words(desk: Desk, run: str, model: str, results: Path, minutes: float) -> list[str]:
    if desk.rig_file is None:
        raise LabrigError("its limits are needed: start the workbench with: labrig workbench --rig RIG.yaml")
    words = ["next", run, "--model", model, "--rig", str(desk.rig_file), "--minutes", f"{minutes:g}"]
    return [
        *words, "-o", desk.name(results / "next.yaml"), "--out", desk.name(results / "next"), "--force",
    ]  # fmt: skip


def _next(desk: Desk, asked: Any) -> Any:
    """The programme that was found for a run and a model, as next.json has it; None where none was looked for."""
    run, model, results = _run_and_model(desk, asked)
    found = _read(results / "next" / "next.json")
    procedure = results / "next.yaml"
    minutes = float(asked.get("minutes") or 10.0)
    able = desk.rig_file is not None
    return {
        "found": found,
        "procedure": desk.name(procedure) if found is not None and procedure.is_file() else "",
        "command": command_line(_next_words(desk, run, model, results, minutes)) if able else "",
    }


def _propose(desk: Desk, asked: dict[str, Any]) -> Any:
    run, model, results = _run_and_model(desk, asked)
    words = _next_words(desk, run, model, results, float(asked.get("minutes") or 10.0))
    results.mkdir(parents=True, exist_ok=True)
    job = desk.jobs.start(words, "what to measure next", run)
    return says({"job": job.id, "command": job.command}, 202)


def _versus_words(desk: Desk, run: str, models: list[str]) -> tuple[list[str], Path]:
    if len(set(models)) != 2:
        raise LabrigError("choose two models: the one before and the one after")
    stems = [Path(model).stem for model in models]
    for model in models:
        desk.existing(model)
    folder = run_folder(desk, run) / f"{stems[0]}-and-{stems[1]}"
    words = ["compare", run, "--model", models[0], "--model", models[1], "--out", desk.name(folder)]
    return words, folder


def _versus(desk: Desk, asked: Any) -> Any:
    """Two models on one run, as comparison.json has it; None where they were not compared yet."""
    run, models = str(asked.get("run") or ""), [str(asked.get("a") or ""), str(asked.get("b") or "")]
    words, folder = _versus_words(desk, run, models)
    return {"found": _read(folder / "comparison.json"), "command": command_line(words)}


def _compare(desk: Desk, asked: dict[str, Any]) -> Any:
    run, models = str(asked.get("run") or ""), [str(asked.get("a") or ""), str(asked.get("b") or "")]
    words, _ = _versus_words(desk, run, models)
    job = desk.jobs.start(words, "two models on one run", run)
    return says({"job": job.id, "command": job.command}, 202)


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
