"""Tables that were recorded of the same time, in one file or in several: what each adds, and how they are joined."""

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from labrig._text import counted
from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._aligned import offset_of, record_of
from labrig.tables._held import is_steps
from labrig.tables._inputs import is_pressure
from labrig.tables._mapping import Format
from labrig.tables._names import Name
from labrig.tables._roles import NO_INPUT, Roles, clock_s
from labrig.tables._table import Table

_NAMED = 3
_JUMPS = 0.15
"""Share of its range from which on a command jumps, and was not sampled on its way."""


def as_one(tables: Sequence[Roles]) -> None:
    """Where one table says what was commanded, nothing of the others is taken for it that is not called so."""
    said = [own for own in tables if own.actuation and not own.surmised]
    if not said or len(tables) < 2:
        return
    commanded = [own for own in said if all(n.has(names.COMMANDED) for n in own.actuation)]
    for own in tables:
        if own.surmised and own.actuation:
            own.observables = [*own.actuation, *(n for n, _ in own.measured), *own.observables]
            own.actuation, own.measured = [], []
            own.remarks = [line for line in own.remarks if not line.startswith(NO_INPUT)]
        elif commanded and own.actuation and not any(own is one for one in commanded):
            own.observables += [n for n in own.actuation if not is_pressure(n)]
            for n in (n for n in own.actuation if is_pressure(n)):
                own.covariates.append(n)
                own.remarks.append(
                    f"{n.column!r} was measured, for another table says what was commanded: taken for a covariate; "
                    "put it under 'measured:' to compare them"
                )
            own.actuation = []


def joins_of(
    others: Sequence[tuple[Format, Table, Roles]],
    main: tuple[Format, Table, Roles],
    written_as: Callable[[Path], str],
    remarks: list[str],
) -> tuple[list[dict[str, Any]], list[tuple[str, Roles]]]:
    """The other tables that have a clock, as `join:` of a mapping has them, and what they add.

    `written_as` says how a mapping writes a path. What was assumed is added to `remarks`.
    """
    joins: list[dict[str, Any]] = []
    extra: list[tuple[str, Roles]] = []
    own_s = clock_s(main[1], main[2].time)
    own = None if own_s is None else record_of(main[1].path.name, *main, own_s)
    for how, table, roles in others:
        part = f"part {how.part!r}" if table.path == main[1].path else table.path.name
        other_s = clock_s(table, roles.time)
        if roles.time is None or own is None or other_s is None:
            columns = [repr(str(column)) for column in table.frame.columns]
            more = f" and {len(columns) - _NAMED} more" if columns[_NAMED:] else ""
            remarks.append(
                f"{part} ({', '.join(columns[:_NAMED])}{more}; {counted(len(table.frame), 'row')}) has no clock to "
                "join it by and is left out"
            )
            continue
        name = (how.part or "").strip("/").replace("/", "_") or "other"
        if table.path != main[1].path:
            name = table.path.stem if len(others) == 1 or not how.part else f"{table.path.stem}_{name}"
        alone = not (roles.measured or roles.observables or roles.markers)
        steps = all(
            is_steps(v := roles.values[n.column])
            or (alone and not n.has(names.MEASURED) and are_set_points(v))
            for n in roles.actuation
        )
        entry: dict[str, Any] = {
            "name": name,
            "file": written_as(table.path),
            "time": roles.time.entry([table.key(c) for c in roles.time.columns]),
            "how": "previous" if roles.actuation and steps else "linear",
            "format": how.model_dump(exclude_defaults=True),
        }
        if offset := offset_of(own, record_of(part, how, table, roles, other_s), remarks):
            entry["offset_s"] = offset
        joins.append(entry)
        extra.append((name, roles))
        remarks.append(f"{part} is joined by time; its columns are called {name}.COLUMN")
        if table.path != main[1].path:
            remarks += [*table.said, *roles.remarks]
    return joins, extra


def count_names(tables: Sequence[Roles]) -> Counter[str]:
    """How many of these tables have something of each name."""
    return Counter(
        name
        for own in tables
        for name in {plain(n) for n in (*own.actuation, *own.observables, *own.covariates)} | {*own.markers}
    )


def plain(name: Name) -> str:
    """What a column is called in a run: its name, or its number where it has none."""
    return f"column {name.called}" if name.called.isdigit() else name.called


def are_set_points(values: Floats) -> bool:
    """Whether numbers (n,) mostly jump from row to row: each was set once, and holds until the next."""
    step, span = np.abs(np.diff(values)), np.ptp(values) if len(values) else 0.0
    return len(values) > 1 and bool(np.median(step) > _JUMPS * span)


def on_change(values: Floats) -> bool:
    """Whether a command is written only where it changes: it is there in the first row, and missing in most."""
    return bool(np.isfinite(values[:1]).all() and np.isnan(values).mean() > 0.5)
