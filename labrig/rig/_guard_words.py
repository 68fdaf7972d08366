"""What a runner asks its guard, and what the guard answers: a line of JSON each."""

import subprocess
import sys
from typing import Any, NotRequired, TypedDict


def apart() -> dict[str, Any]:
    """Options of a process that Ctrl-C and a closed terminal do not reach, on each system by its own means.

    On Windows a group of its own keeps Ctrl-C away, and a console of its own, which nobody sees, what is sent to all
    processes of a console window that is closed.
    """
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {"start_new_session": True}


class Setup(TypedDict):
    """The first line: the rig, where its file lies, the guard's own log, and the clock's offset.

    `armed`: the chambers may be under pressure already, as another guard may have left them.
    """

    id: int
    rig: dict[str, Any]
    folder: str
    log: str | None
    offset_s: float
    armed: bool


class GuardRequest(TypedDict):
    """What to do, and what that needs; `id` is the number of the request."""

    do: str
    id: NotRequired[int]
    pressure_kpa: NotRequired[list[float]]
    timeout_s: NotRequired[float]
    allow_s: NotRequired[float]


class GuardAnswer(TypedDict, total=False):
    """The value, or the kind of the error and what it says. Without an `id`, a sign that the guard is at work, or vents
    because somebody else asked for it.
    """

    id: int | None
    value: Any
    error: str
    message: str
    venting: bool


class Identified(TypedDict):
    """Who a device is."""

    name: str
    kind: str
    description: str
    details: dict[str, str]
