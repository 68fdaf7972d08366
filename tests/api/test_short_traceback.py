"""An error in a notebook is where in one's own code, and one line; the rest is there for who asks."""

import contextlib
import io
import re
from collections.abc import Callable
from pathlib import Path

import pytest

HEAD = "Traceback (most recent call last; your own code only, all of it: traceback.print_last())"


@pytest.fixture
def cell(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[str], list[str]]:
    """Run a cell as IPython does, and what it prints, in lines."""
    from IPython.core.interactiveshell import InteractiveShell

    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.chdir(tmp_path)
    shell = InteractiveShell()
    shell.colors = "nocolor"
    shell.history_manager.enabled = False

    def run(text: str) -> list[str]:
        with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(out):
            shell.run_cell(text)
        return out.getvalue().rstrip("\n").split("\n")

    return run


def test_an_error_shows_the_readers_own_code(cell: Callable[[str], list[str]]) -> None:
    """The cell and the function in it, and what is wrong: no line of labrig or of a library."""
    cell("import labrig\ndef found(run):\n    return labrig.compare(run, 'model.yaml')")
    said = cell("found('nowhere')")
    assert said[0] == HEAD
    assert [line.strip() for line in said if not line.startswith("  File")][1:] == [
        "found('nowhere')",
        "return labrig.compare(run, 'model.yaml')",
        "labrig.LabrigError: nowhere does not exist; name a run folder or an .mcap file",
    ]
    assert [re.search(r"line (\d+), in", line)[1] for line in said if line.startswith("  File")] == ["1", "3"]  # type: ignore[index]


def test_all_of_it_is_there_for_who_asks(cell: Callable[[str], list[str]]) -> None:
    """What the first line names prints labrig's own calls, too."""
    cell("import labrig")
    cell("labrig.compare('nowhere', 'model.yaml')")
    whole = cell("import traceback; traceback.print_last()")
    assert any("labrig/api/_compare.py" in line.replace("\\", "/") for line in whole)


def test_what_failed_in_ones_own_function_is_shown(cell: Callable[[str], list[str]]) -> None:
    """An error in a function that labrig calls comes with its own line in it, before labrig's message."""
    cell("import labrig, pandas\ntable = pandas.DataFrame({'p_kPa': range(9), 'x_mm': range(9)})")
    cell("run = labrig.import_table(table, 'mine')")
    cell("def predict(actuation):\n    return actuation + 'mm'")
    said = cell("labrig.compare(run, predict)")
    assert said.count(HEAD) == 2
    assert "    return actuation + 'mm'" in said[: said.index(HEAD, 1)]
    assert said[-1].startswith("labrig.LabrigError: ")
    assert not any("site-packages" in line or "labrig/api" in line for line in said)


def test_a_device_that_fails_too(cell: Callable[[str], list[str]]) -> None:
    """A device's error is shown so as well; an error in labrig itself keeps its whole traceback."""
    cell("from labrig_drivers import DeviceError\ndef measure():\n    raise DeviceError('vicon: no frames')")
    assert cell("measure()")[0] == HEAD
    assert cell("measure()")[-1] == "labrig_drivers.DeviceError: vicon: no frames"
    assert HEAD not in cell("raise KeyError('x')")


def test_what_was_being_looked_after_is_shown(cell: Callable[[str], list[str]]) -> None:
    """An error of one's own, during which labrig was called, comes first."""
    cell("import labrig")
    said = cell("try:\n    1 / 0\nexcept ZeroDivisionError:\n    labrig.compare('nowhere', 'model.yaml')")
    assert "ZeroDivisionError: division by zero" in said
    assert said[-1].startswith("labrig.LabrigError: nowhere")
