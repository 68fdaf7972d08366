"""What each column of a dropped table means: read from its mapping, and put into it again as it was chosen."""

import math
from pathlib import Path
from typing import Any, TypedDict

import yaml

from labrig._errors import LabrigError
from labrig.tables import check_mapping, take_apart

SINGLE = {"time": "s", "hold": "s", "capture": None, "session": None, "repeat": None}
"""Parts of a mapping that are one column, with the unit that they are in where nobody says one, or none."""
SEVERAL = ("actuation", "measured", "observables", "covariates")
"""Those that are a list of columns."""
_NUMBERS = ("min", "max")
_CALLED = {"min": "least", "max": "most"}
"""Those as the page calls them."""
_HAVE = {
    "actuation": ("name", "unit", "min", "max"),
    "measured": ("name", "unit"),
    "observables": ("name", "unit", "marker", "axis"),
    "covariates": ("name", "unit"),
}


class Meaning(TypedDict, total=False):
    """A column, and the part of the mapping that it is in: empty where it is not used. Values are as they are typed."""

    column: str | int
    part: str
    name: str
    unit: str
    min: str
    max: str
    marker: str
    axis: str


def mapping_of(text: str) -> dict[str, Any]:
    """The mapping that a text is; raises `LabrigError` where it is none, in one line."""
    try:
        mapping = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark else ""
        raise LabrigError(f"the mapping{line}: this is no YAML; undo what was changed last") from None
    except (ValueError, RecursionError):  # a date that there is none of, or brackets in brackets
        raise LabrigError("the mapping: a value in it cannot be read; undo what was changed last") from None
    if not isinstance(mapping, dict):
        raise LabrigError("the mapping: there are no 'actuation:' and 'observables:' in it")
    return mapping


def text_of(mapping: dict[str, Any]) -> str:
    """A mapping as it is shown and kept."""
    return yaml.safe_dump(mapping, sort_keys=False, default_flow_style=None, allow_unicode=True, width=100)


def meanings(mapping: dict[str, Any], columns: list[str]) -> list[Meaning]:
    """What each of these columns means, in their order."""
    found: dict[str | int, Meaning] = {}
    for part in SINGLE:
        entry = mapping.get(part)
        for column in _columns(entry):
            unit = entry.get("unit") if isinstance(entry, dict) else None
            found[column] = {"column": column, "part": part, "unit": unit if isinstance(unit, str) else ""}
    for part in SEVERAL:
        for entry in _entries(mapping, part):
            if "column" in entry:
                known = {k: str(entry[k]) for k in _HAVE[part] if entry.get(k) is not None}
                found[entry["column"]] = {"column": entry["column"], "part": part, **known}  # type: ignore[typeddict-item]
    by_number = columns and columns[0] not in found and 0 in found
    return [
        found.get(i if by_number else c, {"column": i if by_number else c, "part": ""})
        for i, c in enumerate(columns)
    ]


def _columns(entry: Any) -> list[str | int]:
    """The columns that a part is, none or several."""
    column = entry.get("column") if isinstance(entry, dict) else None
    return [
        each for each in (column if isinstance(column, list) else [column]) if isinstance(each, str | int)
    ]


def _entries(mapping: dict[str, Any], part: str) -> list[dict[str, Any]]:
    """The entries of a part that is a list; what is half typed yet, or no entry, is none."""
    listed = mapping.get(part)
    return [
        entry
        for entry in (listed if isinstance(listed, list) else [])
        if isinstance(entry, dict) and isinstance(entry.get("column", ""), str | int)
    ]


def changed(mapping: dict[str, Any], chosen: list[Meaning]) -> dict[str, Any]:
    """The mapping with what was chosen for each column; what else it says of a column that stays in its part is kept.

    There is one time, one session and so on: of two columns the one that was chosen last is. Raises `LabrigError` for a
    number that is none.
    """
    out, about = dict(mapping), {m["column"] for m in chosen}
    for part in SINGLE:
        before = _columns(mapping.get(part))
        own = [m["column"] for m in chosen if m.get("part") == part]
        new = [c for c in own if c not in before]
        if new or (before and not own and about & set(before)):
            out.pop(part, None)
        if new:
            out[part] = {"column": new[-1]}
        if own:
            _with_unit(out, part, chosen)
    for part in SEVERAL:
        before_it = _entries(mapping, part)
        known = {e["column"]: e for e in before_it if "column" in e}
        kept = [e for e in before_it if e.get("column") not in about]
        out[part] = kept + [
            _entry(m, part, known.get(m["column"], {})) for m in chosen if m.get("part") == part
        ]
        if not out[part]:
            out.pop(part)
    if "hold" in out:
        out.pop("settle_s", None)  # they say the same
    return out


def fault_of(mapping: dict[str, Any]) -> str:
    """What is wrong with a mapping, or what a run needs that it lacks, in one line; empty where it is complete."""
    try:
        check_mapping(mapping, Path("the mapping"))
    except LabrigError as error:
        return str(error)
    if not mapping.get("observables"):
        return "the mapping: say which columns were measured"
    return ""


def _with_unit(out: dict[str, Any], part: str, chosen: list[Meaning]) -> None:
    usual, entry = SINGLE[part], out[part]
    if usual and "rate_hz" not in entry and not isinstance(entry.get("unit"), list):
        own = next(m for m in chosen if m["column"] in _columns(entry))
        said = str(own.get("unit") or "").strip() or take_apart(own["column"]).unit
        out[part] = {**entry, "unit": said or usual}


def _entry(chosen: Meaning, part: str, before: dict[str, Any]) -> dict[str, Any]:
    """One column's entry in a list: what was typed, over what was there; else what the column's name says."""
    column = chosen["column"]
    out: dict[str, Any] = {**before, "column": column}
    for key in _HAVE[part]:
        typed = str(chosen.get(key) or "").strip()
        if not typed:
            out.pop(key, None)
        else:
            out[key] = _number(typed, key, column) if key in _NUMBERS else typed
    own = take_apart(column)
    place = f"{out['marker']}.{out['axis']}" if "marker" in out and "axis" in out else own.called
    named = {"column": column, "name": place, "unit": own.unit or "1"}
    return {**named, **out}


def _number(typed: str, key: str, column: str | int) -> float:
    called = f"{_CALLED[key]} ({key})"
    try:
        value = float(typed.replace(",", "."))
    except ValueError:
        raise LabrigError(f"{column}: {called}: {typed!r} is no number") from None
    if not math.isfinite(value):
        raise LabrigError(
            f"{column}: {called}: {typed!r} is not finite; leave it empty where there is no limit"
        )
    return value
