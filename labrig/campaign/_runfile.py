"""run.yaml: what a run is, written before anything moves, and compared before a run is resumed."""

import getpass
import math
import platform
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypedDict

import yaml

from labrig import __version__
from labrig._durable import sync_folder, write_whole
from labrig._errors import LabrigError
from labrig._git import git_commit
from labrig.campaign._plan import Plan, plan_facts, sha256_of
from labrig.campaign._procedure import Procedure
from labrig.rig import Rig
from labrig_drivers import Identity

_NOT_THERE = object()
_NUMBERS = ("address", "version", "serial")
"""What devices say of themselves that does not change from one connection to the next."""


_ROLES = ("pressure", "mocap", "scanner")
_REACHED = ("port", "host", "serial", "unit_id", "baudrate", "parity", "folder", "mode", "formats")
"""How a device is reached, which may change from one session to the next, as waiting times may (`_s`, `_hz`)."""


class NotResumableError(LabrigError):
    """A run cannot be gone on with as things are now."""


class DeviceSaid(TypedDict):
    """What a device said of itself."""

    kind: str
    description: str
    details: dict[str, str]


def run_facts(
    procedure: Procedure, rig: Rig, seed: int, plan: Plan, context: dict[str, Any]
) -> dict[str, Any]:
    """The content of run.yaml; `context` is added as it is (file names, for the command line)."""
    facts = plan_facts(procedure, rig.config, seed, plan)
    return {
        "procedure": facts["procedure"],
        "parameters": facts["parameters"],
        "seed": seed,
        "plan_sha256": sha256_of(facts),
        "steps_sha256": facts["steps_sha256"],
        "closed_loop": procedure.closed_loop,
        "steps": len(plan.steps),
        "captures": plan.captures,
        "estimate_s": round(plan.duration_s, 3),
        "started": datetime.fromtimestamp(rig.clock.now_s(), UTC).isoformat(timespec="seconds"),
        "start_s": rig.clock.now_s(),
        "operator": _operator(),
        "rig": rig.config.to_dict(),
        "identity": {role: _said(identity) for role, identity in rig.identity.items()},
        "versions": {"labrig": __version__, "python": platform.python_version(), "system": platform.system()},
        "git_commit": git_commit(),
        **context,
    }


def _said(identity: Identity) -> DeviceSaid:
    return {
        "kind": identity.kind,
        "description": identity.description,
        "details": dict(identity.details),
    }


def _operator() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return ""


def write_run_yaml(folder: Path, facts: dict[str, Any]) -> None:
    """Write run.yaml, whole or not at all, and durably."""
    write_whole(folder / "run.yaml", yaml.safe_dump(facts, sort_keys=False, allow_unicode=True))
    sync_folder(folder.parent)


def check_resumable(folder: Path, old: dict[str, Any], new: dict[str, Any]) -> None:
    """Raise `LabrigError` naming the first thing that is not as it was when the run began."""
    for field, what in (("procedure", "procedure"), ("parameters", "parameters"), ("seed", "seed")):
        _same(folder, what, old.get(field), new[field])
    old_rig, new_rig = old.get("rig", {}), new["rig"]
    for field, what in (("name", "rig"), ("chambers", "limits of the chambers"), ("markers", "markers")):
        _same(folder, what, old_rig.get(field), new_rig.get(field))
    for role in _ROLES:
        _same(folder, f"{role} section of the rig", _means(old_rig.get(role)), _means(new_rig.get(role)))
    _same(folder, "simulated section of the rig", _hides(old_rig), _hides(new_rig))
    _same(folder, "devices", _who(old.get("identity") or {}), _who(new["identity"]))
    if old.get("steps_sha256") != new["steps_sha256"]:
        raise NotResumableError(
            f"cannot resume {folder}: procedure {new['procedure']} no longer makes the steps that it made when "
            "the run began; start a new run"
        )


def check_written(folder: Path, facts: dict[str, Any]) -> None:
    """Raise `NotResumableError` for a run.yaml that somebody changed: labrig itself writes numbers and fields."""
    path = folder / "run.yaml"
    if not isinstance(facts.get("seed", 0), int):
        raise NotResumableError(f"{path}: seed should be a whole number, not {facts['seed']!r}")
    for name in ("start_s", "steps"):
        value = facts.get(name, 0)
        if not isinstance(value, int | float) or not math.isfinite(value):
            raise NotResumableError(f"{path}: {name} should be a number, not {value!r}")
    identity = facts.get("identity") or {}
    for name, fields in (("rig", facts.get("rig", {})), ("identity", identity)):
        if not isinstance(fields, dict):
            raise NotResumableError(f"{path}: {name} should hold fields (name: value), not {fields!r}")
    for role, said in identity.items():
        if not isinstance(said, dict) or "kind" not in said:
            raise NotResumableError(
                f"{path}: identity: {role} should hold what the device said, not {said!r}"
            )


def _hides(rig: dict[str, Any]) -> dict[str, Any]:
    """What a rig that is simulated in the run's own process is made of; nothing where none of its devices is."""
    used = any((rig.get(role) or {}).get("kind") == "simulated" for role in _ROLES)
    return (rig.get("simulated") or {}) if used else {}


def _means(device: dict[str, Any] | None) -> dict[str, Any]:
    """What of a device's settings decides what its numbers mean: outputs, units, axes, names, and all that it reads."""
    return {
        name: value
        for name, value in (device or {}).items()
        if name not in _REACHED and not name.endswith(("_s", "_hz"))
    }


def _who(identity: dict[str, DeviceSaid]) -> dict[str, str]:
    """What of the devices must stay the same: their kinds and numbers, not the ports that they are found at."""
    known = {}
    for role, of_role in identity.items():
        details = of_role.get("details") or {}
        stated = [details[key] for key in _NUMBERS if details.get(key, "not stated") != "not stated"]
        known[role] = " ".join([of_role["kind"], *stated])
    return known


def _same(folder: Path, what: str, old: Any, new: Any) -> None:
    if old == new:
        return
    if isinstance(old, dict) and isinstance(new, dict):
        key = next(key for key in [*old, *new] if old.get(key, _NOT_THERE) != new.get(key, _NOT_THERE))
        was, now = (repr(each[key]) if key in each else "not there" for each in (old, new))
        detail = f"{key} was {was}, now it is {now}"
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pair = next((before, now) for before, now in zip(old, new, strict=True) if before != now)
        detail = f"{pair[0]!r} became {pair[1]!r}"
    else:
        detail = f"{old!r} became {new!r}"
    raise NotResumableError(f"cannot resume {folder}: the {what} changed ({detail}); start a new run")
