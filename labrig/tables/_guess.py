"""A mapping for a foreign file, guessed from its names and numbers; what was assumed is said."""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig.tables._alike import alike, in_common, sessions_in
from labrig.tables._entries import entries_of
from labrig.tables._header import begins_with_a_comment
from labrig.tables._mapping import Format
from labrig.tables._numerals import decimal_of
from labrig.tables._order import in_order
from labrig.tables._rate import rate_above
from labrig.tables._read import beside, kind_of, parts_of, parts_of_one_kind, read_file
from labrig.tables._roles import Roles, roles_of
from labrig.tables._several import as_one, joins_of
from labrig.tables._sniff import layout, left_above, numbers_in, sign_in_doubt, sniff
from labrig.tables._table import Table, short
from labrig.tables._time import NO_CLOCK
from labrig.tables._units_above import say_lengths, with_units_above

if TYPE_CHECKING:
    import pandas as pd

_PREVIEW = 20
_TOP = 200
_MOST_PARTS = 12
_NAMED = 3
_NOTES = 4
_UNIT = re.compile(
    r"the unit of (?P<name>'.*') (?P<what>is not said: .*?|is written as .*)(?P<size> \(95 %.*\))?"
)
_PLAIN = tuple(
    f" {what} left out"
    for what in (
        "counts rows and is",
        "counts frames and is",
        "counts set-points and is",
        "is a clock as well and is",
        "is a part of the clock, no measurement, and is",
        "in another unit and is",
    )
)


@dataclass(frozen=True)
class Guess:
    """What a file is taken for.

    `mapping` is the content of a mapping file (docs/reference/mapping.md); its path of the table starts at the
    file's own folder. `preview` are the first rows as they were read; `remarks` say what was assumed, one line each.
    """

    mapping: dict[str, Any]
    preview: "pd.DataFrame"
    remarks: list[str] = field(default_factory=list)

    @property
    def assumed(self) -> list[str]:
        """The remarks without those that nobody would ask about: columns that only number rows, or repeat another."""
        return [line for line in self.remarks if not line.endswith(_PLAIN)]


def guess_mapping(path: Path | str, folder: Path | str | None = None) -> Guess:
    """Guess what the columns of a file mean; `folder` is where the mapping is to lie, if not beside the file.

    Raises `LabrigError` when the file can't be read, or has nothing that could be an input or an output.
    """
    path = Path(path)
    if (found := _sessions(path)) is None:
        return _guess(path, _tables(path), folder)
    tables, said = found
    guess = _guess(path, tables[:1], folder)
    guess.remarks.extend(said)
    file = guess.mapping["table"]
    return _with_sessions(guess, [_session(file, how) for how, _ in tables])


def _session(file: str, how: Format, stem: str = "") -> dict[str, str]:
    """What a mapping says of a part of a file that is a session, which is named by the file as well where it has a
    `stem`.
    """
    part = str(how.part)
    return {"file": file, "part": part, "session": f"{stem}{part.strip('/').replace('/', '_')}"}


def _with_sessions(guess: Guess, files: list[dict[str, str]]) -> Guess:
    """A guess of one session for all of those that `files` are."""
    if written := {k: v for k, v in guess.mapping.pop("format", {}).items() if k != "part"}:
        guess.mapping["format"] = written
    guess.mapping["table"] = files
    return guess


def guess_together(paths: Sequence[Path], folder: Path) -> Guess:
    """The same of several files: sessions of one kind where all have the same columns, or the same inputs and outputs,
    else what was recorded of the same time in different files, which are joined by their clocks. Where files hold
    several sessions each, all of them are.
    """
    if (guess := _files_of_sessions(paths, folder)) is not None:
        return guess
    each = [_tables(path) for path in paths]
    common = None if alike(each) else in_common(each)
    each = [[one] for one in common] if common is not None else each
    if alike(each):
        guesses = (_guess(path, tables, folder) for path, tables in zip(paths, each, strict=True))
        first = next(guesses)
        # where the markers are at rest, any of them may say
        guess = first if _knows_rest(first) else next(filter(_knows_rest, guesses), first)
        guess.mapping["table"] = [beside(path, folder) for path in paths]
        return guess
    return _guess(paths[0], [one for tables in each for one in tables], folder)


