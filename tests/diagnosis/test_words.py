"""Words of a diagnosis: numbers with their units, one or several, one pressure or several together."""

from collections import Counter

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared
from labrig.diagnosis._amount import amount
from labrig.diagnosis._notes import nearly_explained
from labrig.diagnosis._unnamed import unnamed
from labrig.diagnosis._verdict import Verdict
from labrig.effects import rows_of
from labrig.view import note


@pytest.mark.parametrize(("unit", "said"), [("mm", "0.12 mm"), ("1", "0.12")])
def test_a_unit_of_one_is_none(unit: str, said: str) -> None:
    """A quaternion's part is a number."""
    assert amount(0.1234, unit) == said


@pytest.mark.parametrize(
    ("dropped", "said"), [(1, "1 outlying value was left out"), (2, "2 outlying values were left out")]
)
def test_one_value_or_several(make_lab, dropped: int, said: str) -> None:
    """What was left out, and where; a frame that is wild is no hold that is off."""
    lab = make_lab(chambers=1, force=True, captures=30)
    values = lab.predict(lab.u) + lab.noise()
    values[4 : 4 + dropped, 1] += 40.0
    ready = prepared(rows_of(lab.dataset(values)), lab.model())
    assert ready.left_out == [f"{said} ({dropped} of force)"]
    assert ready.held_off == []


def test_a_marker_that_is_off_through_whole_holds_is_said(make_lab) -> None:
    """A wall that only three set-points meet looks like a marker that is mistaken: nothing is missing beside it."""
    lab = make_lab(chambers=2, captures=40)
    values = lab.predict(lab.u) + lab.noise()
    values[11, :, 3:6] += 30.0 * np.array([1.0, -2.0, 1.0])[:, None]  # wild in each row, another way
    values[[5, 17, 29], :, :3] += np.array([3.0, 0.0, 4.0]) * np.array([1.0, 0.6, 0.8])[:, None, None]
    found = diagnose(lab.dataset(values), lab.model()).summary
    assert found["verdict"] == "nothing_missing"
    (off,) = found["left_out"]
    assert (off["name"], off["captures"], off["units"]) == ("m0", [5, 17, 29], "mm")
    assert off["error"] == pytest.approx(5.0, rel=0.1)
    (line,) = (line for line in found["warnings"] if line.startswith("m0 was left out"))
    assert line.startswith(
        "m0 was left out in captures 5, 17, 29, where it is off all along the hold, by up to "
    )
    assert line.endswith(
        "held by something that acts there only; measure these set-points again, which tells"
    )
    assert note(found).headline.startswith(
        "Nothing is missing beside what was left out: m0 in 3 captures (off by up"
    )


@pytest.mark.parametrize(
    ("chambers", "said"), [(1, "another curve of the pressure"), (2, "pressures together")]
)
def test_one_pressure_is_not_several_together(make_lab, chambers: int, said: str) -> None:
    """A space of what pressures do in other patterns is called by how many there are."""
    lab = make_lab(chambers=chambers, captures=30)
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    keys = Counter(space.key for space in unnamed(context))
    assert [key for key in ("another curve of the pressure", "pressures together") if keys[key]] == [said]


@pytest.mark.parametrize(("value", "said"), [(0.0123, "0.012 N"), (123.4, "120 N"), (56_789.0, "57000 N")])
def test_an_amount_has_two_digits_and_no_exponent(value: float, said: str) -> None:
    """A person reads 120 N, not 1.2e+02 N."""
    assert amount(value, "N") == said


@pytest.mark.parametrize(
    ("verdict", "drop", "base", "floor", "said"),
    [
        pytest.param("unknown", 0.97, 0.547, 0.1, True, id="no name is probable enough"),
        pytest.param("unknown", 0.4, 0.547, 0.1, False, id="no formula follows it"),
        pytest.param("unknown", None, 0.547, 0.1, False, id="nothing can be explained"),
        pytest.param("unknown", 1.0, 0.13, 0.1, False, id="hardly anything can be explained"),
        pytest.param("unknown", 1.0, 0.25, 0.05, False, id="it leaves far more than the noise"),
        pytest.param("confounded", 0.97, 0.547, 0.1, False, id="it is named"),
    ],
)
def test_a_formula_that_explains_what_has_no_name_is_said(
    verdict: str, drop: float | None, base: float, floor: float, said: bool
) -> None:
    """The ranking beside an unknown reaches the noise at times: one line says so, and what to do for who knows more."""
    formula = {"effect": "rest_shape", "form": "offset", "heldout_error": 0.112, "drop": drop}
    ranking = [formula | {"se": 0.01, "probability": 0.3, "parameters": {}}]
    expected = (
        "the formula of rest shape alone would take the error from 0.55 mm to 0.11 mm; evidence does not say that it "
        "is there, so it is not added: if you know that it is, labrig improve --add rest_shape"
    )
    found = Verdict(verdict, (), 0.6, rivals=("rest_shape",))
    assert nearly_explained(found, ranking, base, 0.13, floor, 0.9, "mm") == ([expected] if said else [])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("sure", "drop", "said"),
    [
        pytest.param(("drift",), 0.5, True, id="it leaves half"),
        pytest.param((), 0.0, True, id="it takes nothing off"),
        pytest.param(("drift",), 0.95, False, id="it takes nearly all"),
        pytest.param(("creep",), 0.5, False, id="it is that one"),
    ],
)
def test_a_formula_that_explains_more_than_what_is_named_is_said(
    sure: tuple[str, ...], drop: float, said: bool
) -> None:
    """So does it beside a name, also one that is sure, which leaves much more: a person sees both in the report."""
    ranking = [
        {
            "effect": "creep",
            "form": "a",
            "heldout_error": 0.4,
            "drop": 1.0,
            "se": 0.1,
            "probability": 0.0,
            "parameters": {},
        }
    ]
    verdict = Verdict("identified", sure, 0.8) if sure else Verdict("confounded", (), 0.8, rivals=("drift",))
    found = nearly_explained(verdict, ranking, 7.0, 3.5, 0.3, drop, "kPa")  # type: ignore[arg-type]
    expected = (
        "the formula of creep alone would take the error from 7 kPa to 0.4 kPa, and what was named to 3.5 kPa; "
        "evidence does not say that it is there, so it is not added: if you know that it is, labrig improve --add creep"
    )
    assert found == ([expected] if said else [])
