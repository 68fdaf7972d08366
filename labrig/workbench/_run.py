"""One run beside one model: which models and results there are, and which steps have something to show."""

import json
import re
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.catalogue import Row, list_runs
from labrig.log import run_id, segment_paths
from labrig.workbench._answers import answering
from labrig.workbench._desk import Desk

_MODEL = re.compile(rb"^base\s*:", re.MULTILINE)
_OTHERS = ("run.yaml", "rig.yaml", "notes.yaml")
_HEAD_BYTES = 4096


def routes(desk: Desk) -> list[Route]:
    """`/api/run`."""
    return [Route("/api/run", answering(lambda request: _run(desk, request)))]


def _run(desk: Desk, request: Request) -> Any:
    name = request.query_params.get("run", "")
    run = run_folder(desk, name)
    models = [desk.name(path) for path in models_of(desk, run)]
    model = request.query_params.get("model") or (models[0] if models else "")
    if model and model not in models:
        models = [desk.name(desk.existing(model)), *models]
    result = results_folder(desk, run, model) if model else None
    diagnosed = result is not None and (result / "diagnosis.json").is_file()
    has_model = True if model else "choose or make a model first"
    return {
        "run": name,
        "model": model,
        "models": models,
        "facts": _facts(_row(desk, run)),
        "result": desk.name(result) if result is not None else "",
        "diagnosed": diagnosed,
        "steps": {
            "compare": True,
            "where": has_model,
            "which": has_model,
            "add": True if diagnosed else "diagnose the run first",
            "watch": True,
        },
    }


def run_folder(desk: Desk, name: str) -> Path:
    """The run of this name; raises `LabrigError` where there is none."""
    run = desk.existing(name)
    if not run.is_dir() or not segment_paths(run):
        raise LabrigError(f"{name} is not a run: it holds no log")
    return run


def models_of(desk: Desk, run: Path) -> list[Path]:
    """The model files that lie with a run, beside it or above it in the folder, or in `models`; the nearest first."""
    places = [run, *(p for p in run.parents if p.is_relative_to(desk.folder)), desk.folder / "models"]
    found: dict[Path, None] = {}
    for place in places:
        own = [path for path in place.glob("*.yaml") if path.name not in _OTHERS and _is_model(path)]
        found |= dict.fromkeys(sorted(own, key=lambda path: (len(path.name), path.name)))
    return list(found)


def results_folder(desk: Desk, run: Path, model: str) -> Path:
    """Where the results of a run beside a model lie: where some are already, else a folder in the run's of its name."""
    own = run / Path(model).stem
    for place in (own, run, run.parent):
        if place.is_relative_to(desk.folder) and is_about(place / "diagnosis.json", run, desk.folder / model):
            return place
    return own


def is_about(path: Path, run: Path, model: Path) -> bool:
    """Whether a result file is of this run beside this model."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        runs = {each["id"] for each in content["runs"]}
        named = content["model"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    if run_id(run) not in runs or not named:
        return False
    told = Path(named)
    return model.resolve() in (told.resolve(), (path.parent / told).resolve()) or told.name == model.name


def _is_model(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return _MODEL.search(file.read(_HEAD_BYTES)) is not None
    except OSError:
        return False


def _row(desk: Desk, run: Path) -> Row:
    """The run as the catalogue has it; listing its own folder's parent alone would make another index."""
    name = desk.name(run)
    for row in list_runs(desk.folder):
        if row.run == name:
            return row
    return Row(run=name)


def _facts(row: Row) -> list[str]:
    captures = "" if row.captures is None else f"{row.captures} captures"
    return [text for text in (row.started and f"{row.started} UTC", row.rig, captures, row.state) if text]
