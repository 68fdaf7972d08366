"""What has to be true before a rig is moved from a page: the page may, the rig is free, somebody answers for it."""

from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from labrig._errors import LabrigError
from labrig.api._procedures import shipped
from labrig.rig import RigConfig, in_use, load_rig
from labrig.workbench._answers import says
from labrig.workbench._desk import Desk
from labrig.workbench._guarded import may_move_rig
from labrig.workbench._investigations import going_on
from labrig.workbench._live import alive
from labrig.workbench._plan import LONGEST_S, planned

MINE = "nothing was moved: say first that the rig is yours and nobody is near it"
_OTHER_PLAN = "nothing was moved: this is not the plan that was shown; show the plan, and start then"


def rig_of(desk: Desk) -> RigConfig:
    """The desk's rig as its file says now; raises `LabrigError` where there is none."""
    if desk.rig_file is None:
        raise LabrigError("no rig is connected; start the workbench with: labrig workbench --rig RIG.yaml")
    return load_rig(desk.rig_file)


def refused(desk: Desk, request: Request) -> Response | None:
    """The answer to a page that was not opened for the rig; None for the one that was."""
    if may_move_rig(request, desk.rig_token):
        return None
    return says({"error": "only the page that `labrig workbench --rig` opened moves the rig"}, 403)


def idle(desk: Desk, begins: str = "") -> None:
    """Raise `LabrigError`, with these words before it, where a run or an investigation has the rig."""
    if going := [*going_on(desk), *alive(desk)]:
        raise LabrigError(f"{begins}{going[0]} goes on; end it first")


def free_rig(desk: Desk, asked: dict[str, Any]) -> RigConfig:
    """The rig, which nobody uses now and somebody answers for (`mine`); raises `LabrigError` otherwise."""
    config = rig_of(desk)
    if asked.get("mine") is not True:
        raise LabrigError(MINE)
    idle(desk, "nothing was moved: ")
    with in_use(config, "the workbench, which only looks whether the rig is free"):
        return config


def plan_of(desk: Desk, name: str, arguments: list[str], seed: int) -> dict[str, Any]:
    """What a procedure (of labrig's, or a file of the folder) would do on the desk's rig, as `planned` says it.

    Raises `LabrigError` where there is no plan, and why.
    """
    source = name if name in shipped() else str(desk.existing(name))
    try:
        return desk.planner.ask_newest(LONGEST_S, planned, str(desk.rig_file), source, arguments, seed)
    except LabrigError as error:
        raise LabrigError(f"no plan: {error}") from None


def check_plan(plan: dict[str, Any], shown: Any) -> None:
    """Raise `LabrigError` for a plan that breaks a limit, or that is not the one that was `shown`, by its name."""
    if plan["broken"]:
        raise LabrigError(f"nothing was moved: {plan['broken'][0]}")
    if shown != plan["plan"]:
        raise LabrigError(_OTHER_PLAN)


def new_run(desk: Desk, asked: dict[str, Any]) -> Path:
    """The folder of a run that a page names and that is not there yet; raises `LabrigError` otherwise."""
    out = desk.path(str(asked.get("out") or ""))
    if out == desk.folder or out.exists():
        raise LabrigError(f"{asked.get('out') or 'a name'}: choose the name of a new run")
    return out