def _files_of_sessions(paths: Sequence[Path], folder: Path) -> Guess | None:
    """The guess of several files of which some hold several sessions, all of one kind; None for other files.

    Those of the first file come first, until the import knows their dates.
    """
    found = [_sessions(path) for path in paths]
    if not any(found):
        return None
    each = [own[0] if own else _tables(path) for own, path in zip(found, paths, strict=True)]
    if any(not own and len(tables) > 1 for own, tables in zip(found, each, strict=True)):
        return None
    tables = [(path, how, table) for path, own in zip(paths, each, strict=True) for how, table in own]
    if len({how.model_copy(update={"part": None}).model_dump_json() for _, how, _ in tables}) > 1:
        return None
    if not alike([[(how, table)] for _, how, table in tables]):
        return None
    guesses = (_guess(path, [(how, table)], folder) for path, how, table in tables)
    first = next(guesses)
    guess = first if _knows_rest(first) else next(filter(_knows_rest, guesses), first)
    for path, own in zip(paths, found, strict=True):
        guess.remarks.extend(f"{path.name}: {line}" for line in (own[1] if own else ()))
    files = [
        {"file": file} if how.part is None else _session(file, how, f"{path.stem}_")
        for path, how, _ in tables
        for file in (beside(path, folder),)
    ]
    return _with_sessions(guess, files)


def _knows_rest(guess: Guess) -> bool:
    places = any("marker" in entry for entry in guess.mapping.get("observables", ()))
    return not places or "markers" in guess.mapping


def _tables(path: Path) -> list[tuple[Format, Table]]:
    """The tables in a file, and how each is written."""
    kind = kind_of(path)
    if kind == "text":
        return [_text(path)]
    if kind in {"c3d", "parquet", "json"}:
        return [_typed(path)]
    parts = {name: n for name, n in parts_of(path).items() if n > 1}
    if not parts:
        raise LabrigError(f"{path}: has no rows")
    if len(parts) == 1:
        return [_part(path, Format())]
    tables = _each_part(path, sorted(parts, key=lambda p: -parts[p])[:_MOST_PARTS])
    if not tables:
        raise LabrigError(f"{path}: none of its {len(parts)} parts is a table of numbers")
    return tables


def _sessions(path: Path) -> tuple[list[tuple[Format, Table]], list[str]] | None:
    """The parts of a file that are sessions of one kind, in its order, and what is said of the others."""
    parts = [name for name, n in parts_of_one_kind(path).items() if n > 1]
    tables = _each_part(path, parts) if len(parts) > 1 else []
    return sessions_in(tables, sheets=kind_of(path) == "excel") if len(tables) > 1 else None


def _each_part(path: Path, names: Sequence[str]) -> list[tuple[Format, Table]]:
    """The parts of a file that are tables, and how each is written."""
    tables = []
    for name in names:
        with suppress(LabrigError):
            tables.append(_part(path, Format(part=name)))
    return tables


def _part(path: Path, how: Format) -> tuple[Format, Table]:
    """A part of a file, and how it is written."""
    if kind_of(path) == "excel":
        how = _sheet_format(path, how)
    return how, read_file(path, how)


def _typed(path: Path) -> tuple[Format, Table]:
    """A table whose file says what is a number and what is text, and the decimal sign of numbers that are text."""
    table = read_file(path, Format())
    rows = table.frame.head(_TOP).to_numpy(dtype=object).tolist()
    decimal = decimal_of(numbers_in(_words_only(rows)), quoted=False)
    if decimal == Format().decimal:
        return Format(), table
    return (how := Format(decimal=decimal)), read_file(path, how)


def _words_only(rows: list[list[Any]]) -> list[list[str]]:
    return [[v if isinstance(v, str) else "" for v in row] for row in rows]


def _text(path: Path) -> tuple[Format, Table]:
    """A text table and how it is written; without names where a comment looked like them and has too few."""
    how = sniff(path)
    try:
        table = read_file(path, how)
        said = (line for line in (left_above(path, how), sign_in_doubt(path, how)) if line)
        return how, replace(table, said=(*table.said, *said))
    except LabrigError:
        if not how.header or how.groups or not begins_with_a_comment(path, how):
            raise
        for more in range(1, _NOTES + 1):
            bare = how.model_copy(
                update={"header": False, "units_row": False, "skip_rows": how.skip_rows + more}
            )
            with suppress(LabrigError):
                return bare, read_file(path, bare)
        raise


def _sheet_format(path: Path, how: Format) -> Format:
    """Where a sheet has its names and units, and the decimal sign of numbers in cells of text; as it is where no rows
    of numbers are found.
    """
    rows = read_file(path, how.model_copy(update={"header": False, "rows": _TOP})).frame.to_numpy().tolist()
    found = layout([["" if v is None or v != v else str(v) for v in row] for row in rows])
    if found is None:
        return how
    written = numbers_in(_words_only(rows[found[0] :]))
    return found[1].model_copy(update={"part": how.part, "decimal": decimal_of(written, quoted=False)})


