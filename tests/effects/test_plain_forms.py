"""The laws that are written down first have a space of their own each, and so are named before wider ones."""

from collections.abc import Iterator

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._design import design_of
from labrig.diagnosis._diagnose import observed
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


@pytest.mark.parametrize("seed", [1, 2])
def test_errors_of_full_scale_are_the_regulators(make_lab, seed: int) -> None:
    """Gains that are off by a few per cent, of each chamber by its own, either way (IEC 61298-2), have their name."""
    lab = make_lab(chambers=4, markers=10, captures=60, seed=seed)
    off = 1 + np.random.default_rng(seed).permutation([-0.07, 0.04, 0.06, -0.05])
    found = verdict_of(lab.dataset(lab.predict(lab.u * off) + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("identified", ("regulator",))


def test_plain_forms_are_together_as_likely_as_the_family(make_lab) -> None:
    """However many forms an effect has, half of its prior probability is its family's, all of it where it has none."""
    lab = make_lab(captures=40)
    model = lab.model()
    effects = model.library()
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    _, observations = observed(prepared(rows_from(data), model), effects)
    shares: dict[str, dict[bool, float]] = {}
    for block in design_of(observations, effects).blocks:
        if block.owner in ("regulator", "stiffening", "hysteresis"):
            own = shares.setdefault(block.owner, {True: 0.0, False: 0.0})
            own[block.space.plain] += block.share
    assert shares == {
        "regulator": pytest.approx({True: 0.5, False: 0.5}),
        "stiffening": pytest.approx({True: 0.5, False: 0.5}),
        "hysteresis": pytest.approx({True: 0.0, False: 1.0}),
    }
