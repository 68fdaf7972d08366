"""How many coefficients the terms of an effect have."""

from labrig.effects import Term


def term_width(term: Term, n_observables: int) -> int:
    """Those of one term, when its pattern is free over all observables."""
    if term.kind == "frame":
        return 6
    q = term.feature.shape[-1]
    return q * n_observables if term.kind == "pattern" else q
