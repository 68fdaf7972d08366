"""What the tests of documentation pages share: a page's blocks, and doing what it says."""

import re
import shlex
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
Run = Callable[..., tuple[int, str, str]]


def blocks(page: str) -> Iterator[tuple[str, str]]:
    """Language and text of each fenced block of a page."""
    for found in re.finditer(
        r"^```(\w*)\n(.*?)^```$", (DOCS / page).read_text("utf-8"), re.MULTILINE | re.DOTALL
    ):
        yield found[1], found[2]


def follow(
    page: str, labrig: Run, monkeypatch: pytest.MonkeyPatch, done: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Do what a page says; returns what each command printed.

    A block whose first line is `# NAME` (with an ending) is a file; a block without a language holds commands; `text`
    blocks are output, or what the reader's own names stand in. Commands that are `done` have printed that already.
    """
    printed = {}
    for language, text in blocks(page):
        first, _, rest = text.partition("\n")
        if re.fullmatch(r"# [\w./-]+\.\w+", first):
            path = Path(first[2:])
            path.parent.mkdir(exist_ok=True)
            path.write_text(rest if path.suffix == ".csv" else text, encoding="utf-8")
        elif language == "":
            for line in text.splitlines():
                command = line.partition("#")[0].strip()
                words = shlex.split(command)
                if words[0] == "cd":
                    monkeypatch.chdir(words[1])
                    continue
                assert words[0] == "labrig", line
                if words[1] == "workbench":  # a page that stays open; tests/workbench opens it
                    continue
                if done and command in done:
                    printed[command] = done[command]
                    continue
                code, out, err = labrig(*words[1:])
                assert code == 0, (line, err)
                printed[command] = out
    return printed
