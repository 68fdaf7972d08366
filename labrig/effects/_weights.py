"""An effect whose law has no formula that is good enough: the weights of its family's own functions."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import WEIGHTS, Effect, Term, Variant
from labrig.effects._family import Space

_FORM = "family, "
_OF = " of "


def weighable(effect: Effect, context: Context) -> Iterator[Space]:
    """The spaces of an effect whose functions mean the same on every run: of the pressures, or of the observables."""
    for space in effect.family(context):
        same = space.absolute and not space.scanned and space.apart is None
        if same and space.features and all(f.kind != "pattern" for f in space.features):
            yield space


def form_of(space: Space) -> str:
    """The name of the form in which a space's functions are weighted."""
    return _FORM + space.key


def is_family(form: str | None) -> bool:
    """Whether a form is a family's own."""
    return bool(form) and str(form).startswith(_FORM)


def labels_of(space: Space, chambers: Sequence[str]) -> list[str]:
    """Names of the weights: of each function of the pressures in all chambers together, then in each by itself; then of
    each function of the observables.
    """
    names = [f.name for f in space.features if f.kind == "pressure"]
    apart = [f"{name}{_OF}{chamber}" for chamber in chambers for name in names] if len(chambers) > 1 else []
    return [*names, *apart, *(f.name for f in space.features if f.kind == "field")]


def pressures_of(space: Space, context: Context) -> Floats:
    """What each function of a space changes in the pressures, units of the actuation, (F, C, a)."""
    changes = [f.values for f in space.features if f.kind == "pressure"]
    if not changes:
        return np.zeros((*context.rows.actuation.shape, 0))
    return np.stack(changes, axis=2) * context.span[:, None]


def fields_of(space: Space, context: Context) -> Floats:
    """What each function of a space changes in the observables themselves, (F, K, b)."""
    changes = [f.values for f in space.features if f.kind == "field"]
    return np.stack(changes, axis=2) if changes else np.zeros((*context.base.shape, 0))


def made_of(pressures: Floats, weights: Floats) -> Floats:
    """What functions of the pressures (F, C, a) change together by weights (q, r) of all their labels, (F, C, r)."""
    C, a = pressures.shape[1:]
    alike, apart = weights[:a], weights[a:].reshape(-1, a, weights.shape[1])
    each = (pressures[:, c] @ (alike + apart[c] if len(apart) else alike) for c in range(C))
    return np.stack(list(each), axis=1)


def term_of(space: Space, context: Context, weights: Floats, labels: tuple[str, ...]) -> Term:
    """The functions of a space by weights (q, r) of all `labels_of`: a change of the pressures where they are functions
    of these alone, else of the observables.
    """
    fields, pressures = fields_of(space, context), pressures_of(space, context)
    own = len(weights) - fields.shape[2]
    if not own:
        return Term(WEIGHTS.name, "field", fields @ weights, labels)
    change = made_of(pressures, weights[:own])
    if not fields.shape[2]:
        return Term(WEIGHTS.name, "pressure", change, labels)
    return Term(WEIGHTS.name, "field", fields @ weights[own:] + context.jacobian @ change, labels)


def weighted(effect: Effect, context: Context, form: str, labels: Sequence[str]) -> Variant:
    """The form with these weights on a run; what is zero all over it, as a lag where nothing moved, changes nothing."""
    labels = tuple(labels)
    for space in weighable(effect, context):
        if form_of(space) == form:
            named = np.array(labels_of(space, context.rows.chambers))
            weights = (named[:, None] == np.array(labels)).astype(float)
            term = term_of(space, context, weights, labels)
            return Variant(form, (term,), centred=term.kind == "field")
    nothing = np.zeros((*context.rows.actuation.shape, len(labels)))
    return Variant(form, (Term(WEIGHTS.name, "pressure", nothing, labels),))


def yardsticks_of(effect: Effect, context: Context, form: str) -> dict[str, Floats]:
    """What the functions of a form are measured by on this run, to be saved with its weights."""
    known: dict[str, Floats] = {}
    for space in weighable(effect, replace(context, yardsticks=known)):
        if form_of(space) == form:
            break
    return known
