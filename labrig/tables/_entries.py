"""The entries of a mapping for what a file's columns are taken for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from labrig.tables._held import is_steps
from labrig.tables._names import Name
from labrig.tables._rest import rest_of
from labrig.tables._roles import Roles
from labrig.tables._several import count_names, on_change, plain
from labrig.tables._table import Table
from labrig.tables._units import atmosphere, conversion

_NAMED = 3
_FEWEST_ROWS = 20
"""Of a table with fewer, no segments are asked for."""

Source = tuple[str, Roles]
"""A table that is read, by the prefix that its columns have where they are joined to others, and their roles."""


@dataclass(frozen=True)
class _Names:
    """How columns are called in a mapping: `table` is the one that others are joined to."""

    table: Table
    counted: Mapping[str, int]

    def key(self, column: str, prefix: str = "") -> str | int:
        """What the mapping finds a column by."""
        return f"{prefix}.{column}" if prefix else self.table.key(column)

    def called(self, name: str, prefix: str) -> str:
        """A name, with its table's where several have it."""
        return f"{prefix}.{name}" if prefix and self.counted[name] > 1 else name


def entries_of(table: Table, sources: Sequence[Source], remarks: list[str]) -> dict[str, Any]:
    """What a mapping says of the columns of `sources` (`table` is the first); `remarks` gain what was assumed."""
    roles = sources[0][1]
    names = _Names(table, count_names([own for _, own in sources]))
    out = _of_rows(table, roles, names)
    out["actuation"] = _actuation(sources, names, remarks)
    if measured := _measured(sources, names, out["actuation"], remarks):
        out["measured"] = measured
    if observables := _observables(sources, names, remarks):
        out["observables"] = observables
    if rest := rest_of(roles, {o["name"]: o["unit"] for o in observables if "marker" in o}, remarks):
        out["markers"] = rest
    if covariates := [_as_read(n, prefix, names) for prefix, own in sources for n in own.covariates]:
        out["covariates"] = covariates
    return out


def _of_rows(table: Table, roles: Roles, names: _Names) -> dict[str, Any]:
    """When a row was recorded, and of which capture, session and repeat it is."""
    out: dict[str, Any] = {}
    if roles.time is not None:
        out["time"] = roles.time.entry([names.key(c) for c in roles.time.columns])
    if roles.capture is not None and _held(table, roles) and not _counts_rows(table, roles):
        out["capture"] = {"column": names.key(roles.capture.column)}
    elif roles.time is not None and len(table.frame) >= _FEWEST_ROWS:
        out["capture"] = {"per": "segment"}
    for what, found in (("session", roles.session), ("repeat", roles.repeat)):
        if found is not None:
            out[what] = {"column": names.key(found.column)}
    if roles.hold is not None:
        out["hold"] = {"column": names.key(roles.hold.column), "unit": roles.hold.unit}
    return out


def _actuation(sources: Sequence[Source], names: _Names, remarks: list[str]) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []
    for prefix, own in sources:
        for n in own.actuation:
            column, values = names.key(n.column, prefix), own.values[n.column]
            unit = n.unit or _assume("pressure", values, column, remarks)
            entry: dict[str, Any] = {"column": column, "name": names.called(plain(n), prefix), "unit": unit}
            entry |= _less_air(n, unit, remarks)
            if not prefix and on_change(values):
                entry["on_change"] = True
                remarks.append(f"{n.column!r} is empty in most rows: taken as written only where it changes")
            out.append(entry)
    return out


def _measured(
    sources: Sequence[Source], names: _Names, actuation: Sequence[dict[str, Any]], remarks: list[str]
) -> list[dict[str, Any]]:
    """Sensors of what is commanded, by the names of their commands."""
    commands = {entry["column"]: entry["name"] for entry in actuation}
    return [
        {
            "column": names.key(sensor.column, prefix),
            "name": commands[names.key(command.column, prefix)],
            **_in_unit_of(sensor, command, remarks),
        }
        for prefix, own in sources
        for sensor, command in own.measured
    ]


