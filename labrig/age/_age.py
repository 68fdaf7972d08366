"""A rig's history: what each of its runs says, and what has changed by more than chance."""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from labrig._errors import LabrigError
from labrig.age._change import Change, Series, changes
from labrig.age._known import Known, is_fitted
from labrig.age._read import RunReadings, model_key, read_run
from labrig.age._reading import GROUPS, LOGARITHMIC, SHOWN, Reading
from labrig.age._words import change_words
from labrig.contents import HistoryChange, HistoryContent, LeftOut, Quantity

if TYPE_CHECKING:
    from labrig.catalogue import Row
    from labrig.model import Model

ALPHA = 0.05
"""The chance of a single false change in a rig's whole history, over all quantities and however often one looks.

It holds for scatter that is normal and independent from run to run; of other scatter see `labrig.age._wander`.
"""
_DAY_S = 86400.0
_LAST = 3
_FEWEST_CAPTURES = 8
_FEWEST_OF_A_FAILURE = 3
"""A run that ended early and has fewer captures than this says nothing of a rig's age."""
Progress = Callable[[int, int], None]


def rows_of_rig(folder: Path, rig: str, where: str | None = None) -> "list[Row]":
    """The runs of a rig below a folder that have captures, in order of time; raises `LabrigError` if there are none."""
    from labrig.catalogue import list_runs

    listed = list_runs(folder, where)
    rows = [row for row in listed if row.rig == rig and row.captures and row.id]
    if not rows:
        others = sorted({row.rig for row in listed if row.rig})
        known = f" (it has runs of {', '.join(others)})" if others else ""
        raise LabrigError(
            f"{folder} holds no runs of the rig {rig!r}{known}; name the folder that does (--runs FOLDER)"
        )
    return sorted(rows, key=lambda row: (row.started, row.run))


def read_rows(
    folder: Path, rows: "Sequence[Row]", model: "Model", progress: Progress | None = None
) -> tuple[list[RunReadings], list[LeftOut]]:
    """The readings of runs in order of time, and which were left out and why."""
    known, key = prepared(folder, rows, model)
    read: list[RunReadings] = []
    left_out: list[LeftOut] = []
    for number, row in enumerate(rows):
        if progress is not None:
            progress(number, len(rows))
        if why := _says_nothing(row):
            left_out.append({"run": row.run, "why": why})
            continue
        try:
            read.append(read_run(folder / row.run, row.run, known, key))
        except (LabrigError, OSError) as error:
            left_out.append({"run": row.run, "why": str(error)})
    return sorted(read, key=lambda each: (each.time_s, each.run)), left_out


def _says_nothing(row: "Row") -> str:
    """Why a run is no part of a history: it failed before it measured much. Empty where it is one."""
    count = row.captures or 0
    if row.state == "completed" or row.procedure == "import" or count >= _FEWEST_OF_A_FAILURE:
        return ""
    return f"it ended early, after {count} capture{'s' if count != 1 else ''}"


def prepared(folder: Path, rows: "Sequence[Row]", model: "Model") -> tuple[Known, str]:
    """The model for the runs of a rig, and what their readings are kept under.

    A base that is fitted to runs is fitted to the earliest that has enough captures, so that later ones can differ.
    """
    if not is_fitted(model):
        return Known(model), model_key(model)
    from labrig.effects import rows_of
    from labrig.log import open_run

    first = reference(rows)
    return Known(model, rows_of(open_run(folder / first.run))), model_key(model, first.id)


def reference(rows: "Sequence[Row]") -> "Row":
    """The earliest run with enough captures; else that with most."""
    large = [row for row in rows if (row.captures or 0) >= _FEWEST_CAPTURES]
    return large[0] if large else max(rows, key=lambda row: row.captures or 0)


def fitted_until(model: "Model") -> datetime | None:
    """When the last run was recorded that the model was fitted to; else when its file was written; else None."""
    if (noted := model.file.fitted_until) is not None:
        return noted if noted.tzinfo else noted.replace(tzinfo=UTC)
    if model.path is None or not model.path.is_file():
        return None
    return datetime.fromtimestamp(model.path.stat().st_mtime, UTC)


