"""Pressures that were found for a shape, as `labrig ik` wrote them: how a search stands, and which ones there are."""

import json
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig.shape_contents import SolvedContent
from labrig.workbench._desk import Desk
from labrig.workbench._fits import base_file, base_rig
from labrig.workbench._jobs import Job
from labrig.workbench._shape_files import typed
from labrig.workbench._uploads import free_name

FOUND, REPORT = "ik.json", "report.html"
FOLDER = "shapes"
"""The folder below the desk's in which results are put unless somebody says otherwise."""
_PLACES = (f"*/{FOUND}", f"*/*/{FOUND}", f"*/*/*/{FOUND}")
_LISTED = 12
_COMMAND = "ik"


def found_in(desk: Desk, name: str) -> SolvedContent | None:
    """What a folder's ik.json says; None where there is none that can be read, or one of another labrig."""
    try:
        content = json.loads((desk.path(name) / FOUND).read_text(encoding="utf-8"))
        for entry in content["targets"]:
            known = "error" in entry or {"limits_kpa", "measured_mm", "inverted"} <= entry.keys()
            if not (known and entry["target"]):
                return None
        return content if content["targets"] and content["model"] else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def standing(desk: Desk, name: str) -> dict[str, Any]:
    """How a search stands: `state` of its job, `why` it failed, and what it `found`, with what has changed since."""
    job, content = _job(desk, name), found_in(desk, name)
    if job is None and content is None:
        raise LabrigError(f"{name or 'no name'}: holds no pressures for a shape ({FOUND}); find some first")
    state = "done" if job is None else job.state
    told: dict[str, Any] = {
        "name": name,
        "state": state,
        "job": "" if job is None else job.id,
        "command": "" if job is None else job.command,
        "why": _why(job) if job is not None and state in ("failed", "cancelled") else "",
        "found": None,
    }
    if content is None or state == "running":
        return told
    entry = content["targets"][0]
    if "error" in entry:
        return {**told, "state": "failed", "why": entry["error"]}
    report = desk.path(name) / REPORT
    return {
        **told,
        "model": content["model"],
        "found": entry,
        "others": [each["target"] for each in content["targets"][1:]],
        "changed": _changed(desk, desk.path(name) / FOUND, entry["target"], content["model"]),
        "report": desk.name(report) if report.is_file() else "",
        "file": f"{name}/{FOUND}",
    }


def solved_in(desk: Desk) -> list[dict[str, Any]]:
    """The results of the folder, the newest first: where, of which target and model, and the mean distance, mm."""
    paths = [path for place in _PLACES for path in desk.folder.glob(place) if not _is_hidden(desk, path)]
    paths.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    rows = []
    for path in paths[:_LISTED]:
        name = desk.name(path.parent)
        if (content := found_in(desk, name)) is None:
            continue
        entry = content["targets"][0]
        mean = None if "error" in entry else entry["measured_mm"].get("mean")
        rows.append({"name": name, "target": entry["target"], "model": content["model"], "mean_mm": mean})
    return rows


def new_name(desk: Desk, stem: str) -> str:
    """The name of a folder for the results of a target that there is not yet."""
    going, number = going_on(desk), 1
    name = f"{FOLDER}/{free_name(desk.folder / FOLDER, stem)}"
    while name in going:
        number += 1
        name = f"{FOLDER}/{free_name(desk.folder / FOLDER, f'{stem}-{number}')}"
    return name


def going_on(desk: Desk) -> set[str]:
    """The folders of the searches that go on, which may not be there yet."""
    return {
        job.words[-1] for job in desk.jobs.all() if job.words[:1] == (_COMMAND,) and job.state == "running"
    }


def _job(desk: Desk, name: str) -> Job | None:
    """The job that looked for it last."""
    return next(
        (job for job in desk.jobs.all() if job.words[:1] == (_COMMAND,) and job.words[-1] == name), None
    )


def _why(job: Job) -> str:
    return job.facts()["last"].removeprefix("labrig: ") or f"it was {job.state}"


def _changed(desk: Desk, path: Path, target: str, model: str) -> str:
    """Which of a target and a model, or of the files that the model names, is newer than the result, or gone, in words;
    empty where none is.
    """
    written = path.stat().st_mtime_ns
    files = [desk.folder / name for name in (target, model)]
    files += [each for each in (base_file(files[1]), base_rig(files[1])) if each is not None]
    for file in files:
        if not file.is_file():
            return f"{typed(desk, file)} is not there any more"
        if file.stat().st_mtime_ns > written:
            return f"{typed(desk, file)} was changed since"
    return ""


def _is_hidden(desk: Desk, path: Path) -> bool:
    return any(part.startswith(".") for part in path.relative_to(desk.folder).parts)
