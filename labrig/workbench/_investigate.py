"""An investigation by clicks: what it would do, its start as a process of its own, how it stands, its end, going on."""

import time
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.investigation import HIGHEST
from labrig.rig import RigConfig, is_simulated
from labrig.workbench._answers import answering, body_of, says
from labrig.workbench._desk import Desk
from labrig.workbench._fits import misfit, names_of, names_of_rig
from labrig.workbench._investigations import (
    COMMAND,
    content_of,
    jobs_of,
    listed,
    note_of,
    standing,
)
from labrig.workbench._models import models_of, named
from labrig.workbench._moving import free_rig, refused, rig_of
from labrig.workbench._run import run_folder
from labrig.workbench._uploads import free_name

FOLDER = "investigation-"
"""How the folder of one is called, with its date: not below another, so that its runs are among those of the desk."""
MINUTES = 30.0
LOWEST = 0.1
"""The lowest share of the limit that a campaign may be held to, as the command has it."""
_MOST_MINUTES = 100_000.0


def routes(desk: Desk) -> list[Route]:
    """`/api/investigate`: GET what could be begun; `/api/investigate/state`; POST `start`, `end`, `resume`."""
    gets = {
        "": lambda request: _offer(desk, request.query_params.get("run", "")),
        "/state": lambda request: _state(desk, request.query_params.get("name", "")),
    }
    posts = {
        "/start": lambda request: _start(desk, request),
        "/resume": lambda request: _resume(desk, request),
        "/end": lambda request: _end(desk, str(body_of(request).get("name") or "")),
    }
    return [
        *(Route(f"/api/investigate{name}", answering(work)) for name, work in gets.items()),
        *(
            Route(f"/api/investigate{name}", answering(work), methods=["POST"])
            for name, work in posts.items()
        ),
    ]


def _offer(desk: Desk, run: str) -> Any:
    """What an investigation could begin with, what it would be called, and those that there are."""
    config = rig_of(desk)
    folder = run_folder(desk, run) if run else desk.folder / "none"
    names = names_of_rig(config)
    models = [path for path in models_of(desk, folder, names) if not misfit(path, names, named(desk, path))]
    return {
        "rig": config.name,
        "rig_file": str(desk.rig_file),
        "simulated": is_simulated(config),
        "models": [desk.name(path) for path in models],
        "other_rig": _other_rig(config, folder, run) if run else "",
        "minutes": MINUTES,
        "highest": HIGHEST,
        "lowest": LOWEST,
        "out": free_name(desk.folder, f"{FOLDER}{time.strftime('%Y%m%d-%H%M')}"),
        "known": listed(desk),
    }


def _state(desk: Desk, name: str) -> Any:
    """How one stands, and the command that goes on with it, where it can be gone on with."""
    told = standing(desk, name)
    if not told["can_resume"]:
        return told
    try:
        return {**told, "resume": desk.command(_again(desk, name)), "resume_why": ""}
    except LabrigError as error:
        return {**told, "resume": "", "resume_why": str(error)}


def _start(desk: Desk, request: Request) -> Any:
    """Begin one, as a process of its own, which no page and no server holds."""
    if (no := refused(desk, request)) is not None:
        return no
    asked = body_of(request)
    config = free_rig(desk, asked)
    model = _model(desk, config, str(asked.get("model") or ""))
    runs = [_fitting(desk, config, str(name)) for name in asked.get("runs") or []]
    budget, highest = _number(asked, "budget_min", MINUTES), _number(asked, "highest", HIGHEST)
    if not 0 < budget < _MOST_MINUTES:
        raise LabrigError(f"{asked.get('budget_min')}: give the time on the rig in minutes, more than 0")
    if not LOWEST <= highest <= 1:
        raise LabrigError(
            f"{asked.get('highest')}: the highest pressure is a share of the limit, {LOWEST:g} to 1"
        )
    out = desk.path(str(asked.get("out") or ""))
    if out == desk.folder or out.exists():
        raise LabrigError(f"{asked.get('out') or 'a name'}: choose the name of a new folder")
    words = [COMMAND, *runs, "--rig", str(desk.rig_file), "--model", model, "--budget", f"{budget:g}"]
    words += ["--highest", f"{highest:g}", "--out", desk.name(out)]
    if is_simulated(config) and asked.get("realtime", True):
        words.append("--realtime")
    return _begun(desk, words, f"investigate {config.name}", desk.name(out))


