"""Effects that act through a chamber's own pressure share a space: a law unlike all known ones is nobody's surely."""

import numpy as np
import pytest

from labrig.diagnosis._spectra import shipped as learnt
from labrig.effects._registry import shipped
from tests.effects.test_family import context_of, with_all
from tests.naming import verdict_of

OWNERS = {"regulator", "stiffening", "tension"}


def any_curve(effect, context):
    """The shared space of an effect, None where it has none."""
    return next((s for s in effect.family(context) if s.spectrum == "own pressure"), None)


def test_three_effects_share_it_and_nobody_else(make_lab) -> None:
    """It is the same for each of its owners: names, weights and values; what was learnt about it is shipped."""
    context = with_all(make_lab)
    found = {name: space for name, e in shipped().items() if (space := any_curve(e, context)) is not None}
    assert set(found) == OWNERS
    assert "own pressure" in learnt()  # else its features' own weights would stand in, silently
    one, *others = found.values()
    for other in others:
        assert [(f.name, f.kind, f.weight) for f in other.features] == [
            (f.name, f.kind, f.weight) for f in one.features
        ]
        assert all(
            np.array_equal(a.values, b.values) for a, b in zip(other.features, one.features, strict=True)
        )


def test_where_nothing_moves_there_is_none(make_lab) -> None:
    """A rig that is never actuated has no curve of its pressures."""
    lab = make_lab(captures=12, chambers=1, force=True, repeats=False)
    lab.commanded[:] = 0.0
    assert all(any_curve(shipped()[name], context_of(lab)) is None for name in OWNERS)


@pytest.mark.parametrize("bent", [0.0, 2.0])
def test_a_wall_that_gives_way_half_way_is_none_of_them_surely(make_lab, bent) -> None:
    """Walls that all give way within a tenth of their range, as if a fold opened: the data say no more than that it is
    a curve of each chamber's own pressure, on a rig that moves in proportion and on one that does not.
    """
    lab = make_lab(chambers=2, captures=60, bent=bent)
    x = lab.u / 60.0
    opened = x + 0.06 * np.tanh((x - 0.45) / 0.06)
    found = verdict_of(lab.dataset(lab.predict(60.0 * opened) + lab.noise()), lab.model())
    assert (found.verdict, set(found.rivals)) == ("confounded", OWNERS)
    assert {c.effect for c in found.considered if c.call == "sure"} == set()
