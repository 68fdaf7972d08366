"""How to call this labrig again from where one stands: its name alone only where the shell would find it by that."""

import shlex
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

_WINDOWS = sys.platform == "win32"


def call(*words: object) -> str:
    """A command of labrig as it can be typed here."""
    return _line([*_program(), *map(str, words)])


def named(*words: object) -> str:
    """A command of labrig by its name alone, as it was typed before."""
    return _line(["labrig", *map(str, words)])


def activation() -> str:
    """What makes `labrig` alone work: the line that activates its environment; empty where it works already."""
    script = _scripts() / "activate"
    if _is_found() or sys.prefix == sys.base_prefix or not script.exists():
        return ""
    path = str(_from_here(script))
    return subprocess.list2cmdline([path]) if _WINDOWS else f". {shlex.quote(path)}"


def _line(parts: list[str]) -> str:
    return subprocess.list2cmdline(parts) if _WINDOWS else shlex.join(parts)


def _program() -> list[str]:
    if _is_found():
        return ["labrig"]
    script = _scripts() / ("labrig.exe" if _WINDOWS else "labrig")
    return [str(_from_here(script))] if script.exists() else [sys.executable, "-m", "labrig"]


def _is_found() -> bool:
    """Whether the shell finds this environment's labrig by its name."""
    found = shutil.which("labrig")
    return found is not None and Path(found).parent.resolve() == _scripts().resolve()


def _scripts() -> Path:
    return Path(sysconfig.get_path("scripts"))


def _from_here(path: Path) -> Path:
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path
