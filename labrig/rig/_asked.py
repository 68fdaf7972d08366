"""The vent that somebody else asks a guard for: another process, on the vent page or with `labrig rig vent`."""

import hashlib
import json
import os
import re
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._running import Reception
from labrig.rig._config import RigConfig
from labrig.run_contents import Asking, Facts, VentContent

_ADDRESS = ("port", "host", "serial", "unit_id")
_DEFAULT = {"modbus": {"port": 502, "unit_id": 1}}
"""What an address is where a rig file does not say it."""
_UNITS = ("_s", "_hz", "_kpa", "_mm", "baudrate", "timeout")
"""What an option ends with that says how a controller is used, and not which one it is."""


@dataclass(eq=False)
class Asked:
    """One such request, among those of the runner: why, and where the answer goes."""

    why: str
    answer: "Future[VentContent]" = field(default_factory=Future)


def link_of(config: RigConfig) -> str:
    """A short name for what the pressure controller is reached through; empty for one simulated in a run's process.

    Two rig files that reach the same controller have the same link. A class of somebody's own may call its address
    what it likes: there every option counts that has no unit in its name.
    """
    device = config.pressure
    if device.kind == "simulated":
        return ""
    options = device.options
    if device.kind == "python":
        address = {name: value for name, value in options.items() if not name.endswith(_UNITS)}
        address["file"] = Path(str(options.get("file"))).name
    else:
        given = {name: options[name] for name in _ADDRESS if options.get(name) is not None}
        if "serial" in given:
            given.pop("port", None)  # of TCP
        default = {} if "serial" in given else _DEFAULT.get(device.kind, {})
        address = {name: _alike(value) for name, value in (default | given).items()}
    told = json.dumps([device.kind, address], sort_keys=True, default=str)
    return hashlib.sha256(told.encode()).hexdigest()[:20]


def _alike(value: Any) -> Any:
    """An address as it is, however it is written: what a link to a serial port points to, com10 for \\\\.\\COM10."""
    if not isinstance(value, str):
        return value
    if "/dev/" in value and "://" not in value:
        return os.path.realpath(value)
    name = value.lower().removeprefix("\\\\.\\")
    return re.sub(r"^((?:[a-z0-9]+://)?)localhost\b", r"\g<1>127.0.0.1", name)


def receive(config: RigConfig, log: Path | None, ask: Callable[[Asked], None]) -> Reception | None:
    """Let others ask this guard for a vent: it is handed to `ask`. None where nobody can be listened to."""

    def answer(request: Asking) -> VentContent:
        if request.get("do") != "vent":
            raise LabrigError("a guard is asked for a vent, and nothing else")
        asked = Asked(str(request.get("why") or "somebody who asked for a vent"))
        ask(asked)
        try:
            return asked.answer.result(config.safety.guard_patience_s)
        except FutureTimeoutError:
            raise LabrigError("the guard did not come to it") from None

    facts: Facts = {
        "link": link_of(config),
        "rig": config.name,
        "run": str(log.parent.resolve()) if log else "",
    }
    try:
        return Reception("guard", facts, answer)
    except OSError:
        return None
