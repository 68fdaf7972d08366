"""A rig set up by clicks: a form that becomes a new rig file. Nothing is opened and nothing moves."""

import re
from functools import lru_cache
from typing import Any

from starlette.routing import Route

from labrig._durable import write_new
from labrig._errors import LabrigError
from labrig.workbench._answers import answering, body_of
from labrig.workbench._desk import Desk
from labrig.workbench._rig_check import looked_at
from labrig.workbench._rig_fields import described
from labrig.workbench._rig_files import MAP, SHELL, begun_from, commands, files_like, rigs_of
from labrig.workbench._rig_form import content_of, fresh_form, text_of
from labrig_drivers import register_maps, serial_ports

_NAME = re.compile(r"[\w()+][\w.()+ -]*\.yaml")
_DEVICE = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)\.", re.IGNORECASE)
_LONGEST_NAME = 100


def routes(desk: Desk) -> list[Route]:
    """`/api/setup`: GET the form, what it offers and the rig files there are; POST `check`, `begin`, `save`."""
    posts = {"check": _check, "begin": _begin, "save": _save}
    return [
        Route("/api/setup", answering(lambda request: _setup(desk))),
        *(
            Route(
                f"/api/setup/{name}",
                answering(lambda request, work=work: work(desk, body_of(request))),
                methods=["POST"],
            )
            for name, work in posts.items()
        ),
    ]


def _setup(desk: Desk) -> Any:
    """Every field, the form before anything was typed, and what can be chosen on this computer and in this folder."""
    names = ("rig.yaml", *(f"rig-{k}.yaml" for k in range(2, 10_000)))
    return {
        "fields": described(),
        "form": fresh_form(),
        "file": next(name for name in names if not (desk.folder / name).exists()),
        "ports": serial_ports(),
        "maps": [*register_maps(), *files_like(desk, MAP)],
        "bodies": [
            *_brought(),
            *((f"shell:{name}", f"the shell {name}") for name in files_like(desk, SHELL)),
        ],
        "rigs": rigs_of(desk),
    }


@lru_cache(maxsize=1)
def _brought() -> tuple[tuple[str, str], ...]:
    """What labrig simulates without a file, and for how many chambers it is."""
    from labrig.physics import load_shell, shipped_shells

    shells = {name: len(load_shell(name).chamber_names) for name in shipped_shells()}
    return (
        ("surface:membrane", "membrane, computed quickly: 4 chambers"),
        ("surface:mannequin", "mannequin, computed quickly: 9 chambers"),
        ("", "mannequin, as in labrig demo: 9 chambers"),
        *((f"shell:{name}", f"shell {name}: {count} chambers") for name, count in shells.items()),
    )


def _check(desk: Desk, asked: dict[str, Any]) -> Any:
    """The rig file that a form will be, the first thing that is wrong with it, and what is wrong with its name."""
    text = text_of(content_of(_form(asked)))
    fault, remarks = looked_at(desk, text)
    try:
        name, wrong = _new_file(desk, str(asked.get("file") or "")), ""
    except LabrigError as error:
        name, wrong = "", str(error)
    return {
        "text": text,
        "fault": None if fault is None else fault._asdict(),
        "remarks": remarks,
        "file": name,
        "wrong_file": wrong,
    }


def _begin(desk: Desk, asked: dict[str, Any]) -> Any:
    return begun_from(desk, str(asked.get("file") or ""))


def _save(desk: Desk, asked: dict[str, Any]) -> Any:
    """Write the rig file, if it is a rig and the name is free."""
    text = text_of(content_of(_form(asked)))
    name = _new_file(desk, str(asked.get("file") or ""))
    fault, _ = looked_at(desk, text)
    if fault is not None:
        where = f"{fault.at}: " if fault.at else ""
        raise LabrigError(f"nothing was written: {where}{fault.says}")
    try:
        write_new(desk.folder / name, text)
    except FileExistsError:
        raise _is_there(name) from None
    return {"file": name, **commands(desk, name)}


def _form(asked: dict[str, Any]) -> dict[str, Any]:
    form = asked.get("form")
    if not isinstance(form, dict):
        raise LabrigError("the request brings no form of a rig")
    return form


def _new_file(desk: Desk, name: str) -> str:
    """The name of a file that can be made in the folder; raises `LabrigError` for others."""
    path = desk.path(name)
    if path.parent != desk.folder or not _NAME.fullmatch(name) or len(name) > _LONGEST_NAME:
        raise LabrigError(f"{name or 'the file'}: give the rig file a plain name that ends in .yaml")
    if _DEVICE.match(name):
        raise LabrigError(f"{name}: Windows takes this name for a device; choose another name")
    if path.exists():
        raise _is_there(name)
    return name


def _is_there(name: str) -> LabrigError:
    return LabrigError(f"{name}: exists already; choose another name")