def _guess(path: Path, tables: list[tuple[Format, Table]], folder: Path | str | None) -> Guess:
    read = [_read(how, table) for how, table in tables]
    as_one([roles for *_, roles in read])
    how, table, roles = max(read, key=lambda one: (_worth(one[2]), len(one[1].frame)))

    def written_as(path: Path) -> str:
        return beside(path, Path(folder)) if folder is not None else path.name

    mapping: dict[str, Any] = {"table": written_as(table.path)}
    if written := how.model_dump(exclude_defaults=True):
        mapping["format"] = written
    remarks = [*table.said, *roles.remarks]
    if roles.time is None and roles.hold is not None:
        remarks = [line for line in remarks if line != NO_CLOCK]
        remarks.append(f"each hold is taken to begin where the one before ended, by {roles.hold.column!r}")
    joined = [one for one in read if one[1] is not table]
    joins, extra = joins_of(joined, (how, table, roles), written_as, remarks)
    if joins:
        mapping["join"] = joins
    if table.path.suffix.lower() == ".c3d" and not joins:
        return _of_c3d(mapping, table)
    mapping |= entries_of(table, [("", roles), *extra], remarks)
    if not mapping["actuation"]:
        remarks.append("nothing looks like an input: name what was commanded under 'actuation:'")
        mapping["actuation"] = [{"name": "none", "value": 0.0, "unit": "1"}]
    seen, worded = mapping.get("observables"), any(own.worded for *_, own in read)
    if not seen or (worded and not any(own.measured_varies() for *_, own in read)):
        have = ", ".join(str(c) for c in list(table.frame.columns)[:8])
        said = (r for *_, own in read for r in own.remarks if "missing: [" in r or "rate_hz: " in r)
        with_words = next((f"{line}; correct it, or " for line in said), "")
        raise LabrigError(
            f"{path}: nothing is left that was measured{' and changes' if seen else ''} (columns: "
            f"{short(have, quote=False)}); {with_words}"
            "write a mapping, which may join the file of what was measured (docs/how-to/your-data.md)"
        )
    return Guess(mapping, table.frame.head(_PREVIEW), _units_in_one(remarks))


def _units_in_one(remarks: list[str]) -> list[str]:
    """Remarks, of which those on units that say the same of many columns are one."""
    alike: dict[str, list[str]] = {}
    for line in remarks:
        same = _UNIT.fullmatch(line)
        alike.setdefault(same["what"] if same else line, []).append(line)
    out = []
    for lines in alike.values():
        if len(lines) > _NAMED and (first := _UNIT.fullmatch(lines[0])):
            lines = [f"the unit of {first['name']} (and {len(lines) - 1} more) {first['what']}"]
        out += lines
    return out


def _read(how: Format, table: Table) -> tuple[Format, Table, Roles]:
    """A table, in the order of its time, with the roles of its columns."""
    table, sorted_by = in_order(with_units_above(table, how))
    roles = roles_of(table, how.part or "", _rate(table, how))
    say_lengths(roles, table, how)
    if sorted_by is not None and roles.time is not None:
        roles.time = replace(roles.time, sort=True)
        roles.remarks.insert(0, f"the rows of the file are not in the order of {sorted_by!r}: sorted by time")
    return how, table, roles


def _rate(table: Table, how: Format) -> tuple[float, int] | None:
    return rate_above(table.path, how) if how.skip_rows and kind_of(table.path) == "text" else None


def _worth(roles: Roles) -> tuple[int, bool]:
    """How much a table has; of two the one that observes: what is computed between its rows was never measured."""
    observes = bool(roles.markers or roles.observables)
    return observes + bool(roles.actuation) + (roles.time is not None), observes


def _of_c3d(mapping: dict[str, Any], table: Table) -> Guess:
    points = list(dict.fromkeys(str(c).rpartition(".")[0] for c in table.frame.columns if c != "time_s"))
    mapping |= {
        "capture": {"per": "file"},
        "actuation": [{"name": "none", "value": 0.0, "unit": "kPa"}],
        "markers": points,
    }
    remark = "a C3D file does not say what was commanded: put it under 'actuation:', or 'events:' of the file"
    return Guess(mapping, table.frame.head(_PREVIEW), [remark])
