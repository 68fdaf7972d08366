"""Tables of one kind: the same columns, in whatever order, or inputs and outputs that all of them have."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.tables._mapping import Format
from labrig.tables._order import in_order
from labrig.tables._roles import Roles, clock_s, roles_of
from labrig.tables._table import Table, short

Tables = Sequence[tuple[Format, Table]]
_ERA_S = 1e8
"""Dates are later than this, s since 1970; a clock that counts from its own beginning is not."""


def alike(each: Sequence[Tables]) -> bool:
    """Whether the tables of several files have the same columns."""
    names = [[sorted(_names(table)) for _, table in tables] for tables in each]
    return all(own == names[0] for own in names[1:])


def sessions_in(tables: Tables, sheets: bool) -> tuple[list[tuple[Format, Table]], list[str]] | None:
    """The tables of one file that are its sessions, and what is said of the others; None where it has no sessions.

    Sessions have the same columns and are written alike. `sheets` are sessions whatever lies beside them that can't be
    joined by a clock. Other tables, and those beside which something can be joined, are sessions where they say by a
    clock of their own both what was commanded and what was measured, for two instruments do not log the same. Tables
    whose dates overlap were recorded at once, and are none.
    """
    kinds: dict[tuple[object, ...], list[tuple[Format, Table]]] = {}
    for how, table in tables:
        key = (*sorted(_names(table)), how.model_copy(update={"part": None}).model_dump_json())
        kinds.setdefault(key, []).append((how, table))
    found = max(kinds.values(), key=lambda own: (len(own) > 1, sum(len(table.frame) for _, table in own)))
    if len(found) < 2:
        return None
    roles = _roles(found[0][1])
    if roles is not None and _overlap([clock_s(table, roles.time) for _, table in found]):
        return None
    others = [(how, table) for how, table in tables if all(table is not own for _, own in found)]
    doubtful = not sheets or any(_has_a_clock(table) for _, table in others)
    if doubtful and (roles is None or roles.time is None or not _is_whole(found[0][1])):
        return None
    said = [f"part {how.part!r} has other columns than the sessions and is left out" for how, _ in others]
    if not sheets:
        said.append(
            f"{found[0][0].part!r} to {found[-1][0].part!r} hold the same arrays: taken as {len(found)} sessions; if "
            "they were recorded at once, write a mapping of its own"
        )
    return found, said


def _overlap(clocks: Sequence[Floats | None]) -> bool:
    """Whether dates of several tables overlap."""
    known = sorted((c.min(), c.max()) for c in clocks if c is not None and len(c) and c.min() > _ERA_S)
    return any(one[1] > other[0] for one, other in pairwise(known))


def _has_a_clock(table: Table) -> bool:
    """Whether a table says when something was commanded or measured."""
    roles = _roles(table)
    return bool(roles is not None and roles.time and (roles.actuation or roles.observables or roles.markers))


def in_common(each: Sequence[Tables]) -> list[tuple[Format, Table]] | None:
    """One table of each file with the columns that all of them have, where these say both what was commanded and what
    was measured: the files are sessions, for two instruments do not log the same. None otherwise.

    What the files have beside that is left out, and the first of the tables says so.
    """
    if any(len(tables) != 1 or not tables[0][0].header for tables in each):
        return None
    tables = [tables[0] for tables in each]
    everywhere = set.intersection(*(set(_names(table)) for _, table in tables))
    kept = [(how, _with(table, everywhere)) for how, table in tables]
    if not everywhere or not _is_whole(kept[0][1]):
        return None
    said = []
    for _, table in tables:
        more = [name for name in _names(table) if name not in everywhere]
        if more:
            are = "s are" if len(more) > 1 else " is"
            said.append(
                f"{table.path.name}: {len(more)} column{are} not in every file and left out: "
                f"{short(', '.join(more), quote=False)}; a mapping of its own can have them"
            )
    how, first = kept[0]
    return [(how, replace(first, said=(*first.said, *said))), *kept[1:]]


def _names(table: Table) -> list[str]:
    return [str(column) for column in table.frame.columns]


def _with(table: Table, names: set[str]) -> Table:
    return replace(table, frame=table.frame[[c for c in table.frame.columns if str(c) in names]])


def _is_whole(table: Table) -> bool:
    """Whether a table says what was commanded, by its name, and what was measured."""
    roles = _roles(table)
    return bool(
        roles is not None and roles.actuation and not roles.surmised and (roles.markers or roles.observables)
    )


def _roles(table: Table) -> Roles | None:
    """What the columns of a table are taken for; None where nothing can be made of it."""
    try:
        return roles_of(in_order(table)[0])
    except LabrigError:
        return None
