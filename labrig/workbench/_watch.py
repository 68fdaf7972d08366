"""Watch: the plan of a campaign, its start, what it does while it runs, pause, go on, end; what to measure next."""

from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.api._procedures import shipped
from labrig.log import read_run_yaml
from labrig.rig import RigConfig
from labrig.view import CHAMBER_COLOURS
from labrig.workbench._answers import answering, body_of, query_of, says
from labrig.workbench._desk import Desk
from labrig.workbench._fits import misfit, names_of, names_of_rig
from labrig.workbench._investigations import going_on, part_of
from labrig.workbench._live import Errors, alive, diagnosed_with, live_run, now, surface
from labrig.workbench._models import models_of, named
from labrig.workbench._moving import check_plan, idle, new_run, plan_of, refused, rig_of
from labrig.workbench._planned import chambers_of
from labrig.workbench._run import run_folder
from labrig.workbench._seeds import free_seed, seed_of
from labrig.workbench._shape_check import COMMAND as CHECK
from labrig.workbench._shape_check import resume_words

_PLACES = ("*.yaml", "procedures/*.yaml", "*/*/next.yaml", "*/*/*/next.yaml", "*/*/*/*/next.yaml")
"""Where procedure files are looked for; `_next` puts its own into a folder of the run's results."""


def routes(desk: Desk) -> list[Route]:
    """`/api/watch/...`."""
    errors = Errors()
    desk.at_end.append(errors.close)
    gets = {
        "rig": lambda request: _rig(desk),
        "seed": lambda request: {
            "seed": free_seed(desk, rig_of(desk), request.query_params.get("procedure", ""))
        },
        "models": lambda request: _models(desk, request.query_params.get("run", "")),
        "now": lambda request: _now(desk, request, errors),
        "skin": lambda request: _skin(desk, request),
    }
    posts = {
        "plan": lambda request: _plan(desk, body_of(request)),
        "start": lambda request: _start(desk, request),
        "resume": lambda request: _resume(desk, request),
        "pause": lambda request: _tell(desk, request, "pause"),
        "go_on": lambda request: _tell(desk, request, "go_on"),
        "end": lambda request: _tell(desk, request, "end"),
    }
    return [
        *(Route(f"/api/watch/{name}", answering(work)) for name, work in gets.items()),
        *(Route(f"/api/watch/{name}", answering(work), methods=["POST"]) for name, work in posts.items()),
    ]


def _rig(desk: Desk) -> Any:
    """The rig of this workbench, where its vent button is, what goes on, and what could be run."""
    always = {
        "running": alive(desk),
        "investigating": going_on(desk),
        "vent": desk.vent.place if desk.vent is not None else None,
    }
    if desk.rig is None:
        return {"rig": None, **always}
    try:
        config = rig_of(desk)
    except LabrigError as error:
        return {"rig": desk.rig.name, **always, "wrong": str(error)}
    return {
        "rig": config.name,
        **always,
        "file": str(desk.rig_file),
        "simulated": config.pressure.kind == "simulated",
        "reached": _reached(config),
        "chambers": [[c.name, c.min_kpa, c.max_kpa] for c in config.chambers],
        "markers": len(config.markers),
        "vent_command": desk.command(["rig", "vent", desk.rig_file]),
        "procedures": sorted(name for name, kind in shipped().items() if not kind.closed_loop),
        "files": (files := _files(desk)),
        "proposed": next((name for name in files if _is_for(desk.folder / name, config)), ""),
    }


def _reached(config: RigConfig) -> str:
    """The pressure controller as a person knows it: its kind and where it is."""
    device = config.pressure
    place = device.options.get("port"), device.options.get("host"), device.options.get("file")
    return " ".join([device.kind, *(str(part) for part in place if part is not None)])


def _files(desk: Desk) -> list[str]:
    """Procedure files of the folder: `labrig next` writes such."""
    found = [path for pattern in _PLACES for path in desk.folder.glob(pattern)]
    files = [path for path in found if not path.name.startswith(".") and _is_procedure(path)]
    files.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    return [desk.name(path) for path in files]


def _is_for(path: Path, config: RigConfig) -> bool:
    """Whether a rig has the chambers that a list of set-points names."""
    return chambers_of(path) <= {chamber.name for chamber in config.chambers}


