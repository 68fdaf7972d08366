"""One file of an import: its rows in labrig's terms, cut into captures."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.tables import (
    Actuation,
    Covariate,
    Mapping,
    Measured,
    Observable,
    Table,
    TableFile,
    by_time,
    conversion,
    factor,
    in_rows,
    is_dated,
    is_length,
    join_tables,
    read_table,
    said_of_absolute,
    seconds,
    short,
    unseen,
    why_back,
)

Labels = NDArray[np.object_]
_NAMED = 3
_COARSE = 0.3  # share of rows with the time of the row before, from which on it is said


class Part:
    """One file: n rows of C actuations and K observables; `capture` (n,) numbers the captures within the file.

    `keep` (n,) are the rows that are recorded; the others are history only. `segment` (n,) names the piece of a stream
    that a row is in, "" elsewhere. `remarks` are what the person who imports should know.
    """

    def __init__(self, mapping: Mapping, file: TableFile, mapping_path: Path) -> None:
        folder = mapping_path.parent
        self.mapping, self.file, self.mapping_path = mapping, file, mapping_path
        self.remarks: list[str] = []
        self._blank: dict[str, tuple[NDArray[np.bool_], str | int]] = {}
        self.table: Table = read_table(folder / file.file, mapping, file.part)
        own = [c for c in mapping.without_thousands() if c in self.table.frame.columns]
        said = (*self.table.said, *self.table.parted(own))
        self.remarks += [f"{self.table.path.name}: {line}" for line in said]
        self.n = len(self.table.frame)
        self.time_s = np.array(self._time())
        if mapping.time is not None and mapping.time.sort:
            self._sort()
        if mapping.join:
            self.table = join_tables(
                self.table, self.time_s, mapping.join, file.join, folder, mapping.observables, self.remarks
            )
        self._only_joined()
        self.actuation = self._actuation()
        self.observables = observables_of(mapping, self.table)
        self.values = self._values()
        self.measured = self._measured()
        self.covariates = self._covariates()
        self._say_blank()
        self.session = self._session()
        self.repeat = self._labels(mapping.repeat, "repeat")
        self.hold_s = self._hold()
        self.keep = np.arange(self.n) % mapping.format.every == 0
        self.segment: Labels = np.full(self.n, "", dtype=object)
        self.capture = self._captures()
        if mapping.time is None and mapping.hold is not None:
            self.time_s = self._after_each_other()
        self._check_time()
        self._remark_on_clock()

    @property
    def starts(self) -> Ints:
        """The first row of each capture."""
        return np.flatnonzero(np.r_[True, np.diff(self.capture) != 0])

    def each_alone(self, rows: NDArray[np.bool_]) -> None:
        """Make every one of some rows (n,) a capture of its own."""
        new = np.r_[True, (np.diff(self.capture) != 0) | rows[1:] | rows[:-1]]
        self.capture = np.cumsum(new) - 1

    @property
    def counts_rows(self) -> bool:
        """Whether nothing says when a row was, so that rows are taken as 1 s apart."""
        return self.mapping.time is None and self.mapping.hold is None and not self._in_frames()

    def _in_frames(self) -> bool:
        return "time_s" in self.table.frame.columns and self.table.path.suffix.lower() == ".c3d"

    def _time(self) -> Floats:
        if self.mapping.time is not None:
            return seconds(self.table, self.mapping.time, "time", self.remarks)
        if self._in_frames():
            return self.table.numbers("time_s", "time")
        return np.arange(self.n, dtype=float)

    def _sort(self) -> None:
        """Put the rows in the order of their time."""
        order = by_time(self.time_s, self._session())
        self.table, self.time_s = in_rows(self.table, order), self.time_s[order]

    def _only_joined(self) -> None:
        """Leave out the rows for which a joined file has no input: before it began or after it ended."""
        names = tuple(f"{j.name}." for j in self.mapping.join)
        inputs = [a.column for a in self.mapping.actuation if str(a.column).startswith(names)]
        inputs = [c for c in inputs if c in self.table.frame.columns]
        if not names:
            return
        if not inputs:
            self.remarks += [f"{self.table.path.name}: {line}" for line in self.table.said]
            return
        whole = np.isfinite(self.table.frame[inputs].to_numpy(dtype=float)).all(axis=1)
        if whole.all():
            return
        if not whole.any():
            raise LabrigError(f"{self.table.path}: no row has an input from the joined file; see 'within_s'")
        self.remarks.append(
            f"{self.table.path.name}: {int((~whole).sum())} of {self.n} rows are left out: "
            "the joined file has no input at their time"
        )
        frame = self.table.frame.loc[whole].reset_index(drop=True)
        lines = self.table.lines
        self.table = replace(self.table, frame=frame, lines=None if lines is None else lines[whole])
        self.time_s = self.time_s[whole]
        self.n = len(frame)

    def _actuation(self) -> Floats:
        out = np.zeros((self.n, len(self.mapping.actuation)))
        for c, entry in enumerate(self.mapping.actuation):
            if entry.column is not None:
                out[:, c] = entry.scaled(self._commanded(entry))
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

    def _commanded(self, entry: Actuation) -> Floats:
        """What a column of commands says in each row (n,), also where it is written only on a change."""
        what = f"actuation {entry.name}"
        assert entry.column is not None
        numbers = self._numbers(entry, what, required=not entry.on_change)
        known = np.flatnonzero(np.isfinite(numbers))
        if len(known) == 0 or known[0] > 0:
            raise LabrigError(
                f"{self.table.at(0)}: column {entry.column!r} ({what}) is empty in the first row: what was commanded "
                "before its first change is not known; write it there"
            )
        return numbers[known[np.searchsorted(known, np.arange(self.n), side="right") - 1]]

    def _values(self) -> Floats:
        columns = []
        for o in self.observables:
            scale = factor(o.unit, "mm", f"observable {o.name}") if o.marker and is_length(o.unit) else 1.0
            columns.append(o.scaled(self._numbers(o, f"observable {o.name}")) * scale)
        names, owners = [o.name for o in self.observables], [o.marker for o in self.observables]
        markers = list(dict.fromkeys(owner for owner in owners if owner))
        own = np.array([markers.index(owner) if owner else -1 for owner in owners])
        values, said = unseen(np.stack(columns, axis=1), names, own)
        self.remarks += [f"{self.table.path.name}: {line}" for line in said]
        return values

    def _measured(self) -> Floats:
        names = [a.name for a in self.mapping.actuation]
        out = np.full((self.n, len(names)), np.nan)
        for entry in self.mapping.measured:
            numbers = self._numbers(entry, f"measured {entry.name}")
            c = names.index(entry.name)
            unit = self.mapping.actuation[c].unit
            where = f"{self.mapping_path}: measured {entry.name}"
            plain = "1" in (unit, entry.unit) or unit == entry.unit
            scale, offset = (1.0, 0.0) if plain else conversion(entry.unit, unit, where)
            out[:, c] = scale * entry.scaled(numbers) + offset
        return out

    def _covariates(self) -> Floats:
        columns = []
        for entry in self.mapping.covariates:
            if entry.column is None:
                columns.append(np.full(self.n, self.file.covariates.get(entry.name, np.nan)))
            else:
                columns.append(entry.scaled(self._numbers(entry, f"covariate {entry.name}")))
        return np.stack(columns, axis=1) if columns else np.zeros((self.n, 0))

    def _numbers(
        self, entry: Actuation | Observable | Measured | Covariate, what: str, *, required: bool = False
    ) -> Floats:
        """What the column of an entry holds in each row (n,), before its scale; in its unit, where it has none."""
        assert entry.column is not None
        unit = entry.unit if entry.scale == 1 and entry.offset == 0 else None
        out = self.table.numbers(entry.column, what, required=required, thousands=entry.thousands, unit=unit)
        if isinstance(entry, Actuation | Measured) and not entry.offset:
            line = said_of_absolute(self.table, entry.column, entry.unit, out)
            self.remarks += [f"{self.table.path.name}: {line}"] if line else []
        if not isinstance(entry, Actuation) and (blank := np.isnan(out)).any():
            self._blank[what] = blank, entry.column
        return out

    def _say_blank(self) -> None:
        """Say in how many rows of what was measured there is no number, and what stands there first."""
        if not self._blank:
            return
        counts = [(int(blank.sum()), what) for what, (blank, _) in self._blank.items()]
        each = [f"{n}{'' if i else f' of {self.n} rows'} for {what}" for i, (n, what) in enumerate(counts)]
        more = f" (and {len(each) - _NAMED} more columns)" if len(each) > _NAMED else ""
        row, column = min(
            ((int(b.argmax()), column) for b, column in self._blank.values()), key=lambda found: found[0]
        )
        cell: Any = self.table.frame[column].iloc[row]
        stands = f" ({short(cell.strip())})" if isinstance(cell, str) and cell.strip() else ""
        self.remarks.append(
            f"{self.table.path.name}: no number stands in {', in '.join(each[:_NAMED])}{more}; first in "
            f"{self.table.at(row).removeprefix(f'{self.table.path}, ')}{stands}"
        )

    def _labels(self, entry: Any, what: str) -> Labels:
        if entry is None:
            return np.full(self.n, "", dtype=object)
        return self.table.labels(entry.column, what)

    def _session(self) -> Labels:
        if self.mapping.session is not None:
            return self._labels(self.mapping.session, "session")
        return np.full(self.n, self.file.session or Path(self.file.file).stem, dtype=object)

    def _hold(self) -> Floats:
        if self.mapping.hold is None:
            return np.full(self.n, np.nan)
        hold = self.mapping.hold
        scale = factor(hold.unit, "s", f"{self.mapping_path}: hold")
        return self.table.numbers(hold.column, "hold", thousands=hold.thousands, unit=hold.unit) * scale

    def _after_each_other(self) -> Floats:
        """The time of each row (n,) where only that within its hold is known: each hold begins where one ended."""
        longest = np.maximum.reduceat(np.nan_to_num(self.hold_s), self.starts)
        began = np.cumsum(longest) - longest
        return began[np.cumsum(np.r_[True, np.diff(self.capture) != 0]) - 1] + np.nan_to_num(self.hold_s)

    def _captures(self) -> Ints:
        """Number of the capture of each row; rows of one capture stand together."""
        if self.file.events:
            begins = np.array([e.time_s for e in self.file.events])
            return np.searchsorted(begins, self.time_s, side="right").astype(np.int64)
        how = self.mapping.capture
        if how is None or how.per == "segment":
            return np.arange(self.n)
        if how.per == "file":
            return np.zeros(self.n, dtype=np.int64)
        labels = self._labels(how, "capture")
        new = np.r_[
            True, (labels[1:] != labels[:-1]) | (self.session[1:] != self.session[:-1]) | (labels[1:] == "")
        ]
        out = np.cumsum(new) - 1
        seen: dict[tuple[str, str], int] = {}
        for i in np.flatnonzero(new).tolist():
            if labels[i] and seen.setdefault((self.session[i], labels[i]), i) != i:
                raise LabrigError(
                    f"{self.table.at(i)}: capture {labels[i]!r} appears again "
                    f"after another one; rows of one capture must stand together{self._if_shuffled()}"
                )
        return out

    def _if_shuffled(self) -> str:
        back = np.flatnonzero(self._back())
        return why_back(self.time_s, int(back[0]) + 1, dated=self._dated) if len(back) else ""

    @property
    def _dated(self) -> bool:
        return self.mapping.time is not None and is_dated(self.mapping.time)

    def _back(self) -> NDArray[np.bool_]:
        """Whether the clock goes back within a session, from each row to the next, (n - 1,)."""
        return (np.diff(self.time_s) < 0) & (self.session[1:] == self.session[:-1])

    def _check_time(self) -> None:
        back = self._back()
        if back.any():
            i = int(np.flatnonzero(back)[0])
            why = why_back(self.time_s, i + 1, dated=self._dated)
            raise LabrigError(
                f"{self.table.at(i + 1)}: time goes backward within session {self.session[i]!r}{why}"
            )

    def _remark_on_clock(self) -> None:
        """Say where many rows have the time of the row before: such a clock does not tell when in a hold they were."""
        same = np.diff(self.time_s) == 0
        if self.mapping.time is None or self.mapping.hold is not None or same.sum() <= _COARSE * self.n:
            return
        step = float(np.median(np.diff(np.unique(self.time_s)))) if np.ptp(self.time_s) > 0 else 0.0
        goes = f"it goes in steps of {step:.3g} s" if step > 0 else "it stands still"
        self.remarks.append(
            f"{self.table.path.name}: {int(same.sum())} of {self.n} rows have the time of the row before, {goes}: when "
            "in a hold they were is not known, and creep, leak and delay are not seen there; is there a finer clock, "
            "or a 'hold:'?"
        )


def observables_of(mapping: Mapping, table: Table) -> list[Observable]:
    """The observables of a mapping; those of a C3D file are its markers' coordinates, in mm."""
    if mapping.observables:
        return mapping.observables
    if table.path.suffix.lower() != ".c3d":
        raise LabrigError(f"{table.path}: the mapping names no observables")
    joined = tuple(f"{join.name}." for join in mapping.join)
    return [
        Observable(column=str(c), name=str(c), unit="mm", marker=str(c).rsplit(".", 1)[0], axis=str(c)[-1])  # type: ignore[arg-type]
        for c in table.frame.columns
        if str(c).endswith((".x", ".y", ".z")) and not str(c).startswith(joined)
    ]


def session_blocks(parts: Sequence[Part]) -> list[tuple[Part, slice]]:
    """The stretches of rows of one session, in the order of the files."""
    out = []
    for part in parts:
        edges = np.flatnonzero(np.r_[True, part.session[1:] != part.session[:-1], True])
        out += [(part, slice(int(a), int(b))) for a, b in itertools.pairwise(edges)]
    return out
