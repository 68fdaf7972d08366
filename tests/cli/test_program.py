"""The commands that labrig suggests work as they stand, whether or not its environment is active."""

import shutil
import sys
from pathlib import Path

import pytest

from labrig.cli import _program
from labrig.cli._program import activation, call


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An environment's folder of programs below the current folder, not on the path."""
    scripts = tmp_path / ".venv" / "bin"
    scripts.mkdir(parents=True)
    for name in ("labrig", "labrig.exe", "activate"):
        (scripts / name).write_text("")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(_program.sysconfig, "get_path", lambda name: str(scripts))
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / ".venv"))
    return scripts


@pytest.mark.parametrize(
    ("windows", "command", "line"),
    [
        (False, f"{Path('.venv/bin/labrig')} view 'my demo'", f". {Path('.venv/bin/activate')}"),
        (True, f'{Path(".venv/bin/labrig.exe")} view "my demo"', str(Path(".venv/bin/activate"))),
    ],
)
def test_an_environment_that_is_not_active(
    environment: Path, monkeypatch: pytest.MonkeyPatch, windows: bool, command: str, line: str
) -> None:
    """The program is named by its path from here, names with spaces are quoted, and the line that activates is said."""
    monkeypatch.setattr(_program, "_WINDOWS", windows)
    assert call("view", Path("my demo")) == command
    assert activation() == line


def test_an_environment_that_is_active(environment: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the shell finds labrig by its name, the name is enough, and nothing is said of activating."""
    monkeypatch.setattr(shutil, "which", lambda name: str(environment / name))
    assert call("show", "run") == "labrig show run"
    assert activation() == ""


def test_another_labrig_on_the_path(environment: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A labrig of another environment is not taken for this one; without any program the module is called."""
    monkeypatch.setattr(shutil, "which", lambda name: "/usr/bin/labrig")
    (environment / "labrig").unlink()
    (environment / "labrig.exe").unlink()
    monkeypatch.setattr(sys, "executable", "python3")
    assert call("show", "run") == "python3 -m labrig show run"
