"""What follows something that was logged for an effect is that effect: a temperature, drift; a tilt, gravity."""

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._diagnose import laid_out, verdict_on
from labrig.diagnosis._unnamed import unnamed
from labrig.effects import Covariate, get, rows_of
from tests.naming import calls_of

N = 40
COURSE = {
    "up and down": 3.0 * np.sin(np.linspace(0, 4 * np.pi, N)),
    "warmer": np.linspace(-2.0, 2.0, N),
}
"""Kelvin above what the model is right at, by capture."""


@pytest.mark.parametrize("name", COURSE)
def test_what_follows_a_temperature_is_drift(make_lab, name: str) -> None:
    """A zero that moves with the root of the absolute temperature, as a gauge may; there is no other rest shape."""
    lab = make_lab(captures=N, markers=4, repeats=False)
    kelvin = 295.0 + COURSE[name]
    moved = 60.0 * (np.sqrt(kelvin / 295.0) - 1)[:, None, None] * np.cos(np.arange(12))
    read = kelvin + 0.05 * lab.random.normal(size=N)
    values = lab.predict(lab.u) + moved + lab.noise()
    calls = calls_of(lab.dataset(values, {"room": ("K", read)}), lab.model())
    assert calls.pop("drift") == "sure"
    assert "sure" not in calls.values()


def test_what_follows_a_temperature_is_not_asked_without_a_name_as_well(make_lab) -> None:
    """Drift says that a temperature is its own; what follows another thing that was logged stays without a name."""
    lab = make_lab(captures=N, markers=4, repeats=False)
    logged = {
        "room": ("degC", 20.0 + COURSE["warmer"]),
        "humidity": ("percent", 40.0 + COURSE["up and down"]),
    }
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u), logged)))
    assert [*get("drift").follows(context)] == ["room"]
    for followed, names in (((), {"room", "humidity"}), (("room",), {"humidity"})):
        (beside,) = [space for space in unnamed(context, followed) if space.spectrum == "beside"]
        assert {f.name for f in beside.features} & {"room", "humidity"} == names


def test_a_temperature_beside_noise_is_no_drift(make_lab) -> None:
    """That something was logged does not make it act."""
    lab = make_lab(captures=N, markers=4)
    room = ("degC", 22.0 + COURSE["up and down"])
    calls = calls_of(lab.dataset(lab.predict(lab.u) + lab.noise(), {"room": room}), lab.model())
    assert set(calls.values()) == {"not it"}


def test_its_forms_begin_at_the_first_temperature_or_at_the_mean(make_lab) -> None:
    """In degrees Celsius, whatever the unit of the sensor: what the shift is counted from, as the model file has it."""
    lab = make_lab(captures=4, markers=4, repeats=False)
    warm = np.array([293.15, 298.15, 303.15, 298.15])
    rows = rows_of(lab.dataset(lab.predict(lab.u), {"room": ("K", warm)}))
    assert isinstance(rows.covariates["room"], Covariate)
    variants = get("drift").variants(lab.model().context(rows))
    assert {v.shape["reference"] for v in variants if "reference" in v.shape} == {20.0, 25.0}


def test_what_follows_a_tilt_is_gravity(make_lab) -> None:
    """A cantilever's sag by the sine of the tilt, more where it is soft, whatever else the tilt's name says."""
    lab = make_lab(chambers=2, captures=N, markers=6, repeats=False, seed=2)
    tilt_deg = lab.random.choice([-30.0, -15.0, 0.0, 15.0, 30.0], N)
    reach = np.linspace(0.2, 1.0, 6) ** 2 * (3 - np.linspace(0.2, 1.0, 6)) / 2
    sag = np.sin(np.deg2rad(tilt_deg))[:, None, None] * np.repeat(reach, 3) * np.tile([1.2, 0.0, 0.0], 6)
    soft = np.exp(lab.u.mean(axis=2, keepdims=True) / 60.0)  # as rubber does: no polynomial of the pressures
    logged = {"tilt_x": ("rad", np.deg2rad(tilt_deg))}
    data = lab.dataset(lab.predict(lab.u) + sag * soft + lab.noise(), logged)
    calls = calls_of(data, lab.model())
    assert calls.pop("gravity") == "sure"
    assert "sure" not in calls.values()


def test_the_angle_of_a_valve_is_no_tilt(make_lab) -> None:
    """A word that says nothing of how the rig lies does not make gravity of what was logged; an angle alone may."""
    lab = make_lab(captures=N, markers=4, repeats=False)
    names = ("valve angle", "angle", "stage roll", "tilt", "mount tilt", "IMU pitch")
    logged = {name: ("deg", np.arange(N, dtype=float)) for name in names}
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u), logged)))
    assert [*get("gravity").follows(context)] == [*names[1:]]


def test_what_follows_a_tilt_has_no_name_where_gravity_is_left_out(make_lab) -> None:
    """Without the effect that it was logged for, it is something else that was recorded."""
    lab = make_lab(chambers=2, captures=N, markers=6, repeats=False)
    turn = np.sin(np.arange(N) * 0.9)
    moved = 0.8 * turn[:, None, None] * np.cos(5 * np.arange(18))
    run = lab.dataset(lab.predict(lab.u) + moved + lab.noise(), {"tilt": ("rad", turn)})
    effects = {n: e for n, e in lab.model().library().items() if n != "gravity"}
    verdict = verdict_on(*laid_out(prepared(rows_from(run), lab.model()), effects), effects)
    assert (verdict.verdict, verdict.carried_by) == ("unknown", "what was recorded beside")
