"""The laws that are written down first have a space of their own each, and so are named before wider ones."""

from collections.abc import Iterator

import numpy as np
import pytest

from labrig.arrays import Floats
from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._design import design_of
from labrig.diagnosis._diagnose import laid_out
from labrig.effects import Context, Effect, Term, Variant, plain_forms
from labrig.effects._forms import spaces_of
from tests.effects.test_family import check, followed, shipped, with_all
from tests.naming import verdict_of


def test_what_has_nothing_but_coefficients_to_choose(make_lab) -> None:
    """A regulator's gain has a space, which holds it and no offset; what has a time or a width to choose has none."""
    context = with_all(make_lab)
    plain = {s.key: s for s in plain_forms(shipped()["regulator"], context)}
    assert set(plain) >= {"gain", "gain per chamber", "gain and offset per chamber"}
    assert "dead band" not in plain
    scaled = np.einsum("fkc,fc->fk", context.jacobian, context.rows.actuation)
    assert followed(context, plain["gain"], scaled) > 0.999
    assert followed(context, plain["gain"], context.jacobian.sum(axis=2)) < 0.9
    for name in ("creep", "hysteresis", "contact"):
        assert not list(plain_forms(shipped()[name], context)), name


def test_plain_forms_are_spaces_like_others(make_lab) -> None:
    """Shapes, names and weights are as the diagnosis relies on, and each is one of the effect's forms."""
    context = with_all(make_lab)
    for name, effect in shipped().items():
        forms = {s.key for s in spaces_of(effect, context)}
        for space in plain_forms(effect, context):
            check(context, space)
            assert space.key in forms, name


class Stated(Effect):
    """An effect of a user's that says its forms alone."""

    name = "stated"
    meaning = "Nothing\nat all."
    acts_on = "pressure"
    parameters = ()
    reference = signature = experiment = "none"

    def variants(self, context: Context) -> Iterator[Variant]:
        yield Variant("all", (Term.common("all", context.rows.actuation),))


def test_an_effect_whose_family_is_its_forms_has_none_beside(make_lab) -> None:
    """They would be there twice."""
    context = with_all(make_lab)
    assert [s.key for s in Stated().family(context)] == ["all"]
    assert not list(plain_forms(Stated(), context))


def one_gauge(x: Floats) -> Floats:
    """A bridge with one active gauge of four, 1 % of unbalance at full scale; its span is off by its own few per cent.

    C. C. Perry, H. R. Lissner, The Strain Gage Primer, McGraw-Hill, 1962.
    """
    return x * np.array([0.94, 1.04, 1.06, 0.95]) / (1 + 0.01 * x)


def corrugated_diaphragm(x: Floats) -> Floats:
    """Gauges whose diaphragms give way ever less or, corrugated, ever more, and that were set right at both ends.

    M. Di Giovanni, Flat and Corrugated Diaphragm Design Handbook, Marcel Dekker, 1982: pressure is a w + (1 - a) w^3.
    """
    linear = np.array([1.2, 0.85, 1.15, 0.8])
    return linear * x + (1 - linear) * x**3


@pytest.mark.parametrize("law", [one_gauge, corrugated_diaphragm])
def test_ordinary_errors_of_sensors_are_the_regulators(make_lab, law) -> None:
    """Spans that are off by a few per cent, and sensors that bend between right ends (IEC 61298-2): no other."""
    lab = make_lab(chambers=4, captures=60, seed=1)
    found = verdict_of(lab.dataset(lab.predict(60.0 * law(lab.u / 60.0)) + lab.noise()), lab.model())
    assert (*found.effects, *found.rivals) == ("regulator",)


def test_plain_forms_are_together_as_likely_as_the_family(make_lab) -> None:
    """However many forms an effect has, half of its prior probability is its family's, all of it where it has none."""
    lab = make_lab(captures=40)
    model = lab.model()
    effects = model.library()
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    _, observations, _ = laid_out(prepared(rows_from(data), model), effects)
    shares: dict[str, dict[bool, float]] = {}
    for name in (
        "regulator",
        "stiffening",
        "hysteresis",
    ):  # what two share is as rare as for the one with more
        own = shares.setdefault(name, {True: 0.0, False: 0.0})
        for block in design_of(observations, {name: effects[name]}).blocks:
            if block.owner == name:
                own[block.space.plain] += block.share
    assert shares == {
        "regulator": pytest.approx({True: 0.5, False: 0.5}),
        "stiffening": pytest.approx({True: 0.5, False: 0.5}),
        "hysteresis": pytest.approx({True: 0.0, False: 1.0}),
    }
