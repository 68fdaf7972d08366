"""Captures in which somebody saw to it that an effect cannot act: it is no part of any explanation of these.

To take a suspect away and to measure again says more than set-points can: whatever law it follows, what it makes is
gone, and what stays is something else (J. Pearl, Causality, 2009, ch. 3: an intervention).
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Feature, Space
from labrig.effects._forms import plain_forms
from labrig.effects._rows import Rows

if TYPE_CHECKING:
    from labrig.effects._effect import Effect, Variant

STAYING = ", staying"
"""How the key of a space that stays ends, beside that of what is gone."""


def may_act(rows: Rows, name: str) -> NDArray[np.bool_]:
    """Whether an effect can act in each row, (F,): not where it was ruled out."""
    if not any(rows.ruled_out):
        return np.ones(len(rows.capture), dtype=bool)
    out = np.array([name in names for names in rows.ruled_out])
    return ~out[rows.capture]


def times_changed(rows: Rows, name: str) -> int:
    """How often, from one capture to the next, an effect was ruled out or could act again."""
    names = rows.ruled_out or (frozenset[str](),) * rows.n_captures
    return int(np.count_nonzero(np.diff([name in own for own in names])))


def forms_on(effect: "Effect", context: Context) -> Iterator["Variant"]:
    """The forms that an effect may take on a campaign, which change nothing where it was ruled out."""
    acts = may_act(context.rows, effect.name)
    if acts.all():
        yield from effect.variants(context)
    elif acts.any():
        yield from (_only(variant, acts) for variant in effect.variants(_seen(context, effect, acts)))


def spaces_on(effect: "Effect", context: Context) -> Iterator[Space]:
    """Its spaces, plain forms among them; where it was ruled out in some captures, each of them twice: as what is gone
    there, and as what does the same, and stays (`Space.stays`); so of places twice as many were scanned.
    """
    acts = may_act(context.rows, effect.name)
    if acts.any():
        whole = (*effect.family(context), *plain_forms(effect, context))
        yield from whole if acts.all() else (_staying(space) for space in whole)
    if acts.any() and not acts.all():
        seen = _seen(context, effect, acts)
        yield from (_space_only(s, acts) for s in (*effect.family(seen), *plain_forms(effect, seen)))


def only_where(rows: Rows, name: str, variants: Iterable["Variant"]) -> Iterator["Variant"]:
    """The same forms, which change nothing where the effect was ruled out."""
    acts = may_act(rows, name)
    yield from variants if acts.all() else (_only(variant, acts) for variant in variants)


def _seen(context: Context, effect: "Effect", acts: NDArray[np.bool_]) -> Context:
    """The context in which only what the effect can be in was measured: a scan finds nothing where it was not."""
    key = ("ruled out", effect.name)
    if key not in context._memo:
        values = np.where(acts[:, None], context.rows.values, np.nan)
        rows = replace(context.rows, values=values)
        context._memo[key] = replace(context, rows=rows, _memo={"motion": context.motion})
    return replace(context._memo[key], pinned=context.pinned)


def _only(variant: "Variant", acts: NDArray[np.bool_]) -> "Variant":
    terms = (replace(term, feature=_where(term.feature, acts)) for term in variant.terms)
    return replace(variant, terms=tuple(terms))


def _staying(space: Space) -> Space:
    return replace(space, key=space.key + STAYING, stays=True, scanned=2 * space.scanned)


def _space_only(space: Space, acts: NDArray[np.bool_]) -> Space:
    def only(feature: Feature) -> Feature:
        return replace(feature, values=_where(feature.values, acts))

    along = None if space.along is None else only(space.along)
    return replace(space, features=tuple(map(only, space.features)), along=along, scanned=2 * space.scanned)


def _where(values: Floats, acts: NDArray[Any]) -> Floats:
    return values * acts.reshape(-1, *[1] * (values.ndim - 1))
