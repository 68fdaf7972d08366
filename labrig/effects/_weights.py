"""An effect whose law has no formula that is good enough: the weights of its family's own functions."""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import WEIGHTS, Effect, Term, Variant
from labrig.effects._family import Space

_FORM = "family, "
_OF = " of "


def weighable(effect: Effect, context: Context) -> list[Space]:
    """The spaces of an effect with functions of the pressures that mean the same on every run."""
    return [
        s
        for s in effect.family(context)
        if s.absolute and not s.scanned and s.apart is None and any(f.kind == "pressure" for f in s.features)
    ]


def form_of(space: Space) -> str:
    """The name of the form in which a space's functions are weighted."""
    return _FORM + space.key


def is_family(form: str | None) -> bool:
    """Whether a form is a family's own."""
    return bool(form) and str(form).startswith(_FORM)


def labels_of(space: Space, chambers: Sequence[str]) -> list[str]:
    """Names of the weights: of each function in all chambers together, then in each by itself."""
    names = [f.name for f in space.features if f.kind == "pressure"]
    apart = [f"{name}{_OF}{chamber}" for chamber in chambers for name in names] if len(chambers) > 1 else []
    return [*names, *apart]


def pressures_of(space: Space, context: Context) -> Floats:
    """What each function of a space changes in the pressures, units of the actuation, (F, C, a)."""
    return (
        np.stack([f.values for f in space.features if f.kind == "pressure"], axis=2) * context.span[:, None]
    )


def made_of(pressures: Floats, weights: Floats) -> Floats:
    """What such functions (F, C, a) change together by weights (q, r) of all `labels_of`, (F, C, r)."""
    C, a = pressures.shape[1:]
    alike, apart = weights[:a], weights[a:].reshape(-1, a, weights.shape[1])
    each = (pressures[:, c] @ (alike + apart[c] if len(apart) else alike) for c in range(C))
    return np.stack(list(each), axis=1)


def weighted(effect: Effect, context: Context, form: str, labels: Sequence[str]) -> Variant:
    """The form with these weights on a run; what is zero all over it, as a lag where nothing moved, changes nothing."""
    feature = np.zeros((*context.rows.actuation.shape, len(labels)))
    for space in weighable(effect, context):
        if form_of(space) == form:
            named = np.array(labels_of(space, context.rows.chambers))
            feature = made_of(
                pressures_of(space, context), (named[:, None] == np.array(labels)).astype(float)
            )
    return Variant(form, (Term(WEIGHTS.name, "pressure", feature, tuple(labels)),))
