"""A syringe that drives a body: what leaks is gone for good, until the volume is opened at zero."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import diagnose
from labrig.effects import rows_of
from labrig.effects._registry import shipped
from tests.effects.test_family import context_of

EVERY = 9
"""Set-points after which the syringe goes back to zero, where its valve is opened."""


def driven(lab: Any) -> Any:
    """The laboratory with a syringe in place of its valves: it goes back to zero now and then."""
    lab.commanded[::EVERY] = 0.0
    return lab


def in_ml(data: Any) -> Any:
    """The campaign with its set-points in ml."""
    for name in ("commanded", "event_commanded"):
        data[name].attrs["units"] = "ml"
    return data


def leaking(lab: Any, per_s: float = 2.4e-3, opened: bool = True) -> np.ndarray:
    """Volumes that are left (n, T, C): they escape by the root of the pressure, which grows with the square of the
    volume (turbulent flow through a seam); at zero the valve is opened.
    """
    left, gone, last_s = lab.u.astype(float), np.zeros(lab.chambers), 0.0
    volume = np.zeros(lab.chambers)
    for i, wanted in enumerate(lab.commanded):
        for now_s in np.linspace(last_s, lab.event_s[i], 20)[1:]:
            gone += (
                per_s * np.sqrt(np.maximum(volume - gone, 0.0) ** 2 + 1.0) * (now_s - last_s) * (volume > 0)
            )
            last_s = now_s
        volume = wanted
        if opened and not wanted.any():
            gone = np.zeros(lab.chambers)
        for t, now_s in enumerate(lab.time_s[i]):
            if np.isfinite(now_s):
                gone = gone + per_s * np.maximum(volume - gone, 0.0) * (now_s - last_s)
                last_s, left[i, t] = now_s, volume - gone
    return left


def test_what_leaks_out_of_a_syringe_has_a_name(make_lab, few_effects) -> None:
    """A leak of a closed volume is one, surely, by a formula that takes the error of another programme away."""
    few_effects("leak", "creep", "drift", "coupling", "stiffening", "regulator", "hysteresis", "rest_shape")
    lab = driven(make_lab(force=True, captures=80))
    result = diagnose(in_ml(lab.dataset(lab.predict(leaking(lab)) + lab.noise())), lab.model())
    assert result.summary["effects"] == ["leak"]
    assert result.improved is not None
    (entry,) = result.improved.file.effects
    assert entry.form == "closed volume, opened at zero"
    fresh = driven(replace(lab, seed=7))
    rows = rows_of(in_ml(fresh.dataset(fresh.predict(leaking(fresh)))))
    before, after = (
        np.sqrt(np.mean((model.context(rows).base - rows.values) ** 2))
        for model in (lab.model(), result.improved)
    )
    assert after < 0.3 * before


@pytest.mark.parametrize("unit", ["kPa", "ml"])
def test_only_a_volume_is_closed(make_lab, unit: str) -> None:
    """Where pressures are commanded a valve fills up what has gone: no form of a leak goes on from hold to hold."""
    lab = driven(make_lab(force=True))
    context = context_of(lab)
    context = replace(context, rows=replace(context.rows, actuation_unit=unit))
    leak = shipped()["leak"]
    forms = {v.form for v in leak.variants(context)} | {s.key for s in leak.family(context)}
    assert bool({"closed volume", "closed volume, opened at zero", "gone for good"} <= forms) is (
        unit == "ml"
    )
    assert any(form.startswith(("closed", "gone")) for form in forms) is (unit == "ml")