def _is_procedure(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return path.name != "run.yaml" and any(
                line.startswith(b"procedure:") for line in file.read(4096).splitlines()
            )
    except OSError:
        return False


def _asked(desk: Desk, asked: dict[str, Any]) -> tuple[str, list[str], int]:
    """The procedure that a page names (one that labrig brings, or a file of the folder), its arguments, the seed."""
    name = str(asked.get("procedure") or "")
    if name not in shipped():
        name = desk.name(desk.existing(name))
    arguments = [str(word) for word in asked.get("arguments") or []]
    return name, arguments, seed_of(asked)


def _plan(desk: Desk, asked: dict[str, Any]) -> Any:
    """What a run would do, and what it was asked for: a start sends this back, and the plan's name with it."""
    config = rig_of(desk)
    name, arguments, seed = _asked(desk, asked)
    model = str(asked.get("model") or "")
    return {
        **plan_of(desk, name, arguments, seed),
        "diagnose": model if model and not _misfit(desk, config, desk.existing(model)) else "",
        "asked": {"procedure": name, "arguments": arguments, "seed": seed},
        "command": desk.command(["run", name, *arguments, *_seed(seed), "--rig", desk.rig_file, "--dry-run"]),
    }


def _seed(seed: int) -> list[str]:
    return ["--seed", str(seed)] if seed else []


def _start(desk: Desk, request: Request) -> Any:
    """Begin the run whose plan was shown, as a process of its own, which no page and no server holds."""
    if (no := refused(desk, request)) is not None:
        return no
    config, asked = rig_of(desk), body_of(request)
    name, arguments, seed = _asked(desk, asked)
    idle(desk)
    plan = plan_of(desk, name, arguments, seed)
    check_plan(plan, asked.get("plan"))
    out = new_run(desk, asked)
    words = ["run", name, *arguments, *_seed(seed), "--rig", str(desk.rig_file), "--out", desk.name(out)]
    words += ["--attended", *_followed(desk, config, asked)]
    if config.pressure.kind == "simulated" and asked.get("realtime", True):
        words.append("--realtime")
    job = desk.jobs.start(words, f"run {Path(name).stem}", desk.name(out))
    return says({"job": job.id, "run": desk.name(out), "command": job.command}, 202)


def _misfit(desk: Desk, config: RigConfig, model: Path) -> str:
    return misfit(model, names_of_rig(config), named(desk, model))


def _followed(desk: Desk, config: RigConfig, asked: dict[str, Any]) -> list[str]:
    """The words for a live diagnosis of the model that a page names, if it does, and for what ends the run."""
    if not asked.get("diagnose"):
        return []
    model = desk.existing(str(asked["diagnose"]))
    if other := _misfit(desk, config, model):
        raise LabrigError(f"nothing was moved: {other}")
    words = ["--diagnose", desk.name(model)]
    return [*words, "--until", "settled"] if asked.get("settled") else words


def _resume(desk: Desk, request: Request) -> Any:
    """Go on with a run that was ended before its plan was."""
    if (no := refused(desk, request)) is not None:
        return no
    run = run_folder(desk, str(body_of(request).get("run") or ""))
    idle(desk)
    name = desk.name(run)
    words = ["run", "--resume", name, "--rig", str(desk.rig_file), "--attended"]
    if read_run_yaml(run).get("procedure") == CHECK:  # which has a report to write
        words = resume_words(desk, name)
    job = desk.jobs.start(words, f"go on with {run.name}", name)
    return says({"job": job.id, "run": name, "command": job.command}, 202)


def _tell(desk: Desk, request: Request, what: str) -> Any:
    """Pause, go on, or end the run that a page names."""
    if what == "go_on" and (no := refused(desk, request)) is not None:
        return no
    name = str(body_of(request).get("run") or "")
    note = live_run(desk, name)
    if note is None:
        raise LabrigError(f"{name or 'no run'}: does not go on")
    return note.ask(what, why="the workbench")


def _now(desk: Desk, request: Request, errors: Errors) -> Any:
    given = query_of(request)
    name = given.get("run", "")
    state = now(desk, name, given.get("since_s", 0.0), given.get("event", 0))
    state["investigation"] = part_of(desk, Path(state["folder"]) if state["live"] else desk.path(name))
    if state["live"]:
        state["diagnosed"] = diagnosed_with(Path(state["folder"]))
    if state["live"] and given.get("model"):
        folder, model = Path(state["folder"]), desk.existing(given["model"])
        other = misfit(model, names_of(folder), named(desk, model))
        state["error"] = {"error": f"{other}; choose another model"} if other else errors.of(folder, model)
    # As it stands: `says` rounds to six digits, and moments have ten.
    return JSONResponse({**state, "colours": CHAMBER_COLOURS})


def _models(desk: Desk, name: str) -> Any:
    """The models that fit a run that goes on, of which the log may not be there yet; the first is the nearest."""
    note = live_run(desk, name)
    if note is None:
        raise LabrigError(f"{name or 'no run'}: does not go on")
    rig = desk.known_rig()
    names = None if rig is None else names_of_rig(rig)
    return {"models": [desk.name(path) for path in models_of(desk, Path(str(note.facts["folder"])), names)]}


def _skin(desk: Desk, request: Request) -> Any:
    name = request.query_params.get("run", "")
    note = live_run(desk, name)
    if note is None:
        raise LabrigError(f"{name or 'no run'}: does not go on")
    about = note.ask("status")
    if not about.get("rest_mm"):
        raise LabrigError("the rig does not say where its markers rest")
    return surface(about["rest_mm"])
