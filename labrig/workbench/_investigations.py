"""How the investigations of the folder stand: read from the files that they write, and asked of those that go on."""

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._running import Note, notes
from labrig.investigation import OPEN, STATE
from labrig.investigation_contents import InvestigationContent, Round
from labrig.rig import investigations_on, is_there
from labrig.view import investigation_pictures
from labrig.workbench._child import INTERRUPTED
from labrig.workbench._desk import Desk
from labrig.workbench._ended import conclusion_said
from labrig.workbench._jobs import Job
from labrig.workbench._live import live_run

COMMAND = "investigate"
_PLACES = (f"*/{STATE}", f"*/*/{STATE}", f"*/*/*/{STATE}")
_LISTED = 8
_NEW = 1e12
"""Later than every moment of a run: who asks from then on gets no history."""


def going_on(desk: Desk) -> list[str]:
    """The investigations with the desk's rig or in its folder that go on, those of its jobs that only begin as well.

    By their names below the folder; of one that lies elsewhere the whole path.
    """
    names = [name_of(desk, note) for note in _on_rig(desk)]
    names += [name for note in _inside(desk) if (name := name_of(desk, note)) not in names and is_there(note)]
    return list(dict.fromkeys([*names, *(out_of(job) for job in jobs_of(desk) if job.state == "running")]))


def name_of(desk: Desk, note: Note) -> str:
    """What an investigation is called: its name below the folder, else its whole path."""
    folder = Path(str(note.facts["folder"]))
    return desk.name(folder) if folder.is_relative_to(desk.folder) else str(folder)


def note_of(desk: Desk, name: str) -> Note | None:
    """How to reach the investigation of this name, if it goes on."""
    known = [*_inside(desk), *_on_rig(desk)]
    return next((note for note in known if name_of(desk, note) == name and is_there(note)), None)


def jobs_of(desk: Desk, name: str = "") -> Iterator[Job]:
    """The jobs that investigate, the latest first; with a `name` those of this folder."""
    return (job for job in desk.jobs.all() if job.words[:1] == (COMMAND,) and name in ("", out_of(job)))


def out_of(job: Job) -> str:
    """The folder of a job that investigates."""
    return job.words[job.words.index("--out") + 1]


def part_of(desk: Desk, folder: Path) -> str:
    """The investigation that a run's folder belongs to; empty for every other run."""
    above = folder.parent
    inside = above != desk.folder and above.is_relative_to(desk.folder)
    return desk.name(above) if inside and (above / STATE).is_file() else ""


def listed(desk: Desk) -> list[dict[str, Any]]:
    """The investigations of the folder, the latest first: name, state and conclusion."""
    found = [
        path for place in _PLACES for path in desk.folder.glob(place) if not path.parts[-2].startswith(".")
    ]
    found.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    going, rows = going_on(desk), []
    for path in found[:_LISTED]:
        if (content := content_of(path.parent)) is not None:
            name = desk.name(path.parent)
            said = {"name": name, "conclusion": conclusion_said(content["conclusion"])}
            rows.append({**said, "state": _state(content, name in going)})
    known = {row["name"] for row in rows}
    return [{"name": name, "state": "begins", "conclusion": ""} for name in going if name not in known] + rows


def content_of(folder: Path) -> InvestigationContent | None:
    """What investigation.json says; None where there is none that can be read."""
    try:
        content = json.loads((folder / STATE).read_text(encoding="utf-8"))
        return content if content["settings"] and isinstance(content["rounds"], list) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def standing(desk: Desk, name: str) -> dict[str, Any]:
    """How an investigation stands; raises `LabrigError` where there is none of this name."""
    note = note_of(desk, name)
    if note is not None and not Path(str(note.facts["folder"])).is_relative_to(desk.folder):
        return {"name": name, "alive": True, "state": "goes on", "why": "", "can_resume": False, "rounds": []}
    content, job = content_of(desk.path(name)), next(jobs_of(desk, name), None)
    if content is None and job is None:
        raise LabrigError(f"{name or 'no name'}: is no investigation of this folder")
    alive = note is not None or (job is not None and job.state == "running")
    state = "begins" if alive else "not begun"
    if content is not None:
        state = _state(content, alive)
    said = {
        "name": name,
        "alive": alive,
        "state": state,
        "why": "" if alive or job is None else _why(job, content),
        "can_resume": content is not None and not alive and content["state"] in OPEN,
        "rounds": [],
    }
    return said if content is None else {**said, **_known(desk, name, content, alive)}


