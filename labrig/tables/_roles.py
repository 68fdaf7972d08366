"""What each column of a foreign table is likely to be: a time, a label, an input, a marker, an output."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._names import Name, take_apart
from labrig.tables._pairs import Clock
from labrig.tables._table import NOTHING, Table
from labrig.tables._time import are_dates, find_clock, may_be_clock

_PRESSURES = ("Pa", "psi", "bar", "mmHg")
_GENERIC = {("data",), ("value",), ("values",)}
_DRIVES = ("V", "A", "percent")


@dataclass
class Roles:
    """The columns of a table by what they are taken for; `time` with its units; `remarks` say what was assumed."""

    time: Clock | None = None
    capture: Name | None = None
    session: Name | None = None
    repeat: Name | None = None
    hold: Name | None = None
    actuation: list[Name] = field(default_factory=list)
    measured: list[tuple[Name, Name]] = field(default_factory=list)
    markers: dict[str, dict[str, Name]] = field(default_factory=dict)
    observables: list[Name] = field(default_factory=list)
    covariates: list[Name] = field(default_factory=list)
    values: dict[str, Floats] = field(default_factory=dict, repr=False)
    remarks: list[str] = field(default_factory=list)


def roles_of(table: Table, units: dict[str, str], part: str = "") -> Roles:
    """Take every column of a table for something; `units` are those that a row below the header gives.

    A column that is called `data` has the name of its `part`, the topic or group.
    """
    out = Roles()
    parsed: list[Name] = []
    dated: list[Any] = []
    for column in table.frame.columns:
        name = take_apart(column, units.get(str(column)))
        if part.strip("/") and name.words in _GENERIC:
            name = replace(take_apart(part.strip("/").rpartition("/")[2]), column=str(column))
        numbers = _numbers(table, column)
        if numbers is not None and np.isfinite(numbers).any():
            out.values[name.column] = numbers
            parsed.append(name)
        elif numbers is None and may_be_clock(name) and are_dates(table, column):
            dated.append(column)
        elif numbers is None and name.has(names.SESSION) and out.session is None:
            out.session = name
        elif numbers is None and (name.has(names.CAPTURE) or name.has(names.REPEAT)):
            if out.capture is None and name.has(names.CAPTURE):
                out.capture = name
            elif out.repeat is None:
                out.repeat = name
        else:
            what = "holds no numbers" if numbers is None else "is empty"
            out.remarks.append(f"column {name.column!r} {what} and is left out")
    out.time = find_clock(table, dated, parsed, out.values, out.remarks)
    rest = [n for n in parsed if out.time is None or n.column not in out.time.columns]
    rest = _find_labels(out, rest)
    rest = _find_markers(out, rest)
    _find_inputs(out, rest)
    return out


def _numbers(table: Table, column: Any) -> Floats | None:
    import pandas as pd

    values = table.frame[column]
    if values.dtype.kind in "fiub":
        return np.asarray(values, dtype=float)
    if values.dtype.kind in "Mm":
        return None
    text = values.dropna().astype(str).str.strip()
    if table.decimal != ".":
        text = text.str.replace(table.decimal, ".", regex=False)
    text = text[~text.str.casefold().isin(NOTHING)]
    if (
        len(text)
        and np.isnan(np.asarray(pd.to_numeric(text.head(1000), errors="coerce"), float)).mean() > 0.02
    ):
        return None
    every = values.astype(str).str.strip().str.replace(table.decimal, ".", regex=False)
    return np.asarray(pd.to_numeric(every, errors="coerce"), dtype=float)


def _find_labels(out: Roles, rest: list[Name]) -> list[Name]:
    """Take out what numbers captures, sessions and repeats, and the time within a hold."""
    kept = []
    for n in rest:
        values = out.values[n.column]
        whole = bool(np.all(values[np.isfinite(values)] == np.round(values[np.isfinite(values)])))
        blocks = int((np.diff(values) != 0).sum()) + 1
        distinct = len(np.unique(values))
        together = blocks == distinct and n.unit is None
        if "hold" in n.words and n.unit in {"s", "ms", "min"} and out.hold is None:
            out.hold = n
        elif whole and n.has(names.SESSION) and together and out.session is None:
            out.session = n
        elif whole and n.has(names.CAPTURE) and n.unit is None and out.capture is None and together:
            out.capture = n
        elif whole and n.has(names.REPEAT) and n.unit is None and out.repeat is None:
            out.repeat = n
        elif whole and out.capture is None and together and blocks < len(values) and _counts(n, values):
            out.capture = n
        elif whole and n.words[:1] and n.words[0] in names.COUNTER:
            out.remarks.append(f"column {n.column!r} counts rows and is left out")
        else:
            kept.append(n)
    return kept


def _counts(name: Name, values: Floats) -> bool:
    """Whether a column is called a number of something, and goes up by one at a time."""
    return (
        name.words[:1] != ()
        and name.words[0] in names.COUNTER
        and bool(np.isin(np.diff(values), (0, 1)).all())
    )


def _find_markers(out: Roles, rest: list[Name]) -> list[Name]:
    """Take out x, y, z (or two of them) of one owner."""
    found: dict[str, dict[str, Name]] = {}
    for n in rest:
        if n.axis is not None and not n.has(
            names.PRESSURE | names.COMMANDED | names.AMBIENT | {"force", "q"}
        ):
            found.setdefault(n.owner, {}).setdefault(n.axis, n)
    out.markers = {owner: axes for owner, axes in found.items() if len(axes) >= 2}
    taken = {n.column for axes in out.markers.values() for n in axes.values()}
    return [n for n in rest if n.column not in taken]


def _find_inputs(out: Roles, rest: list[Name]) -> None:
    def pressure(n: Name) -> bool:
        return n.has(names.PRESSURE) or (n.unit is not None and n.unit.endswith(_PRESSURES))

    def drive(n: Name) -> bool:
        return n.has(names.INPUT) or (n.unit is not None and n.unit.endswith(_DRIVES))

    ambient = [n for n in rest if n.has(names.AMBIENT) or n.unit in {"degC", "K"}]
    rest = [n for n in rest if n not in ambient]
    commanded = [n for n in rest if n.has(names.COMMANDED)]
    inputs = (
        commanded
        or [n for n in rest if pressure(n) and not n.has(names.MEASURED)]
        or [n for n in rest if pressure(n)]
        or [n for n in rest if drive(n)]
    )
    if not inputs and rest:
        quiet = [n for n in rest if not n.has(names.OUTPUT)]
        inputs = (quiet or rest)[:1] if (len(rest) > 1 or out.markers) else []
        if inputs:
            out.remarks.append(
                f"no column is called a pressure, a set-point or an input: {inputs[0].column!r} is taken for it"
            )
    out.actuation = inputs
    left = [n for n in rest if n not in inputs]
    for n in list(left):
        if commanded and (pressure(n) or n.has(names.MEASURED)) and (own := _same(n, inputs, left)):
            out.measured.append((n, own))
            left.remove(n)
    out.observables, out.covariates = left, ambient
    if not left and not out.markers and ambient:
        out.observables, out.covariates = ambient, []


def _same(measured: Name, inputs: list[Name], left: list[Name]) -> Name | None:
    """The input that a sensor reads: what is left of both names without their roles is alike."""
    roles = names.COMMANDED | names.MEASURED
    key = [w for w in measured.words if w not in roles]
    alike = [n for n in inputs if [w for w in n.words if w not in roles] == key]
    if alike:
        return alike[0]
    pressures = [n for n in left if n.has(names.PRESSURE)]
    return inputs[0] if len(inputs) == 1 and len(pressures) == 1 and measured.has(names.PRESSURE) else None
