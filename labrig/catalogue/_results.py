"""What compare and diagnose found, and which runs it is about."""

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from labrig.catalogue._row import Row, finite


class Result(NamedTuple):
    """A compare.json or diagnosis.json in short; `runs` is what its runs are recognised by, how many captures each had
    (None: not said), and what was ruled out in it.

    `error` is that of the model as it stands: of a diagnosis, of its base.
    """

    path: str
    size: int
    written_ns: int
    runs: tuple[tuple[str, int | None, str], ...] = ()
    model: str = ""
    verdict: str = ""
    error: float | None = None
    floor: float | None = None
    units: str = ""

    @property
    def rank(self) -> tuple[bool, int, str]:
        """Which of several results of a run counts: the newest diagnosis; without one, the newest comparison."""
        return bool(self.verdict), self.written_ns, self.path


def read_result(path: Path, name: str, size: int, written_ns: int) -> Result:
    """A result file in short, without runs if it is not labrig's, or of one that did not say them.

    Raises `OSError` or `ValueError` if it can't be read.
    """
    content = json.loads(path.read_text(encoding="utf-8"))
    blank = Result(name, size, written_ns)
    if not isinstance(content, dict) or not isinstance(content.get("error"), dict):
        return blank
    error, verdict = content["error"], content.get("verdict")
    return blank._replace(
        runs=tuple(_runs(content.get("runs"))),
        model=_text(content.get("model")),
        verdict=_text(verdict),
        error=finite(error.get("model" if verdict is None else "base")),
        floor=finite(error.get("floor")),
        units=_text(content.get("units")),
    )


Known = Mapping[str, list[tuple[Result, int | None, str]]]
"""The results of each run, of how many captures of it, and with what ruled out, the one that counts most first."""


def by_run(results: Iterable[Result], rows: Iterable[Row]) -> Known:
    """The results of each run, but for those beside one of whose runs another rule-out stands by now."""
    said: dict[str, set[str]] = defaultdict(set)
    for row in rows:
        said[row.id].add(row.ruled_out)
    found: dict[str, list[tuple[Result, int | None, str]]] = defaultdict(list)
    for result in sorted(results, key=lambda each: each.rank, reverse=True):
        if all(then in said.get(run, {then}) for run, _, then in result.runs):
            for run, captures, then in result.runs:
                found[run].append((result, captures, then))
    return found


def with_result(row: Row, known: Known) -> Row:
    """A row with what its result says; nothing where there is none of all its captures, as they stand by now."""
    own = known.get(row.id, []) if row.id else []
    of_all = (
        result
        for result, captures, then in own
        if then == row.ruled_out and (captures is None or captures >= (row.captures or 0))
    )
    result = next(of_all, _NOTHING)
    return row._replace(
        model=result.model,
        verdict=result.verdict,
        error=result.error,
        floor=result.floor,
        units=result.units,
        result=result.path,
    )


_NOTHING = Result("", 0, 0)


def _runs(runs: Any) -> Iterable[tuple[str, int | None, str]]:
    for run in runs if isinstance(runs, list) else []:
        if isinstance(run, dict) and isinstance(run.get("id"), str) and run["id"]:
            captures, words = run.get("captures"), run.get("ruled_out")
            ruled_out = ", ".join(map(str, words)) if isinstance(words, list) else ""
            yield run["id"], captures if isinstance(captures, int) else None, ruled_out


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""
