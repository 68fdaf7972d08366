"""Laws that are curves of the set-points: a map that was fitted or learnt, and is not exact, errs by the same."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from labrig._turns import commonest_unit
from labrig.arrays import Ints
from labrig.diagnosis._constants import MATERIAL
from labrig.diagnosis._names import has_name, spans
from labrig.effects import Context, Effect, Space, spaces_on

MAP = "map"
"""What a map that was fitted or learnt does not follow."""
_ROWS_COMPARED = 200
"""More than for what has no name: of one chamber a row is one number."""


def family_of(effects: Mapping[str, Effect], context: Context) -> list[tuple[str, Space]]:
    """Every space of these effects, their plain forms among them, by name."""
    return [(name, space) for name, effect in effects.items() for space in spaces_on(effect, context)]


def curves(
    named: Sequence[tuple[str, Space]], effects: Mapping[str, Effect], context: Context
) -> list[Space]:
    """The effects' spaces that hold functions of the set-point alone: no more than if each capture began at rest, in
    any order.

    None where no polynomial of a degree above one was fitted, and nothing learnt: a straight line is a law, and what it
    lacks has a name; of a series that was cut off it is the next term as well, and a learnt map has ripples of its own.
    What is gone where an effect was ruled out is none either: a map lacks the same there. Nor is anything where the map
    is said to be more exact than that.
    """
    if not context.learned or _is_exact(context):
        return []
    shuffled, back = in_any_order(context)
    there = {
        (name, space.key): spans(_rows(space, back), _ROWS_COMPARED)
        for name, space in family_of(effects, shuffled)
    }
    ruled_out = {name for names in context.rows.ruled_out for name in names}
    return [
        space
        for name, space in named
        if (space.stays or name not in ruled_out)
        and has_name(space, [there.get((name, space.key), {})], _ROWS_COMPARED)
    ]


def _is_exact(context: Context) -> bool:
    """Whether a map is said to err by so little that this would be worth no name, a share of what there is to explain
    (root mean squares, of the observables that have the commonest unit): then that is no curve that it lacks.
    """
    if context.heldout_error is None:
        return False
    own = commonest_unit(context.rows.unit, context.rows.values, context.base)
    return context.heldout_error < MATERIAL * float(np.sqrt(np.nanmean(context.residual[:, own] ** 2)))


def in_any_order(context: Context) -> tuple[Context, Ints]:
    """The same captures in another order, each in a session of its own, from rest, seen at one moment of its hold,
    without what was recorded beside; and where each row (F,) has gone.
    """
    _, index = np.unique(context.rows.capture, return_inverse=True)
    n, F = int(index.max()) + 1, len(index)
    place = np.random.default_rng(0).permutation(n)[index]
    order = np.argsort(place, kind="stable")
    moved = context.thin(order)
    rows, first = moved.rows, np.unique(place[order], return_index=True)[1]
    session = place[order].astype(np.int64)
    names = tuple(str(i) for i in range(n))
    rows = replace(
        rows,
        capture=session,
        session=session,
        event=session,
        hold_s=np.ones(F),
        time_s=np.ones(F),
        event_actuation=rows.actuation[first],
        event_time_s=np.zeros(n),
        event_session=np.arange(n),
        sessions=names,
        session_keys=names,
        repeat=("",) * n,
        ruled_out=tuple(rows.ruled_out[c] for c in rows.capture[first]) if rows.ruled_out else (),
        covariates={},
        between_sessions="vented",
        start_s=float("nan"),
        goes_on=(),
    )
    alone = replace(moved, rows=rows, event_deflection=moved.deflection[first], _memo={})
    return alone, np.argsort(order)


def _rows(space: Space, order: Ints) -> Space:
    """A space with its rows in another order."""
    return replace(space, features=tuple(replace(f, values=f.values[order]) for f in space.features))