def _state(content: InvestigationContent, alive: bool) -> str:
    if alive:
        return "goes on" if content["state"] == "under way" else "begins"
    return "cut short" if content["state"] == "under way" else content["state"]


def _why(job: Job, content: InvestigationContent | None) -> str:
    """Why the last job of it failed, in one line, where its conclusion does not say so."""
    ended = job.ended
    if content is None and job.state == "cancelled":
        return "it was ended before anything was measured"
    if ended is None or ended.code == 0 or (content is not None and ended.code == INTERRUPTED):
        return ""
    line = job.facts()["last"].removeprefix("labrig: ")
    said = "" if content is None else content["conclusion"].removeprefix("Interrupted: ").removesuffix(".")
    return "" if said and line.startswith(said) else line or f"it was {job.state} before it began"


def _known(desk: Desk, name: str, content: InvestigationContent, alive: bool) -> dict[str, Any]:
    folder, rounds = desk.path(name), content["rounds"]
    model = content["model"]
    return {
        "conclusion": conclusion_said(content["conclusion"]),
        "minutes": content["minutes"],
        "budget_min": content["budget_min"],
        "units": content["units"],
        "confirmation": content["confirmation"],
        "warnings": content["warnings"],
        "settings": content["settings"],
        "rounds": [_round(desk, name, each) for each in rounds],
        "report": f"{name}/report.html" if rounds and (folder / "report.html").is_file() else "",
        "model": f"{name}/{Path(model).name}" if model is not None else "",
        "picture": investigation_pictures(content)["rounds"]() if _diagnosed(rounds) > 1 else None,
        "now": _now(desk, name, content) if alive else None,
    }


def _diagnosed(rounds: list[Round]) -> int:
    return sum(each["error"]["model"] is not None for each in rounds)


def _round(desk: Desk, name: str, each: Round) -> dict[str, Any]:
    report = each.get("report")
    runs = each["given"] if "given" in each else [f"{name}/{each['run']}"]
    return {
        **each,
        "runs": [{"name": run, "here": _is_here(desk, run)} for run in runs],
        "report": f"{name}/{report}" if report else "",
    }


def _is_here(desk: Desk, run: str) -> bool:
    with suppress(LabrigError, OSError):
        return desk.path(run).is_dir()
    return False


def _now(desk: Desk, name: str, content: InvestigationContent) -> dict[str, Any] | None:
    """What it does, with how far its run is, where that can be asked."""
    doing = content.get("now")
    if not doing:
        return None
    told: dict[str, Any] = {**doing, "live": "", "progress": None, "paused": False}
    if doing["what"] == "measuring" and (note := live_run(desk, f"{name}/{doing['run']}")) is not None:
        with suppress(LabrigError):
            status = note.ask("status", 2.0, since_s=_NEW, event=10**9)
            told |= {
                "live": f"{name}/{doing['run']}",
                "progress": status.get("progress"),
                "paused": status["paused"],
            }
    return told


def _on_rig(desk: Desk) -> list[Note]:
    rig = desk.known_rig()
    return [] if rig is None else investigations_on(rig)


def _inside(desk: Desk) -> list[Note]:
    return [n for n in notes("investigation") if Path(str(n.facts["folder"])).is_relative_to(desk.folder)]