def _resume(desk: Desk, request: Request) -> Any:
    """Go on with one that was interrupted; nothing is measured twice."""
    if (no := refused(desk, request)) is not None:
        return no
    asked = body_of(request)
    name = str(asked.get("name") or "")
    if not standing(desk, name)["can_resume"]:
        raise LabrigError(f"{name}: cannot be gone on with; look how it stands")
    config = free_rig(desk, asked)
    budget = _number(asked, "budget_min", 0.0)
    return _begun(desk, _again(desk, name, budget), f"go on investigating {config.name}", name)


def _begun(desk: Desk, words: list[str], title: str, name: str) -> Any:
    job = desk.jobs.start(words, title)
    return says({"job": job.id, "name": name, "command": job.command}, 202)


def _end(desk: Desk, name: str) -> Any:
    """End one: the run that goes on vents and ends; what computes is interrupted, with nothing under pressure."""
    note = note_of(desk, name)
    answer = {"measuring": False} if note is None else note.ask("end", why="the workbench")
    job = next((job for job in jobs_of(desk, name) if job.state == "running"), None)
    if note is None and job is None:
        raise LabrigError(f"{name or 'no investigation'}: does not go on")
    if job is not None and not answer["measuring"]:
        desk.jobs.cancel(job)
    return answer


def _again(desk: Desk, name: str, budget_min: float = 0.0) -> list[str]:
    """The command that goes on with one as it was begun; raises `LabrigError` where that cannot be done from here."""
    content = content_of(desk.existing(name))
    if content is None:
        raise LabrigError(f"{name} holds no investigation that can be read")
    settings = content["settings"]
    if desk.rig_file is None or (desk.folder / settings["rig"]).resolve() != desk.rig_file:
        raise LabrigError(f"{name} was begun on the rig {settings['rig']}; open the workbench for that one")
    model = desk.name(desk.existing(_below(desk, settings["model"])))
    runs = [_below(desk, run) for run in settings["runs"]]
    if lost := [run for run in runs if not desk.path(run).is_dir()]:
        raise LabrigError(f"{name} began with {lost[0]}, which is not in this folder any more")
    words = [COMMAND, *runs, "--rig", str(desk.rig_file), "--model", model]
    words += [
        "--budget",
        f"{budget_min or settings['budget_min']:g}",
        "--highest",
        f"{settings['highest']:g}",
    ]
    words += ["--seed", str(settings["seed"]), "--out", name]
    return [*words, *(["--realtime"] if settings["realtime"] else []), "--resume"]


def _below(desk: Desk, path: str) -> str:
    """A path that the command was given, as a name below the folder, in which it was typed."""
    found = (desk.folder / path).resolve()
    if not found.is_relative_to(desk.folder):
        raise LabrigError(f"{path} lies outside the workbench's folder: go on in a terminal")
    return desk.name(found)


def _model(desk: Desk, config: RigConfig, name: str) -> str:
    path = desk.existing(name)
    if not path.is_file():
        raise LabrigError("choose a model, or make one")
    if other := misfit(path, names_of_rig(config), named(desk, path)):
        raise LabrigError(f"nothing was moved: {other}")
    return desk.name(path)


def _fitting(desk: Desk, config: RigConfig, name: str) -> str:
    folder = run_folder(desk, name)
    if other := _other_rig(config, folder, name):
        raise LabrigError(f"nothing was moved: {other}")
    return desk.name(folder)


def _other_rig(config: RigConfig, folder: Path, name: str) -> str:
    """That a run is of other chambers than the rig has; empty where nothing says so."""
    names, here = names_of(folder), [chamber.name for chamber in config.chambers]
    if names is None or set(names.chambers) == set(here):
        return ""
    return f"{name} is of chambers {', '.join(names.chambers)}; rig {config.name} has {', '.join(here)}"


def _number(asked: dict[str, Any], name: str, default: float) -> float:
    try:
        return float(asked.get(name) or default)
    except (TypeError, ValueError):
        raise LabrigError(f"{name} {asked[name]}: give a number") from None
