"""What is said of the error that is left beside the names."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from labrig.diagnosis import forms_of, prepared, rows_from
from labrig.diagnosis._candidates import fit, square_of
from labrig.diagnosis._diagnose import laid_out, result_of
from labrig.diagnosis._falls import Fall, beside_named, much_left
from labrig.diagnosis._verdict import Considered, Verdict
from labrig.effects import library


def test_what_is_left_beside_a_name_is_said() -> None:
    """A softening with the largest load so far, called a loop, leaves a third of the error: the line says so."""
    (line,) = much_left(["hysteresis"], base=4.3, model=1.4, floor=0.21, units="px")
    assert line == (
        "with hysteresis added, 1.4 of 4.3 px are left on captures that were left out, 6.7 times the noise: the law is "
        "another one of its kind, or more is missing than was named"
    )


@pytest.mark.parametrize(
    ("names", "model", "floor"), [((), 1.4, 0.2), (("leak",), 0.8, 0.2), (("leak",), 1.4, 0.8)]
)
def test_little_is_not_said(names: tuple[str, ...], model: float, floor: float) -> None:
    """Nothing where nothing was named, where a fifth is left, and where the noise is as large."""
    assert much_left(names, base=4.3, model=model, floor=floor, units="px") == []


def test_a_fall_is_the_difference_of_the_two_errors() -> None:
    """From 0.85 to 0.13 mm is a fall of 0.72 mm, as who looks at the two bars beside it counts."""
    fall = Fall("creep", fall=0.85**2 - 0.13**2, se=0.098, least=0.03**2, units="mm", before=0.85**2)
    assert (fall.helps, fall.words) == (True, "by 0.72 mm, with a standard error of 0.1 mm")


def test_what_a_fall_lacks_is_said() -> None:
    """How much is needed, where it is too small; how uncertain it is, where that is the matter."""
    little = Fall("creep", fall=0.5**2 - 0.49**2, se=1e-6, least=0.5**2 - 0.4**2, units="mm", before=0.5**2)
    unsure = Fall("creep", fall=0.5**2 - 0.4**2, se=0.18, least=0.03**2, units="mm", before=0.5**2)
    rises = Fall("creep", fall=0.5**2 - 0.6**2, se=0.18, least=0.03**2, units="mm", before=0.5**2)
    assert (little.helps, little.words) == (False, "by 0.01 mm, needed 0.1 mm")
    assert (unsure.helps, unsure.words) == (False, "by 0.1 mm, with a standard error of 0.2 mm")
    assert (rises.helps, rises.words) == (False, "by -0.1 mm, needed 0.0009 mm")


def test_what_a_possible_partner_would_take_is_said(make_lab) -> None:
    """Beside a gain that is named, a frame that was moved would take off more, and it is said how much; creep, which
    is not there, would not, and nothing is said of it.
    """
    lab = make_lab(captures=40, long_s=(3.0, 5.0, 10.0, 30.0))
    places = lab.predict(
        60 * (lab.u / 60) ** 0.92
    )  # a valve with a bow, and a camera that was turned, not to first order
    turn = Rotation.from_euler("xyz", [0.015, -0.01, 0.02])
    moved = turn.apply(places.reshape(-1, 3)).reshape(places.shape) + np.tile([1.5, -1.0, 0.8], lab.markers)
    ready = prepared(rows_from(lab.dataset(moved + lab.noise())), lab.model())
    forms = {
        n: forms_of(ready.regression, ready.context, library()[n]) for n in ("regulator", "frame", "creep")
    }
    named = forms["regulator"][0].alone
    (line,) = beside_named(named, [forms["frame"][0]], "mm")
    joint = fit([forms["regulator"][0], forms["frame"][0]])
    before, both = (
        float(np.sqrt(square_of(ready.regression, ready.regression.residual - fitted.heldout)))
        for fitted in (named, joint)
    )
    assert both < 0.3 * before
    assert line == (
        f"frame is possible beside regulator: with it, too, {both:.2g} instead of {before:.2g} mm are left on captures "
        "that were left out"
    )
    assert beside_named(joint, [forms["creep"][0]], "mm") == []
    assert beside_named(None, [forms["frame"][0]], "mm") == []


@pytest.mark.parametrize("hidden_kpa", [0.0, 4.0])
def test_what_helps_is_possible_where_what_is_named_helps_nothing(make_lab, hidden_kpa: float) -> None:
    """A rest shape that evidence is sure of, and that takes nothing off captures that were left out, is no likelier
    than the loop that does: both are possible, and the loop goes into the model. Where nothing helps, nothing does.
    """
    lab = make_lab(captures=40)
    model, base = lab.model(), lab.predict(lab.u)
    loop = lab.predict(lab.looped(hidden_kpa)) - base
    data = lab.dataset(base + loop - loop.mean(axis=(0, 1)) + lab.noise())
    ready, observations, _ = laid_out(prepared(rows_from(data), model), model.library())
    considered = (Considered("rest_shape", 0.9), Considered("hysteresis", 0.03), Considered("leak", 0.0))
    verdict = Verdict("identified", ("rest_shape",), 0.9, considered=considered)
    said = result_of(ready, observations, verdict, model, model.library())
    assert not said.summary["effects"]
    assert said.summary["rivals"] == (["rest_shape", "hysteresis"] if hidden_kpa else ["rest_shape"])
    added = said.improved.file.effects if said.improved else []
    assert [entry.name for entry in added] == (["hysteresis"] if hidden_kpa else [])
