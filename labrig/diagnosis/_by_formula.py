"""How well the formula of each effect by itself predicts captures that it did not see, beside those of the others."""

from collections.abc import Mapping, Sequence

import numpy as np

from labrig.diagnosis._candidates import Candidate
from labrig.diagnosis._formula import forms_of
from labrig.diagnosis._regression import Regression
from labrig.effects import Context, Effect, is_family

_EXACT = 1e-12
"""Share of the error below which nothing is told apart; numerical."""


class ByFormula:
    """The forms of each effect, fitted by itself, each looked for once."""

    def __init__(self, regression: Regression, context: Context, effects: Mapping[str, Effect]) -> None:
        self.regression, self.context, self.effects = regression, context, effects
        self._found: dict[str, list[Candidate]] = {}

    def forms(self, name: str) -> list[Candidate]:
        """The forms of an effect, best first; none where none can act on these runs."""
        if name not in self._found:
            self._found[name] = forms_of(self.regression, self.context, self.effects[name])
        return self._found[name]

    def ahead(self, likely: Sequence[str]) -> dict[str, float]:
        """For every effect the logarithm of how many times less the formula of it alone errs, on captures that were
        left out, than the best of any other does; of effects that are not `likely` none is tried.

        No effect errs more than the model without it does. A family's own weights are no formula: they follow what they
        can, whatever made it.
        """
        regression = self.regression
        without = self._square(regression.nothing)
        formulas = {
            name: next((form for form in self.forms(name) if not is_family(form.variant.form)), None)
            for name in likely
        }
        squares = {
            name: min(self._square(formula.alone.heldout), without)
            for name, formula in formulas.items()
            if formula is not None
        }
        least = max(_EXACT * without, np.finfo(float).tiny)

        def of(name: str) -> float:
            others = min((square for other, square in squares.items() if other != name), default=without)
            return 0.5 * float(np.log(max(others, least) / max(squares.get(name, without), least)))

        return {name: of(name) for name in self.effects}

    def _square(self, predicted: np.ndarray) -> float:
        """What is left, by the noise of each observable: of several units all count."""
        return float(self.regression.square(self.regression.residual - predicted).sum())
