"""Shape: the pressures that bring a surface nearest to a target: what there is to choose, the search, what it found."""

from pathlib import Path
from typing import Any

from starlette.responses import Response
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig._extras import lacking
from labrig.workbench._answers import answering, body_of, says
from labrig.workbench._desk import Desk
from labrig.workbench._rig_files import is_simulated_file
from labrig.workbench._shape_check import check_routes, checks_of
from labrig.workbench._shape_files import (
    chosen,
    models_of_shapes,
    rigs_of_shapes,
    taken,
    targets_of,
    typed,
)
from labrig.workbench._shape_found import FOLDER, FOUND, found_in, going_on, new_name, solved_in, standing
from labrig.workbench._shape_work import limits_of, picture_of
from labrig.workbench._uploads import taking

UNITS = ("mm", "cm", "m", "inch")
_TASK = "reading a target, and placing it beside the surface,"
_TRAINING = "training a model"


def routes(desk: Desk) -> list[Route]:
    """`/api/shape` and below it: what can be chosen, `limits`, `found` and its `picture`; POST `target`, `simulator`,
    `find`; the check against scans.
    """
    gets = {
        "": lambda request: _offer(desk),
        "/limits": lambda request: _limits(desk, request.query_params),
        "/found": lambda request: standing(desk, request.query_params.get("name", "")),
        "/picture": lambda request: _picture(desk, request.query_params.get("name", "")),
    }
    posts = {
        "/find": lambda request: _find(desk, body_of(request)),
        "/simulator": lambda request: _simulator(desk, str(body_of(request).get("rig") or "")),
    }
    return [
        Route("/api/shape/target", taking(desk, taken), methods=["POST"]),
        *(Route(f"/api/shape{name}", answering(work)) for name, work in gets.items()),
        *(Route(f"/api/shape{name}", answering(work), methods=["POST"]) for name, work in posts.items()),
        *check_routes(desk),
    ]


def _offer(desk: Desk) -> Any:
    """What can be chosen, what is not installed, and what was found and checked before."""
    models, rigs = models_of_shapes(desk), rigs_of_shapes(desk)
    simulated = [rig for rig in rigs if is_simulated_file(desk.folder / rig)]
    names = [model["name"] for model in models]
    return {
        "targets": targets_of(desk),
        "models": models,
        "rigs": rigs,
        "rig": rigs[0] if desk.rig_file is not None else "",
        "simulators": [rig for rig in simulated if _simulator_name(rig) not in names],
        "units": UNITS,
        "folder": FOLDER,
        "lacks": str(lacking("open3d", _TASK, "scan") or ""),
        "lacks_training": str(lacking("torch", _TRAINING, "learn") or ""),
        "found": solved_in(desk),
        "checks": checks_of(desk),
    }


def _limits(desk: Desk, asked: Any) -> Any:
    """The chambers of a model with the limits that a search would keep to, kPa; the name of a new folder for it."""
    model, rig = _model(desk, asked), _rig(desk, asked)
    out = new_name(desk, Path(str(asked.get("target") or "shape")).stem)
    try:
        return {**desk.worker.ask(limits_of, str(model), str(rig) if rig else ""), "out": out}
    except LabrigError as error:
        raise LabrigError(str(error).replace(f"{desk.folder}/", "")) from None


def _find(desk: Desk, asked: dict[str, Any]) -> Any:
    """Begin the search, as a labrig command of its own."""
    if (error := lacking("open3d", _TASK, "scan")) is not None:
        raise error
    target, unit = chosen(desk, asked.get("target"), targets_of(desk), "a target"), _unit(asked)
    model, rig = _model(desk, asked), _rig(desk, asked)
    out = desk.path(str(asked.get("out") or ""))
    if out == desk.folder or out.exists() or desk.name(out) in going_on(desk):
        raise LabrigError(f"{asked.get('out') or 'a name'}: choose the name of a new folder")
    words = ["ik", typed(desk, target), "--model", typed(desk, model)]
    words += ["--rig", typed(desk, rig)] if rig is not None else []
    words += ["--unit", unit] if unit else []
    words += ["--out", desk.name(out)]
    job = desk.jobs.start(words, f"pressures for {target.name}")
    return says({"job": job.id, "name": desk.name(out), "command": job.command}, 202)


def _picture(desk: Desk, name: str) -> Response:
    """The target beside the surface that was found for it."""
    content = found_in(desk, name)
    if content is None or "error" in content["targets"][0]:
        raise LabrigError(f"{name or 'no folder'}: holds no pressures for a shape ({FOUND})")
    model = (desk.folder / content["model"]).resolve()
    text = desk.worker.ask(picture_of, content["targets"][0], str(model), str(desk.folder))
    return Response(text, media_type="application/json")


def _simulator(desk: Desk, rig: str) -> Any:
    """Make the model file of a rig's own simulator, for who has trained no model."""
    from labrig.model import ModelFile, write_model_file

    path = chosen(desk, rig, rigs_of_shapes(desk), "a rig")
    if not is_simulated_file(path):
        raise LabrigError(f"{rig}: says nothing that could be simulated (simulated: ...)")
    model = desk.folder / _simulator_name(rig)
    if model.exists():
        raise LabrigError(f"{model.name}: exists already; choose it as the model")
    write_model_file(ModelFile.model_validate({"base": {"kind": "simulator", "rig": rig}}), model)
    return {"model": model.name}


def _simulator_name(rig: str) -> str:
    return f"{Path(rig).stem}-simulator.yaml"


def _model(desk: Desk, asked: Any) -> Path:
    offered = models_of_shapes(desk)
    name = asked.get("model")
    why = next((each["why"] for each in offered if each["name"] == name), "")
    if why:
        raise LabrigError(f"{why}; choose another model")
    return chosen(desk, name, [each["name"] for each in offered], "a model")


def _rig(desk: Desk, asked: Any) -> Path | None:
    """The rig whose limits hold; None where they are the model's own."""
    name = asked.get("rig")
    return chosen(desk, name, rigs_of_shapes(desk), "a rig") if name else None


def _unit(asked: Any) -> str:
    unit = str(asked.get("unit") or "")
    if unit and unit not in UNITS:
        raise LabrigError(f"unit {unit!r}: choose one of {', '.join(UNITS)}")
    return unit
