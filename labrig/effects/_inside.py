"""Effects inside the mechanics of a simulator: its own physical parameters, moved from their values."""

from collections.abc import Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._effect import Term, Variant

FORM = "inside the simulator"


def inside(context: Context, **prefixes: str) -> Iterator[Variant]:
    """The form in which a simulator's own parameters change, to first order; nothing for any other base.

    `prefixes` names, for each parameter of the effect, those of the simulator that it stands for, by how they
    begin (one for each layer, say); the change is in the simulator's own units.
    """
    terms = []
    for parameter, prefix in prefixes.items():
        names = tuple(name for name in context.inside if name.startswith(prefix))
        if names:
            terms.append(Term.field(parameter, np.stack([context.inside[n] for n in names], axis=-1), names))
    if terms:
        yield Variant(FORM, tuple(terms))
