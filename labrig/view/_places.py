"""The fitted values of an effect chamber by chamber, or marker by marker, as tables."""

import re
from collections.abc import Mapping
from typing import Any

from labrig.view._text import give_or_take, number, with_unit, word
from labrig.view._values import ROTATION, flat

Table = tuple[str, list[str], list[list[str]]]
"""What the rows are, the header, and the rows."""
_COORDINATE = re.compile(r"(.+)\.([xyz])")


def place_tables(
    parameters: Mapping[str, Any],
    chambers: Mapping[str, tuple[float, float]],
    unit: str,
    over: Mapping[str, str],
) -> list[Table]:
    """A row for each chamber, pair or marker that has values of its own, by name.

    `chambers` is by how much the pressure of each changes, as a share of it and in `unit`; `over` the chamber that
    moves each marker most.
    """
    parameters = {
        name: entry for name, entry in parameters.items() if isinstance(entry["value"], list | tuple)
    }
    tables = [
        _of_markers(name, entry, over)
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
            tables.append(_of_chambers(labels, own, chambers if set(labels) == set(chambers) else {}, unit))
    if chambers and not any({row[0] for row in rows} == set(chambers) for _, _, rows in tables):
        tables.append(_of_chambers(tuple(chambers), {}, chambers, unit))
    return tables


def _of_chambers(
    labels: tuple[str, ...], own: Mapping[str, Any], chambers: Mapping[str, tuple[float, float]], unit: str
) -> Table:
    kind = _kind(labels, own, chambers)
    columns: list[tuple[list[float], list[float]]] = []
    header = [kind]
    for name, entry in own.items():
        several = _rows(entry["value"])
        sds = _rows(entry["sd"]) if entry.get("sd") is not None else [[]] * len(several)
        for i, (values, sd) in enumerate(zip(several, sds, strict=True)):
            header.append(_title(name if len(several) == 1 else f"{name} {i + 1}", entry))
            columns.append((values, sd))
    if chambers:
        header += ["as a change of pressure, %", f"root mean square, {unit}"]
    rows = []
    for i, label in enumerate(labels):
        row = [label, *(give_or_take(v[i], sd[i] if len(sd) == len(v) else None, 2) for v, sd in columns)]
        if chambers:
            share, size = chambers[label]
            row += [f"{100 * share:+.1f}", number(size)]
        rows.append(row)
    return kind, header, rows


def _kind(labels: tuple[str, ...], own: Mapping[str, Any], chambers: Mapping[str, Any]) -> str:
    """What each of the rows is."""
    if "weights" in own:
        return "function"
    if own and all("_in_session" in name for name in own):
        return "session"
    if any(len(_rows(entry["value"])) > 1 for entry in own.values()):
        return "observable"
    return "chamber" if chambers or not any("-" in label for label in labels) else "pair of chambers"


def _rows(value: Any) -> list[list[float]]:
    """Values of each label, or, where there are several sets of them, each set."""
    return [flat(each) for each in value] if isinstance(value[0], list | tuple) else [flat(value)]


def _of_markers(name: str, entry: Mapping[str, Any], over: Mapping[str, str]) -> Table:
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
    unit = str(entry.get("unit", ""))
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


def _title(name: str, entry: Mapping[str, Any]) -> str:
    unit = str(entry.get("unit", ""))
    return with_unit(word(name.removesuffix(f"_{unit}")), unit)
