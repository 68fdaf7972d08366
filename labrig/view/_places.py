"""The fitted values of an effect chamber by chamber, or marker by marker, as tables."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from labrig._text import give_or_take, number, with_unit, word
from labrig.arrays import flat
from labrig.view._values import NO_UNITS, ROTATION, own_unit

Table = tuple[str, list[str], list[list[str]]]
"""What the rows are, the header, and the rows."""
_Column = tuple[str, list[float], list[float], list[str]]
"""What is said above it, a value, a deviation and a unit for each row."""
_COORDINATE = re.compile(r"(.+)\.([xyz])")


def place_tables(
    parameters: Mapping[str, Any],
    chambers: Mapping[str, tuple[float, float]],
    unit: str,
    over: Mapping[str, str],
    units: Mapping[str, str] = NO_UNITS,
) -> list[Table]:
    """A row for each chamber, pair or marker that has values of its own, by name.

    `chambers` is by how much the pressure of each changes, as a share of it and in `unit`; `over` the chamber that
    moves each marker most; `units` are those of the observables.
    """
    parameters = {
        name: entry for name, entry in parameters.items() if isinstance(entry["value"], list | tuple)
    }
    tables = [
        _of_markers(name, entry, over, units)
        for name, entry in parameters.items()
        if entry.get("per") and all(_COORDINATE.fullmatch(str(label)) for label in entry["per"])
    ]
    named = {
        name: entry
        for name, entry in parameters.items()
        if entry.get("per") and not _COORDINATE.fullmatch(str(entry["per"][0]))
    }
    for labels in dict.fromkeys(tuple(map(str, entry["per"])) for entry in named.values()):
        own = {name: entry for name, entry in named.items() if tuple(map(str, entry["per"])) == labels}
        if not any(label.startswith(ROTATION) for label in labels):
            moved = chambers if set(labels) == set(chambers) else {}
            tables.append(_of_chambers(labels, own, moved, unit, units))
    if chambers and not any({row[0] for row in rows} == set(chambers) for _, _, rows in tables):
        tables.append(_of_chambers(tuple(chambers), {}, chambers, unit, units))
    return tables


def _of_chambers(
    labels: tuple[str, ...],
    own: Mapping[str, Any],
    chambers: Mapping[str, tuple[float, float]],
    unit: str,
    units: Mapping[str, str],
) -> Table:
    kind = _kind(labels, own, chambers, units)
    columns: list[_Column] = []
    header = [kind]
    for name, entry in own.items():
        for column in _columns(name, entry, labels, units):
            title, unit_of_all = column[0], set(column[3])
            header.append(with_unit(title, column[3][0]) if len(unit_of_all) == 1 else title)
            columns.append(column)
    if chambers:
        header += ["as a change of pressure, %", f"root mean square, {unit}"]
    rows = []
    for i, label in enumerate(labels):
        row = [label]
        for _, values, sd, each in columns:
            value = give_or_take(values[i], sd[i] if len(sd) == len(values) else None, 2)
            row.append(with_unit(value, each[i]) if len(set(each)) > 1 else value)
        if chambers:
            share, size = chambers[label]
            row += [f"{100 * share:+.1f}", number(size)]
        rows.append(row)
    return kind, header, rows


def _columns(
    name: str, entry: Mapping[str, Any], labels: Sequence[str], units: Mapping[str, str]
) -> list[_Column]:
    """The columns of one parameter; of what each observable has another of in each session, one for each of them."""
    several, unit = _rows(entry["value"]), str(entry.get("unit", ""))
    sds = _rows(entry["sd"]) if entry.get("sd") is not None else [[]] * len(several)
    if "_in_session" in name and isinstance(entry["value"][0], list | tuple):
        named = [*units] if len(units) == len(several[0]) else [str(k + 1) for k in range(len(several[0]))]
        across = [[float(v) for v in column] for column in zip(*several, strict=True)]
        spread = [[float(v) for v in column] for column in zip(*sds, strict=True)] or [[]] * len(across)
        return [
            (f"{word(name)} {n}", values, sd, [own_unit(unit, n, units)] * len(labels))
            for n, values, sd in zip(named, across, spread, strict=True)
        ]
    each = [own_unit(unit, label, units) for label in labels]
    bare = name.removesuffix(f"_{unit}") if len(several) == 1 else name
    numbers = [""] if len(several) == 1 else [f" {i + 1}" for i in range(len(several))]
    return [(word(bare) + n, values, sd, each) for n, values, sd in zip(numbers, several, sds, strict=True)]


def _kind(
    labels: tuple[str, ...], own: Mapping[str, Any], chambers: Mapping[str, Any], units: Mapping[str, str]
) -> str:
    """What each of the rows is."""
    if "weights" in own:
        return "function"
    if own and all("_in_session" in name for name in own):
        return "session"
    measured = not chambers and set(labels) <= set(units)
    if measured or any(len(_rows(entry["value"])) > 1 for entry in own.values()):
        return "observable"
    return "chamber" if chambers or not any("-" in label for label in labels) else "pair of chambers"


def _rows(value: Any) -> list[list[float]]:
    """Values of each label, or, where there are several sets of them, each set."""
    return [flat(each) for each in value] if isinstance(value[0], list | tuple) else [flat(value)]


def _of_markers(
    name: str, entry: Mapping[str, Any], over: Mapping[str, str], units: Mapping[str, str]
) -> Table:
    """Markers with the largest values first."""
    values = entry["value"]
    several = values if isinstance(values[0], list | tuple) else [values]
    found: dict[str, dict[str, float]] = {}
    for i, each in enumerate(several):
        for label, value in zip(entry["per"], each, strict=True):
            marker, axis = str(label).rsplit(".", 1)
            found.setdefault(marker, {})[axis if len(several) == 1 else f"{axis} ({i + 1})"] = float(value)
    axes = list(dict.fromkeys(axis for own in found.values() for axis in own))
    order = sorted(found, key=lambda marker: -sum(v**2 for v in found[marker].values()))
    unit = own_unit(str(entry.get("unit", "")), str(entry["per"][0]), units)
    columns = [axis if unit in ("", "1") else f"{axis}, {unit}" for axis in axes]
    header = [word(name.removesuffix(f"_{unit}")), *(["most moved by"] if over else []), *columns]
    rows = [
        [
            marker,
            *([over.get(marker, "")] if over else []),
            *(number(found[marker].get(axis)) for axis in axes),
        ]
        for marker in order
    ]
    return "marker", header, rows
