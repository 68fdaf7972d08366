"""A supply that ends and a stop that is met are one function of a single pressure: neither is sure."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import _diagnose, _same, diagnose, forms_of, prepared
from labrig.diagnosis._same import said_of_same, same_as
from labrig.effects import get, is_family, rows_of


def stopped(pressure_kpa: np.ndarray, limit_kpa: float) -> np.ndarray:
    """What acts of a pressure where something stiff is met, which gives way within a kPa: by a logarithm, no kink."""
    return pressure_kpa - np.logaddexp(0.0, 2.0 * (pressure_kpa - limit_kpa)) / 2.0


def test_of_one_function_no_name_is_sure(
    make_lab: Any, few_effects: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A leak that would be sure is a doubt beside what says the same, both are possible, and a line says why."""
    few_effects("leak", "creep", "drift")
    lab = make_lab(captures=24, chambers=1, long_s=(3.0, 10.0, 20.0, 40.0))
    emptied = lab.u / (1 + np.nan_to_num(lab.hold_s)[:, :, None] / 60.0)
    data = lab.dataset(lab.predict(emptied) + lab.noise())
    assert diagnose(data, lab.model()).summary["effects"] == ["leak"]
    both = frozenset({"leak", "creep"})
    monkeypatch.setattr(_diagnose, "same_as", lambda found, names: both if "leak" in names else frozenset())
    said = diagnose(data, lab.model()).summary
    assert (said["verdict"], said["effects"]) == ("confounded", [])
    assert {"leak", "creep"} <= set(said["rivals"])
    assert [n for n in said["warnings"] if n.startswith("formulas of creep and leak say the same of all")]


@pytest.mark.parametrize(("limit_kpa", "same"), [(53.0, True), (25.0, False)])
@pytest.mark.parametrize("seed", range(3))
def test_where_two_formulas_differ_they_are_told_apart(
    make_lab: Any, limit_kpa: float, same: bool, seed: int
) -> None:
    """No supply of the library ends below three quarters of the range: a stop in the lower half is contact's alone."""
    lab = make_lab(captures=50, chambers=1, markers=4, bent=0.0, seed=seed)
    values = lab.predict(stopped(lab.u, limit_kpa)) + lab.noise(0.3, 0.6)
    ready = prepared(rows_of(lab.dataset(values)), lab.model())
    found = {name: forms_of(ready.regression, ready.context, get(name)) for name in ("contact", "regulator")}
    found["regulator"] = [c for c in found["regulator"] if not is_family(c.variant.form)]
    assert same_as(found, ["regulator"]) == ({"contact", "regulator"} if same else frozenset())
    assert not same_as(found, ["contact", "regulator"])


def test_why_none_is_sure_is_said() -> None:
    """One line names what is not told apart; nothing is said of nothing."""
    assert not said_of_same(())
    assert said_of_same({"regulator", "contact"}) == [
        "formulas of contact and regulator say the same of all that was measured: which of them it is these data "
        "cannot tell, and what is known of the rig, or the next experiment, may"
    ]


def test_what_is_the_same_by_values_that_are_not_physical_is_no_rival(
    make_lab: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hose that fills in seconds is a lag of the whole motion: creep says the same with a share above all that an
    elastomer creeps by, so the delay stands.
    """
    lab = make_lab(captures=50, chambers=1, markers=4, bent=0.0, rows_s=(1.5, 3.0, 5.0, 7.0, 9.0, 11.0))
    before = np.concatenate([np.zeros((1, 1)), lab.commanded[:-1]])[:, None]
    filling = lab.u + (before - lab.u) * np.exp(-((lab.hold_s[:, :, None] / 1.7) ** 1.1))
    ready = prepared(rows_of(lab.dataset(lab.predict(filling) + lab.noise(0.3, 0.6))), lab.model())
    found = {name: forms_of(ready.regression, ready.context, get(name)) for name in ("delay", "creep")}
    assert not same_as(found, ["delay"])
    monkeypatch.setattr(_same, "plausible", lambda *_: True)
    assert same_as(found, ["delay"]) == {"delay", "creep"}


def test_a_free_pattern_is_no_rival(make_lab: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """What each sensor may have as it likes can stand for anything: a drift of the sensors stays one, though creep with
    a pattern of its own says the same of a run in which pressures only rise.
    """
    lab = make_lab(captures=30, chambers=1, force=True, repeats=False)
    lab.commanded = np.full((30, 1), 30.0)
    lab.commanded[::2] = 31.0
    warmed = 2.0 * -np.expm1(-np.nan_to_num(lab.time_s) / 150.0)[:, :, None]
    ready = prepared(rows_of(lab.dataset(lab.predict(lab.u) + warmed + lab.noise(0.3, 0.6))), lab.model())
    found = {name: forms_of(ready.regression, ready.context, get(name)) for name in ("drift", "creep")}
    found["creep"] = [c for c in found["creep"] if any(t.kind == "pattern" for t in c.variant.terms)]
    assert found["creep"]
    assert not same_as(found, ["drift"])
    monkeypatch.setattr(_same, "is_bounded", lambda *_: True)
    assert same_as(found, ["drift"]) == {"drift", "creep"}
