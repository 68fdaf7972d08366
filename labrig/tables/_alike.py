"""Tables of one kind: the same columns, in whatever order, or inputs and outputs that all of them have."""

from collections.abc import Sequence
from dataclasses import replace

from labrig._errors import LabrigError
from labrig.tables._mapping import Format
from labrig.tables._order import in_order
from labrig.tables._roles import roles_of
from labrig.tables._table import Table, short

Tables = Sequence[tuple[Format, Table]]


def alike(each: Sequence[Tables]) -> bool:
    """Whether the tables of several files have the same columns."""
    names = [[sorted(_names(table)) for _, table in tables] for tables in each]
    return all(own == names[0] for own in names[1:])


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
    try:
        roles = roles_of(in_order(table)[0])
    except LabrigError:
        return False
    return bool(roles.actuation and not roles.surmised and (roles.markers or roles.observables))