def _observables(sources: Sequence[Source], names: _Names, remarks: list[str]) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []
    for prefix, own in sources:
        lengths = _assumed_lengths(own, remarks)
        for owner, axes in own.markers.items():
            marker = names.called(owner, prefix)
            unit = next((n.unit for n in axes.values() if n.unit), None) or lengths
            out += [
                {
                    "column": names.key(axes[a].column, prefix),
                    "name": f"{marker}.{a}",
                    "unit": axes[a].unit or unit,
                    "marker": marker,
                    "axis": a,
                }
                for a in sorted(axes)
            ]
        for n in own.observables:
            if n.unit is None:
                remarks.append(f"the unit of {n.column!r} is not said: written as 1")
            if n.absolute:
                remarks.append(f"{n.column!r} is an absolute pressure, and is left as it was measured")
            out.append(_as_read(n, prefix, names))
    return out


def _as_read(n: Name, prefix: str, names: _Names) -> dict[str, Any]:
    return {
        "column": names.key(n.column, prefix),
        "name": names.called(plain(n), prefix),
        "unit": n.unit or "1",
    }


def _assumed_lengths(roles: Roles, remarks: list[str]) -> str:
    """The unit of all markers whose unit is not said, by the size of their places together."""
    silent = {o: axes for o, axes in roles.markers.items() if not any(n.unit for n in axes.values())}
    if not silent:
        return ""
    values = np.concatenate([roles.values[n.column] for axes in silent.values() for n in axes.values()])
    names = list(silent)
    return _assume("length", values, ", ".join(names[:_NAMED]) + (", ..." if names[_NAMED:] else ""), remarks)


def _less_air(n: Name, unit: str, remarks: list[str]) -> dict[str, float]:
    """The offset of an absolute pressure that is `unit` in the mapping: 0 is the air's pressure there; it is said."""
    if not n.absolute or n.unit is None:
        return {}
    air = atmosphere(unit)
    remarks.append(
        f"{n.column!r} is an absolute pressure: one standard atmosphere, {air:g} {unit}, is taken off; if the air had "
        "another, correct 'offset:'"
    )
    return {"offset": -air}


def _in_unit_of(sensor: Name, command: Name, remarks: list[str]) -> dict[str, Any]:
    """The unit of a sensor's entry, with a scale where its command is in another unit of the same kind."""
    own, unit = sensor.unit, command.unit
    if own is None or unit is None or own == unit or "1" in {own, unit}:
        unit = own or unit or "1"
        return {"unit": unit, **_less_air(sensor, unit, remarks)}
    scale, offset = (float(f"{number:.12g}") for number in conversion(own, unit, "measured"))
    return {
        "unit": unit,
        "scale": scale,
        **({"offset": offset} if offset else _less_air(sensor, unit, remarks)),
    }


def _held(table: Table, roles: Roles) -> bool:
    """Whether the inputs stand still within what is called a capture."""
    assert roles.capture is not None
    labels = table.labels(table.key(roles.capture.column), "capture")
    blocks = np.cumsum(np.r_[0, labels[1:] != labels[:-1]])
    starts = np.flatnonzero(np.r_[True, np.diff(blocks) > 0])
    if len(starts) != len(set(labels.tolist())):
        return False
    for n in roles.actuation:
        u = roles.values[n.column]
        spread = np.maximum.reduceat(u, starts) - np.minimum.reduceat(u, starts)
        if (spread > 0.05 * max(float(np.ptp(u)), 1e-12)).any():
            return False
    return True


def _counts_rows(table: Table, roles: Roles) -> bool:
    """Whether what is called a capture is another in each row of a record in which the inputs stand still."""
    assert roles.capture is not None
    labels = table.labels(table.key(roles.capture.column), "capture")
    each = len(labels) >= _FEWEST_ROWS and len(set(labels.tolist())) == len(labels)
    return each and roles.time is not None and all(is_steps(roles.values[n.column]) for n in roles.actuation)


def _assume(what: str, values: np.ndarray, name: Any, remarks: list[str]) -> str:
    """A unit by the size of the numbers; that it is an assumption is said."""
    size = float(np.nanpercentile(np.abs(values), 95)) if np.isfinite(values).any() else 0.0
    if what == "length":
        spread = float(np.nanmax(values) - np.nanmin(values)) if np.isfinite(values).any() else 0.0
        unit = "m" if size < 3 and spread < 2 else "mm"
    else:
        unit = "1"
    said = (
        f"taken as {unit}: they look like markers; say the unit" if what == "length" else f"written as {unit}"
    )
    remarks.append(f"the unit of {name!r} is not said: {said} (95 % of its numbers are below {size:.3g})")
    return unit
