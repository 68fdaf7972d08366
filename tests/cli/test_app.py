"""The first things that a person types: nothing, --version, a wrong word, --debug."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from labrig import __version__

Run = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize("words", [(), ("rig",), ("bench",), ("train",)])
def test_without_a_command_the_help_is_shown(labrig: Run, words: tuple[str, ...]) -> None:
    """A group without a command prints its help as --help does, and is no success."""
    code, out, err = labrig(*words)
    assert (code, err) == (2, "")
    assert out == labrig(*words, "--help")[1]
    assert len(out.splitlines()) > 8


@pytest.mark.parametrize("words", [(), ("rig",), ("bench",), ("train",), ("effects",)])
def test_no_help_is_cut(labrig: Run, words: tuple[str, ...]) -> None:
    """The lists of commands hold whole sentences."""
    out = labrig(*words, "--help")[1]
    assert "Commands:" in out
    assert "..." not in out.partition("Commands:")[2]


def test_the_version(labrig: Run) -> None:
    """--version prints it."""
    assert labrig("--version") == (0, f"labrig {__version__}\n", "")


def test_it_is_a_module(tmp_path: Path) -> None:
    """`python -m labrig` is the command line, under the same name."""
    command = [sys.executable, "-m", "labrig", "show"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=180, check=False)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert ran.stderr == "labrig: Missing argument 'RUN'. (see labrig show --help)\n"


def test_a_wrong_word_is_answered_with_the_near_one(labrig: Run) -> None:
    """A misspelt command names the one that was meant, and where the help is."""
    code, _, err = labrig("compair")
    assert (code, err) == (
        2,
        "labrig: No such command 'compair'. Did you mean 'compare'? (see labrig --help)\n",
    )


@pytest.mark.parametrize("words", [("--debug", "show", "none"), ("show", "none", "--debug")])
def test_debug_stands_before_or_behind_the_command(labrig: Run, words: tuple[str, ...]) -> None:
    """--debug shows the traceback, the line below it and the exit code stay the same; the next command is quiet."""
    line = "labrig: none does not exist; name a run folder or an .mcap file"
    code, _, err = labrig(*words)
    assert code == 2
    assert err.startswith("Traceback (most recent call last):\n")
    assert err.splitlines()[-1] == line
    assert labrig("show", "none") == (2, "", f"{line}\n")


def test_an_interrupted_command_says_so(labrig: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """After Ctrl-C one line says that nothing failed, and the exit code is the shell's."""

    def interrupt(*arguments: object, **settings: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("labrig.diagnose", interrupt)
    assert labrig("diagnose", "run", "--model", "model.yaml") == (130, "", "labrig: interrupted\n")
