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
        if s.absolute and not s.scanned and any(f.kind == "pressure" for f in s.features)
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


def columns_of_space(space: Space, context: Context) -> Floats:
    """What a weight of 1 of each of `labels_of` changes in the pressures, units of the actuation, (F, C, q)."""
    P = np.stack([f.values for f in space.features if f.kind == "pressure"], axis=2) * context.span[:, None]
    F, C, a = P.shape
    if C == 1:
        return P
    apart = np.zeros((F, C, C, a))
    apart[:, range(C), range(C)] = P
    return np.concatenate([P, apart.reshape(F, C, C * a)], axis=2)


def weighted(effect: Effect, context: Context, form: str, labels: Sequence[str]) -> Variant:
    """The form with these weights on a run; what is zero all over it, as a lag where nothing moved, changes nothing."""
    feature = np.zeros((*context.rows.actuation.shape, len(labels)))
    for space in weighable(effect, context):
        if form_of(space) == form:
            at = {name: i for i, name in enumerate(labels_of(space, context.rows.chambers))}
            known = columns_of_space(space, context)
            for j, label in enumerate(labels):
                if label in at:
                    feature[:, :, j] = known[:, :, at[label]]
    return Variant(form, (Term(WEIGHTS.name, "pressure", feature, tuple(labels)),))
