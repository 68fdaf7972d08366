"""`labrig import`: somebody's own table becomes a run."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.log._mapping import Mapping, Observable, TableFile, read_mapping
from labrig.log._tables import Table, read_table
from labrig.log._units import check, factor, is_length

if TYPE_CHECKING:
    from xarray import Dataset

Floats = NDArray[np.float64]
_GAP_S = 1.0


def import_table(mapping_path: Path, output: Path, tables: Sequence[Path] = ()) -> "Dataset":
    """Make a run folder of foreign tables as a MAP.yaml says; returns what `open_run` gives of it.

    `tables` replaces the files that the mapping names (relative to the mapping's own folder).

    Raises `LabrigError`, and leaves nothing behind, when a file, a column or a unit does not exist, when an
    actuation or a time is not a number, or when the output exists.
    """
    from labrig.log._open import open_run
    from labrig.log._table import write_dataset

    if output.exists():
        raise LabrigError(f"{output} exists already; choose another name or remove it")
    mapping = read_mapping(mapping_path)
    files = mapping.files()
    if tables:
        known = {Path(f.file).name: f for f in reversed(files)}
        given = [known.get(t.name, TableFile(file=t.name)) for t in tables]
        files = [f.model_copy(update={"file": str(t.resolve())}) for f, t in zip(given, tables, strict=True)]
    if not files:
        raise LabrigError(f"{mapping_path}: table: name the file, or give it on the command line")
    dataset = dataset_from(mapping, files, mapping_path)
    write_dataset(
        dataset,
        output,
        run_yaml={"procedure": "import", "mapping": mapping.model_dump(mode="json", exclude_none=True)},
    )
    return open_run(output)


def dataset_from(mapping: Mapping, files: Sequence[TableFile], mapping_path: Path) -> "Dataset":
    """The campaign that tables and a mapping describe, laid out as docs/reference/dataset.md says."""
    _check_units(mapping, mapping_path)
    parts = [_Part(mapping, file, mapping_path) for file in files]
    _order_in_time(parts)
    return _assemble(mapping, parts)


class _Part:
    """One file: its rows, split into captures and events."""

    def __init__(self, mapping: Mapping, file: TableFile, mapping_path: Path) -> None:
        where = mapping_path.parent / file.file
        self.table: Table = read_table(where, mapping)
        self.mapping, self.file, self.mapping_path = mapping, file, mapping_path
        self.n = len(self.table.frame)
        self.time_s = np.array(self._time())
        self.actuation = self._actuation()
        self.observables = observables_of(mapping, self.table)
        self.values = self._values()
        self.measured = self._columns(mapping.measured, "measured")
        self.covariates = self._covariates()
        self.session = self._session()
        self.repeat = self.table.labels(mapping.repeat.column, "repeat") if mapping.repeat else [""] * self.n
        self.hold_s = self._hold()
        self.capture = self._captures()
        self._check_time()

    def _time(self) -> Floats:
        if self.mapping.time is not None:
            scale = factor(self.mapping.time.unit, "s", f"{self.mapping_path}: time")
            return (
                self.table.numbers(
                    self.mapping.time.column, "time", required=True, thousands=self.mapping.time.thousands
                )
                * scale
            )
        if "time_s" in self.table.frame.columns and self.table.path.suffix.lower() == ".c3d":
            return self.table.numbers("time_s", "time")
        return np.arange(self.n, dtype=float)

    def _actuation(self) -> Floats:
        out = np.zeros((self.n, len(self.mapping.actuation)))
        for c, entry in enumerate(self.mapping.actuation):
            if entry.column is not None:
                out[:, c] = self.table.numbers(entry.column, f"actuation {entry.name}", required=True)
            elif entry.name in self.file.actuation:
                out[:, c] = self.file.actuation[entry.name]
            elif entry.value is not None:
                out[:, c] = entry.value
            elif not self.file.events:
                raise LabrigError(
                    f"{self.mapping_path}: actuation {entry.name!r} has neither 'column:' nor 'value:', "
                    f"and {self.file.file} says nothing of it"
                )
            for event in self.file.events:
                if entry.name not in event.actuation:
                    raise LabrigError(
                        f"{self.mapping_path}: {self.file.file}: an event does not say {entry.name!r}"
                    )
                out[self.time_s >= event.time_s, c] = event.actuation[entry.name]
        return out

    def _values(self) -> Floats:
        columns = []
        for o in self.observables:
            scale = factor(o.unit, "mm", f"observable {o.name}") if o.marker and is_length(o.unit) else 1.0
            columns.append(
                self.table.numbers(o.column, f"observable {o.name}", thousands=o.thousands) * scale
            )
        return np.stack(columns, axis=1)

    def _columns(self, entries: Sequence[Any], what: str) -> Floats:
        names = [a.name for a in self.mapping.actuation]
        out = np.full((self.n, len(names)), np.nan)
        for entry in entries:
            out[:, names.index(entry.name)] = self.table.numbers(
                entry.column, f"{what} {entry.name}", thousands=entry.thousands
            )
        return out

    def _covariates(self) -> Floats:
        columns = []
        for entry in self.mapping.covariates:
            if entry.column is None:
                columns.append(np.full(self.n, self.file.covariates.get(entry.name, np.nan)))
            else:
                what = f"covariate {entry.name}"
                columns.append(self.table.numbers(entry.column, what, thousands=entry.thousands))
        return np.stack(columns, axis=1) if columns else np.zeros((self.n, 0))

    def _session(self) -> list[str]:
        if self.mapping.session is not None:
            return self.table.labels(self.mapping.session.column, "session")
        return [self.file.session or Path(self.file.file).stem] * self.n

    def _hold(self) -> Floats:
        if self.mapping.hold is None:
            return np.full(self.n, np.nan)
        scale = factor(self.mapping.hold.unit, "s", f"{self.mapping_path}: hold")
        return (
            self.table.numbers(self.mapping.hold.column, "hold", thousands=self.mapping.hold.thousands)
            * scale
        )

    def _captures(self) -> NDArray[np.int64]:
        """Number of the capture of each row within this file; rows of one capture stand together."""
        n = self.n
        if self.file.events:
            begins = np.array([e.time_s for e in self.file.events])
            return np.searchsorted(begins, self.time_s, side="right").astype(np.int64)
        if self.mapping.capture is None:
            return np.arange(n)
        if self.mapping.capture.per == "file":
            return np.zeros(n, dtype=np.int64)
        assert self.mapping.capture.column is not None
        labels = self.table.labels(self.mapping.capture.column, "capture")
        keys = list(zip(self.session, labels, strict=True))
        out = np.zeros(n, dtype=np.int64)
        seen: dict[tuple[str, str], int] = {}
        for i in range(1, n):
            out[i] = out[i - 1] + (keys[i] != keys[i - 1] or labels[i] == "")
        for i in range(n):
            if labels[i] and seen.setdefault(keys[i], int(out[i])) != out[i]:
                raise LabrigError(
                    f"{self.table.path}, line {i + self.table.first_row}: capture {labels[i]!r} appears again "
                    "after another one; rows of one capture must stand together"
                )
        return out

    def _check_time(self) -> None:
        back = np.flatnonzero(np.diff(self.time_s) < 0)
        for i in back:
            if self.session[i] == self.session[i + 1]:
                line = i + 1 + self.table.first_row
                raise LabrigError(
                    f"{self.table.path}, line {line}: time goes backward within session {self.session[i]!r}"
                )


def observables_of(mapping: Mapping, table: Table) -> list[Observable]:
    """The observables of a mapping; those of a C3D file are its markers' coordinates, in mm."""
    if mapping.observables:
        return mapping.observables
    if table.path.suffix.lower() != ".c3d":
        raise LabrigError(f"{table.path}: the mapping names no observables")
    return [
        Observable(column=str(c), name=str(c), unit="mm", marker=str(c).rsplit(".", 1)[0], axis=str(c)[-1])  # type: ignore[arg-type]
        for c in table.frame.columns
        if c != "time_s"
    ]


def _check_units(mapping: Mapping, path: Path) -> None:
    for what, entries in (
        ("actuation", mapping.actuation),
        ("measured", mapping.measured),
        ("observables", mapping.observables),
        ("covariates", mapping.covariates),
    ):
        for entry in entries:
            check(entry.unit, f"{path}: {what} {entry.name!r}")
    for what, entry in (("time", mapping.time), ("hold", mapping.hold)):
        if entry is not None:
            factor(entry.unit, "s", f"{path}: {what}")


def _order_in_time(parts: Sequence[_Part]) -> None:
    """Put files and sessions whose clocks all begin anew one after the other."""
    end = None
    for part in parts:
        begin = 0
        for i in range(1, part.n + 1):
            if i == part.n or part.session[i] != part.session[i - 1]:
                own = slice(begin, i)
                if end is not None and part.time_s[own][0] <= end:
                    part.time_s[own] += end + _GAP_S - part.time_s[own][0]
                end = float(part.time_s[own][-1])
                begin = i
    start = parts[0].time_s[0]
    for part in parts:
        part.time_s -= start


def _assemble(mapping: Mapping, parts: Sequence[_Part]) -> "Dataset":
    from labrig.log._assemble import Capture, build_dataset

    captures: list[Capture] = []
    events: list[tuple[float, Floats, str]] = []
    many = len({s for p in parts for s in p.session}) < sum(len(set(p.session)) for p in parts)
    for number, part in enumerate(parts):
        for c in range(int(part.capture.max()) + 1):
            rows = np.flatnonzero(part.capture == c)
            if not len(rows):
                continue
            _check_constant(part, rows)
            hold = part.hold_s[rows]
            known = np.isfinite(hold).all()
            begin = part.time_s[rows[0]] - (hold[0] if known else 0.0)
            session = part.session[rows[0]] + (f"#{number + 1}" if many and mapping.session is None else "")
            events.append((float(begin), part.actuation[rows].mean(axis=0), session))
            records = not part.file.events or c == 0 or part.file.events[c - 1].record
            if not np.isfinite(part.values[rows]).any() or not records:
                continue
            captures.append(
                Capture(
                    event=len(events) - 1,
                    session=session,
                    repeat=part.repeat[rows[0]],
                    time_s=part.time_s[rows],
                    hold_s=hold if known else part.time_s[rows] - part.time_s[rows[0]],
                    values=part.values[rows],
                    measured=part.measured[rows],
                    covariates=part.covariates[rows],
                )
            )
    if not captures:
        raise LabrigError(f"{parts[0].table.path}: no row has an observable that is a number")
    return build_dataset(mapping, parts[0].observables, captures, events)


def _check_constant(part: _Part, rows: NDArray[np.int64]) -> None:
    """A capture is held at one actuation; small jitter of a measured one is let pass."""
    u = part.actuation[rows]
    span = np.maximum(np.ptp(part.actuation, axis=0), np.abs(part.actuation).max(axis=0) * 0.05)
    moved = np.ptp(u, axis=0) > np.maximum(0.05 * span, 1e-12)
    if moved.any():
        name = part.mapping.actuation[int(np.flatnonzero(moved)[0])].name
        raise LabrigError(
            f"{part.table.path}, line {rows[0] + part.table.first_row}: actuation {name!r} changes within one capture; "
            "leave 'capture:' out to take every row as one"
        )
