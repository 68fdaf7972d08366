"""Files to which a long run adds a line as each piece of it is done, so that it goes on where it was stopped."""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from labrig._executor import Executor
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


def each_once(
    todo: Sequence[tuple[Any, ...]], path: Path, work: Callable[[Any], Any], jobs: int
) -> Iterator[Any]:
    """What `work` says of each task, `jobs` at a time, as a file keeps it: a line with the task and what was said, as
    it is done. What is in the file already is yielded first.
    """
    known = {tuple(task): said for task, said in read_lines(path)}
    yield from (known[task] for task in todo if task in known)
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # inherited by the workers: one core each
    left = [task for task in todo if task not in known]
    with Executor(jobs) as executor, adding_lines(path) as add:
        for k, said in executor.map(work, left):
            add([left[k], said])
            yield plain(said)


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
