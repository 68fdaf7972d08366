"""One run as a row of the catalogue."""

import math
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, NamedTuple

from labrig.log import run_id, summarise

Kind = Literal["text", "number", "texts"]

_LARGEST = 2**53


class Row(NamedTuple):
    """A run. What is not known is an empty text, or None for numbers; `started` is a text in UTC.

    `run` is its path below the folder that was listed. `model`, `error`, `floor` (in `units`) and `verdict` are what
    the file `result` says; `error` is that of the model as it stands.
    """

    run: str
    started: str = ""
    rig: str = ""
    operator: str = ""
    procedure: str = ""
    captures: int | None = None
    planned: int | None = None
    length_s: float | None = None
    size_mb: float | None = None
    state: str = ""
    warnings: int | None = None
    model: str = ""
    verdict: str = ""
    error: float | None = None
    floor: float | None = None
    units: str = ""
    result: str = ""
    tags: tuple[str, ...] = ()
    notes: str = ""
    ruled_out: str = ""
    id: str = ""


_NUMBERS = ("captures", "planned", "length_s", "size_mb", "warnings", "error", "floor")
COLUMNS: dict[str, Kind] = {
    name: "number" if name in _NUMBERS else "texts" if name == "tags" else "text" for name in Row._fields
}
"""What each column holds; all but `tags` are one value each."""


def read_row(folder: Path, name: str) -> Row:
    """The row of a run as its log has it; raises `LabrigError` or `OSError` where that can't be read."""
    summary = summarise(folder)
    run = summary.run
    rig = run.get("rig")
    return Row(
        run=name,
        started=_utc(run.get("started")),
        rig=_text(rig.get("name") if isinstance(rig, dict) else rig),
        operator=_text(run.get("operator")),
        procedure=_text(run.get("procedure")),
        captures=summary.captures,
        planned=None if run.get("closed_loop") else _count(run.get("captures")),
        length_s=finite(summary.duration_s),
        size_mb=summary.size_bytes / 1e6,
        state=summary.state,
        warnings=len(summary.warnings),
        id=run_id(folder),
    )


def unreadable(name: str, error: Exception) -> Row:
    """The row of a run that can't be read."""
    said = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return Row(run=name, state=f"unreadable: {said}")


def finite(value: Any) -> float | None:
    """A number that is one, else None."""
    known = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    return float(value) if known else None


def _count(value: Any) -> int | None:
    return value if type(value) is int and 0 < value < _LARGEST else None


def _text(value: Any) -> str:
    return value if isinstance(value, str) else "" if value is None else str(value)


def _utc(value: Any) -> str:
    """A moment of run.yaml as `2026-07-30 12:00:00`, in UTC, so that texts are in the order of time."""
    if isinstance(value, str):
        try:
            value = datetime.fromisoformat(value)
        except ValueError:
            return ""
    if not isinstance(value, datetime):
        return ""
    moment = value.astimezone(UTC) if value.tzinfo is not None else value
    return moment.replace(tzinfo=None, microsecond=0).isoformat(" ")