def summary_of(
    rig: str,
    model: "Model",
    runs: Sequence[RunReadings],
    left_out: Sequence[LeftOut] = (),
) -> HistoryContent:
    """The content of history.json: runs, every quantity over them, and its changes."""
    fitted = fitted_until(model)
    fitted_s = None if fitted is None else fitted.timestamp()
    quantities = _quantities(runs)
    tested = [quantity for quantity in quantities if quantity["group"] not in SHOWN]
    limit = ALPHA / max(len(tested), 1)
    markers = sum(quantity["group"] == "marker" for quantity in quantities)
    found: list[HistoryChange] = []
    unconfirmed: list[str] = []
    for quantity in tested:
        series = _series(quantity, runs)
        result = changes(series, limit)
        found += [
            cast("HistoryChange", {**each, "words": change_words(each, markers)})
            for each in _described(quantity, series, result.changes, runs, fitted_s)
        ]
        if result.unconfirmed and quantity["runs"][-1] == len(runs) - 1:
            unconfirmed.append(f"{quantity['group']} {quantity['name']}")
    found.sort(key=lambda each: (each["noticed"], each["begins"]))
    return {
        "rig": rig,
        "model": None if model.path is None else model.path.as_posix(),
        "fitted_until": None if fitted is None else fitted.isoformat(sep=" ", timespec="minutes")[:16],
        "alpha": ALPHA,
        "runs": [{"run": r.run, "date": r.date, "procedure": r.procedure, "kind": r.kind} for r in runs],
        "quantities": quantities,
        "changes": found,
        "unconfirmed": unconfirmed,
        "left_out": list(left_out),
    }


def _quantities(runs: Sequence[RunReadings]) -> list[Quantity]:
    """Each reading over the runs that have it, in the order of the groups."""
    by_key: dict[tuple[str, str], list[tuple[int, Reading]]] = {}
    for number, run in enumerate(runs):
        for each in run.readings:
            by_key.setdefault(each.key, []).append((number, each))
    order = {group: place for place, group in enumerate(GROUPS)}
    return [
        {
            "group": group,
            "name": name,
            "unit": each[0][1].unit,
            "runs": [number for number, _ in each],
            "value": [list(reading.value) for _, reading in each],
            "sd": [reading.sd for _, reading in each],
        }
        for (group, name), each in sorted(by_key.items(), key=lambda item: order[item[0][0]])
    ]


def _series(quantity: Quantity, runs: Sequence[RunReadings]) -> Series:
    """A quantity as it is tested: positive ones that scatter in proportion to themselves as logarithms."""
    value = np.array(quantity["value"], float)
    sd = np.array([np.nan if each is None else each for each in quantity["sd"]], float)
    if quantity["group"] in LOGARITHMIC:
        floor = 1e-12 + 1e-6 * float(np.abs(value).max())
        value, sd = np.log(np.maximum(value, floor)), sd / np.maximum(value[:, 0], floor)
    own = [runs[number] for number in quantity["runs"]]
    day = np.array([run.time_s for run in own]) / _DAY_S
    return Series(day, value, sd, np.array([run.kind for run in own]))


def _described(
    quantity: Quantity,
    series: Series,
    found: Sequence[Change],
    runs: Sequence[RunReadings],
    fitted_s: float | None,
) -> list[HistoryChange]:
    """Changes as plain values, with what the quantity was before and is after, in its own unit."""
    own, value = quantity["runs"], np.array(quantity["value"], float)
    edges = [0, *(change.begins for change in found), len(own)]
    out: list[HistoryChange] = []
    for number, change in enumerate(found):
        kind = series.kind[change.noticed]
        before = _level(
            value, series.kind == kind, edges[number], change.begins, change.shape == "slope" and number > 0
        )
        after = _level(value, series.kind == kind, change.begins, edges[number + 2], change.shape == "slope")
        each: HistoryChange = {
            "group": quantity["group"],
            "name": quantity["name"],
            "unit": quantity["unit"],
            "shape": change.shape,
            "begins": own[change.begins],
            "date": runs[own[change.begins]].date,
            "earliest": runs[own[max(change.first - 1, 0)]].date,
            "latest": runs[own[change.last]].date,
            "noticed": own[change.noticed],
            "noticed_date": runs[own[change.noticed]].date,
            "before": before,
            "after": after,
            "amount": change.amount.tolist(),
            "sd": change.sd,
            "odds": change.odds,
            "words": "",
            "since_fit": fitted_s is None or runs[own[change.begins]].time_s > fitted_s,
        }
        out.append(each)
    return out


def _level(value: np.ndarray, kind: np.ndarray, begin: int, end: int, newest: bool) -> list[float]:
    """The mean of a stretch of runs of one kind (of all where there is none of it); of the `newest` few only."""
    inside = np.zeros(len(value), dtype=bool)
    inside[begin:end] = True
    chosen = np.flatnonzero(inside & kind)
    chosen = chosen if len(chosen) else np.flatnonzero(inside)
    return np.asarray(value[chosen[-_LAST:] if newest else chosen].mean(axis=0)).tolist()
