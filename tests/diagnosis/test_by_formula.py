"""How far the formula of an effect is ahead of those of the others, on captures that were left out."""

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._by_formula import ByFormula
from labrig.diagnosis._formula import forms_of

LONG = (3.0, 4.0, 6.0, 10.0, 20.0, 40.0)


def of(lab, moved: np.ndarray) -> ByFormula:
    """The formulas of every effect on a lab's run in which its markers have moved so."""
    ready = prepared(rows_from(lab.dataset(moved)), lab.model())
    return ByFormula(ready.regression, ready.context, lab.model().library())


def leaking(lab) -> np.ndarray:
    """A leak whose flow goes with the square root of the pressure, which is no formula of the library."""
    lost = np.maximum(np.sqrt(lab.u) - 0.03 * lab.hold_s[:, :, None], 0.0) ** 2
    return lab.predict(lost) + lab.noise()


def test_the_formula_of_what_is_there_is_ahead(make_lab) -> None:
    """Of a leak by a law that the library does not know a leak's formula errs least; so far all others are behind."""
    lab = make_lab(captures=24, long_s=LONG, repeats=False)
    ahead = of(lab, leaking(lab)).ahead(["creep", "leak", "hysteresis"])
    assert ahead["leak"] > 0.2
    assert max(ahead["creep"], ahead["hysteresis"]) == pytest.approx(-ahead["leak"])


def test_what_is_not_tried_errs_as_the_model_without_it(make_lab) -> None:
    """An effect of which no formula is tried is as far behind the best as the model is without any."""
    lab = make_lab(captures=24, long_s=LONG, repeats=False)
    formulas = of(lab, leaking(lab))
    ahead = formulas.ahead(["leak"])
    assert set(ahead) == set(lab.model().library())
    assert ahead["drift"] == ahead["contact"] == pytest.approx(-ahead["leak"])
    assert formulas.ahead([])["leak"] == 0


def test_where_nothing_is_left_no_formula_is_ahead(make_lab) -> None:
    """A model that is exact leaves every formula where it was."""
    lab = make_lab(captures=12, repeats=False)
    assert of(lab, lab.predict(lab.u)).ahead(["creep", "leak"])["creep"] == pytest.approx(0, abs=0.1)


def test_each_effect_is_fitted_once(make_lab, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was looked for is remembered, also that nothing was found."""
    lab, asked = make_lab(captures=12, repeats=False), []

    def looked_for(regression, context, effect):
        asked.append(effect.name)
        return forms_of(regression, context, effect)

    monkeypatch.setattr("labrig.diagnosis._by_formula.forms_of", looked_for)
    formulas = of(lab, lab.predict(lab.u) + lab.noise())
    formulas.ahead(["contact", "gravity"])
    formulas.ahead(["contact"])
    assert formulas.forms("gravity") == formulas.forms("gravity")
    assert sorted(asked) == ["contact", "gravity"]
