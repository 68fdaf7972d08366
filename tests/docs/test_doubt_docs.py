"""docs/how-to/settle-a-doubt.md begins with a rig that anybody can make."""

import re
import runpy
from pathlib import Path

import pytest

from tests.pages import Run, blocks

PAGE = "how-to/settle-a-doubt.md"


def test_the_pages_rig_leaves_the_pages_doubt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, labrig: Run
) -> None:
    """The page's files make the rig, and its first commands come to the verdict and the names that it shows."""
    monkeypatch.chdir(tmp_path)
    for _, text in blocks(PAGE):
        if named := re.match(r"# (rig\.yaml|model\.yaml|hide\.py|on_off\.yaml)\n", text):
            Path(named[1]).write_text(text, encoding="utf-8")
    runpy.run_path("hide.py")
    commands = next(text for language, text in blocks(PAGE) if not language).splitlines()
    assert [command.split()[1] for command in commands] == ["run", "diagnose"]
    said = [labrig(*command.split()[1:]) for command in commands]
    assert [code for code, _, _ in said] == [0, 0]
    shown = next(text for language, text in blocks(PAGE) if language == "text")
    printed = " ".join(said[1][1].split())
    assert printed.startswith(shown.splitlines()[0])
    assert _possible(printed) == _possible(" ".join(shown.split()))


def _possible(text: str) -> set[str]:
    """The effects that a diagnosis calls possible."""
    return set(re.findall(r"(\w+) \(\d+ %\)", text.partition("possible: ")[2].partition(";")[0]))
