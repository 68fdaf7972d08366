"""What compare and diagnose found, and which runs it is about."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from labrig.catalogue._row import Row, finite


class Result(NamedTuple):
    """A compare.json or diagnosis.json in short; `runs` is what its runs are recognised by.

    `error` is that of the model as it stands: of a diagnosis, of its base.
    """

    path: str
    size: int
    written_ns: int
    runs: tuple[str, ...] = ()
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
        runs=tuple(_ids(content.get("runs"))),
        model=_text(content.get("model")),
        verdict=_text(verdict),
        error=finite(error.get("model" if verdict is None else "base")),
        floor=finite(error.get("floor")),
        units=_text(content.get("units")),
    )


def by_run(results: Iterable[Result]) -> dict[str, Result]:
    """The result that counts for each run."""
    best: dict[str, Result] = {}
    for result in results:
        for run in result.runs:
            if run not in best or result.rank > best[run].rank:
                best[run] = result
    return best


def with_result(row: Row, best: Mapping[str, Result]) -> Row:
    """A row with what its result says; nothing where there is none."""
    result = best.get(row.id, _NOTHING) if row.id else _NOTHING
    return row._replace(
        model=result.model,
        verdict=result.verdict,
        error=result.error,
        floor=result.floor,
        units=result.units,
        result=result.path,
    )


_NOTHING = Result("", 0, 0)


def _ids(runs: Any) -> Iterable[str]:
    for run in runs if isinstance(runs, list) else []:
        if isinstance(run, dict) and isinstance(run.get("id"), str) and run["id"]:
            yield run["id"]


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""
