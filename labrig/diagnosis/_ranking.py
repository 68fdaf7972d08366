"""Each effect by itself: the error with it alone, and what it takes."""

from collections.abc import Mapping

import numpy as np

from labrig.contents import Ranked
from labrig.diagnosis._candidates import Candidate, quoted
from labrig.diagnosis._constants import LEAST_FLOORS
from labrig.diagnosis._formula import forms_of
from labrig.diagnosis._parameters import parameters_of
from labrig.diagnosis._regression import Regression
from labrig.diagnosis._score import relative_error
from labrig.diagnosis._verdict import Verdict
from labrig.effects import Context, Effect

_SHOWN = 5
"""How many of the likeliest effects are fitted by themselves."""


def alone(
    regression: Regression, context: Context, verdict: Verdict, effects: Mapping[str, Effect]
) -> dict[str, list[Candidate]]:
    """The forms of the likeliest effects, each fitted by itself, best first."""
    found = {}
    for considered in verdict.considered[:_SHOWN]:
        forms = forms_of(regression, context, effects[considered.effect])
        if forms:
            found[considered.effect] = forms
    return found


def drop_of(base: float, now: float, reachable: float) -> float:
    """Share of the explainable error (root mean squares) that is gone; never more than all of it, and none where less
    than the smallest effect that is worth a name could be explained.
    """
    if base <= np.hypot(1.0, LEAST_FLOORS) * reachable:
        return 0.0
    least = min(reachable, now)
    return float((base - now) / (base - least)) if base > least * (1 + 1e-9) else 0.0


def ranking_of(
    regression: Regression,
    found: Mapping[str, list[Candidate]],
    verdict: Verdict,
    base: float,
    reachable: float,
) -> list[Ranked]:
    """Each effect alone, smallest held-out error first, with its probability beside all others."""
    probability = {c.effect: c.probability for c in verdict.considered}
    out: list[Ranked] = []
    for name, forms in found.items():
        fitted = forms[0].alone
        error = quoted(fitted)
        drop = drop_of(base, error, reachable)
        gains = regression.gains(regression.base_left, fitted.left)
        relative_se = relative_error(gains)
        out.append(
            {
                "effect": name,
                "form": forms[0].variant.form,
                "heldout_error": error,
                "drop": drop,
                "se": abs(drop) * relative_se if len(gains) > 1 else None,
                "probability": probability[name],
                "parameters": {
                    key: value.model_dump(exclude_none=True)
                    for key, value in parameters_of(regression.context, fitted, 0).items()
                },
            }
        )
    return sorted(out, key=lambda e: e["heldout_error"])
