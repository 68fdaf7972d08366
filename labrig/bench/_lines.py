"""Files to which a long run adds a line as each piece of it is done, so that it goes on where it was stopped."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from labrig._json import plain


def read_lines(path: Path) -> list[Any]:
    """What was added to a file, a line each; none if there is no file. A line that was cut off is left out."""
    found = []
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        try:
            found.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return found


@contextmanager
def adding_lines(path: Path) -> Iterator[Callable[[Any], None]]:
    """What adds a line to a file, and has it written when it comes back; behind a line that was cut off it begins a
    new one.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+", encoding="utf-8") as file:
        if file.tell():
            file.seek(0)
            if not file.read().endswith("\n"):
                file.write("\n")

        def add(record: Any) -> None:
            file.write(json.dumps(plain(record)) + "\n")
            file.flush()

        yield add
