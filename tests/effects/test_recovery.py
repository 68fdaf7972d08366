"""Known causes, made with formulas that the library does not have, are sized and signed aright.

What a laboratory (tests/conftest.py) measures is changed by a formula of the test's own; what `improve` fits must
follow what was put in, row by row; and the plot that gives the effect away must show it, with the fitted curve over
what was measured. Of those effects that have no other test of their name the diagnosis must say sure, or possible.
"""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from labrig.diagnosis import Result, diagnose, improve
from labrig.effects import rows_of
from labrig.model import Model, base_context, build_base
from labrig.view import values_words
from labrig.view._signature_figure import binned
from tests.naming import calls_of

LONG_S = (3.0, 4.0, 6.0, 10.0, 20.0, 40.0)


def found(
    lab: Any, values: np.ndarray, name: str, named: bool = False, **extra: Any
) -> tuple[Result, dict[str, Any], dict[str, Any]]:
    """Fit the effect to what the lab measures: it must follow what was put in, and (`named`) be among what is named.

    Returns the result, and the fitted parameters and their standard deviations by name.
    """
    model, data = lab.model(), lab.dataset(values + lab.noise(), **extra)
    calls = calls_of(data, model) if named else {}
    result = improve(data, model, [name])
    summary = result.summary
    assert summary["error"]["model"] < 0.5 * summary["error"]["base"]
    assert result.improved is not None
    true, said = changes(lab.dataset(values, **extra), result.improved, model)
    assert np.sum(true * said) / np.sum(true**2) == pytest.approx(1.0, abs=0.15)
    assert np.corrcoef(true.ravel(), said.ravel())[0, 1] > 0.95
    gives_away(result, name)
    assert not named or calls[name] in {"sure", "possible"}
    entry = result.improved.file.effects[-1].parameters
    fitted = {k: np.asarray(v.value) for k, v in entry.items()}
    sd = {k: np.asarray(v.sd) for k, v in entry.items() if v.sd is not None}
    return result, fitted, sd


def gives_away(result: Result, name: str) -> None:
    """The plot has names on its axes, and its curve goes through the means of what was measured, far from zero."""
    (shown,) = result.signatures
    assert shown.effect == name
    assert min(len(shown.says), len(shown.x_name), len(shown.y_name)) > 0
    assert len(shown.x) == len(shown.measured) == len(shown.fitted) == len(shown.weight) == len(shown.group)
    means = [binned(shown, np.flatnonzero(shown.group == group)) for group in np.unique(shown.group)]
    _, measured, fitted = np.concatenate(means, axis=1)
    assert np.sqrt(np.mean((measured - fitted) ** 2)) < 0.35 * np.sqrt(np.mean(measured**2))


def within(fitted: np.ndarray, true: Any, sd: np.ndarray, share: float = 0.0, size: float = 0.0) -> bool:
    """Whether values are within four standard deviations of the true ones, and a share of those or a size."""
    return bool((np.abs(fitted - true) <= 4 * sd + share * np.abs(true) + size).all())


def changes(clean: xr.Dataset, improved: Model, model: Model) -> tuple[np.ndarray, np.ndarray]:
    """What was put in, and what the improved model says of it, (F, K)."""
    rows = rows_of(clean)
    base = base_context(build_base(model.file, model.folder, rows), rows).base
    return rows.values - base, improved.context(rows).base - base


def test_each_of_two_is_shown_without_the_other(make_lab) -> None:
    """Beside gains that are off, the drift of the frame is seen as it is by itself, and the gains without the drift."""
    lab = make_lab()
    late = lab.time_s / np.nanmax(lab.time_s)
    drift = late[:, :, None] * np.tile([0.8, -0.4, 0.6], 6)
    values = lab.predict(lab.u * [1.1, 1.0, 0.9]) + drift + lab.noise()
    both = improve(lab.dataset(values), lab.model(), ["regulator", "drift"])
    gains, slow = both.signatures
    assert (gains.effect, slow.effect) == ("regulator", "drift")
    size = np.sqrt(np.mean(np.square([0.8, -0.4, 0.6])))
    assert np.polyfit(slow.x / np.nanmax(lab.time_s), slow.measured, 1)[0] == pytest.approx(size, rel=0.1)
    for chamber, gain in (("c1", 0.1), ("c3", -0.1)):
        own = gains.group == chamber
        assert np.polyfit(gains.x[own], gains.measured[own], 1)[0] == pytest.approx(gain, abs=0.03)


def test_regulator(make_lab) -> None:
    """Gains that are off by up to 10 %, up and down, S-shaped: each chamber's comes back."""
    lab = make_lab()
    gain = np.array([0.1, -0.06, 0.05])
    x = lab.u / 60.0
    u = lab.u * (1 + gain) + 0.3 * np.sin(2 * np.pi * x)
    _, values, sd = found(lab, lab.predict(u), "regulator")
    assert within(values["gain"], gain, sd["gain"], 0.2)


def test_hysteresis(make_lab) -> None:
    """A Bouc-Wen loop (Wen 1976): set-points from above lie higher, by an amount that saturates."""
    lab = make_lab(captures=80)
    result, values, _ = found(lab, lab.predict(lab.looped(3.0)), "hysteresis")
    loop = result.signatures[0]
    above, below = (loop.measured[loop.group == way] for way in ("from above", "from below"))
    assert above.mean() > 2.0
    assert below.mean() < -2.0
    half = 60 * values["width"].item() * (np.mean(values["weight"]) + 3 * np.mean(values.get("wide", 0)))
    assert half == pytest.approx(3.0, rel=0.3)


def test_creep(make_lab) -> None:
    """Power-law creep after every step: the response goes on growing, and fades after release."""
    lab = make_lab(chambers=2, captures=60, long_s=LONG_S)
    u = lab.u
    steps = np.diff(lab.commanded, axis=0, prepend=0.0)
    since = np.maximum(lab.time_s[:, :, None] - lab.event_s, 0.0)
    u = u + np.einsum("nte,ec->ntc", 0.04 * (1 + since) ** 0.3 - 0.04, steps)
    result, values, _ = found(lab, lab.predict(u), "creep")
    _, grown, fitted = binned(result.signatures[0], np.arange(len(result.signatures[0].x)))
    assert result.signatures[0].x_name == "time in hold"
    assert (np.diff(grown) > 0).mean() > 0.8
    assert (np.diff(fitted) > 0).all()
    assert (values.get("amplitude", values.get("spectrum")) > 0).all()


def test_leak(make_lab) -> None:
    """Air escapes through an orifice, so that the root of the pressure falls in a straight line."""
    lab = make_lab(long_s=LONG_S)
    u = np.maximum(np.sqrt(lab.u) - 0.03 * lab.hold_s[:, :, None], 0.0) ** 2
    result, _, _ = found(lab, lab.predict(u), "leak")
    shown = result.signatures[0].chambers
    lost = np.nanmean((u - lab.u) * lab.u, axis=(0, 1)) / np.nanmean(lab.u**2, axis=(0, 1))
    assert [share for share, _ in shown.values()] == pytest.approx(lost.tolist(), rel=0.15)


def test_coupling(make_lab) -> None:
    """A chamber gives way to its inflated neighbours, less and less the further they are out."""
    lab = make_lab()
    x = lab.u / 60.0
    near = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]])
    u = lab.u * (1 - 0.12 * np.tanh(2 * x) @ near)
    found(lab, lab.predict(u), "coupling", named=True)


def test_coupling_through_a_wall(make_lab) -> None:
    """Air seeps through holes in the walls between chambers; regulators that droop with the flow make up for a part."""
    lab = make_lab(captures=80)
    hole = np.array([[0.09, -0.09, 0.0], [-0.09, 0.14, -0.05], [0.0, -0.05, 0.05]])
    u = np.linalg.solve(np.eye(3) + hole, lab.u.reshape(-1, 3).T).T.reshape(lab.u.shape)
    result, fitted, _ = found(lab, lab.predict(u), "coupling")
    assert result.improved is not None
    assert result.improved.file.effects[-1].form == "evened out, pairs"
    assert fitted["exchanged_pair"] == pytest.approx([0.09, 0.0, 0.05], abs=0.025)


def test_a_frame_moved_at_one_moment(make_lab) -> None:
    """From the thirtieth capture on all markers are seen turned about a foot beside the rig: when, and how far."""
    lab = make_lab(chambers=2)
    values = lab.predict(lab.u).reshape(*lab.hold_s.shape, -1, 3)
    axis, turn = np.array([0.6, 0.0, 0.8]), 0.02
    arm = values - lab.rest_mm.mean(axis=0)
    along = (arm @ axis)[..., None] * axis
    turned = along + np.cos(turn) * (arm - along) + np.sin(turn) * np.cross(axis, arm) + [0.5, -0.3, 0.4]
    values[30:] += (turned - arm)[30:]
    _, fitted, sd = found(lab, values.reshape(*lab.hold_s.shape, -1), "frame")
    assert abs(fitted["since_s"].item() - lab.time_s[30, 0]) <= np.diff(lab.event_s).max()
    assert within(fitted["shift_since"][:3], np.array([0.5, -0.3, 0.4]), sd["shift_since"][:3], 0.1)
    assert within(fitted["shift_since"][3:], turn * axis, sd["shift_since"][3:], 0.1, 0.001)


def test_stiffening(make_lab) -> None:
    """A wall that stiffens as the exponential of the pressure's square: compliance at full pressure is lost."""
    lab = make_lab(chambers=2)
    x = lab.u / 60.0
    u = lab.u * (1 - 0.1 * np.expm1(0.9 * x**2))
    _, values, _ = found(lab, lab.predict(u), "stiffening", named=True)
    at_full = sum(np.mean(v) for v in values.values())
    assert at_full == pytest.approx(-0.1 * np.expm1(0.9), rel=0.3)


def test_gravity(make_lab) -> None:
    """Payloads in grams pull the markers down, a little less than in proportion."""
    lab = make_lab(chambers=2)
    payload = lab.random.choice([0.0, 50.0, 100.0], lab.captures)
    sag = -2.0 * np.tanh(payload / 120.0)[:, None] * np.linspace(0.5, 1.5, lab.markers)
    values = lab.predict(lab.u)
    values[:, :, 2::3] += sag[:, None]
    _, fitted, _ = found(lab, values, "gravity", named=True, covariates={"payload": ("g", payload)})
    along_z = 0.1 * fitted["payload"].reshape(-1)[2:18:3]
    assert along_z == pytest.approx(-2.0 * np.tanh(100 / 120) * np.linspace(0.5, 1.5, 6), rel=0.2)


def test_drift(make_lab) -> None:
    """The cameras' mount warms up, with a slow wave on it: a shift that is the same for all markers."""
    lab = make_lab(chambers=2)
    t = lab.time_s / np.nanmax(lab.time_s)
    warm = 1 - np.exp(-3 * t) + 0.1 * np.sin(5 * t)
    values = lab.predict(lab.u) + (warm[:, :, None] * np.tile([0.8, -0.4, 0.6], 6))
    found(lab, values, "drift")


def test_contact(make_lab) -> None:
    """The first chamber meets something soft at two thirds of its range, and goes on with a sixth of its way."""
    lab = make_lab(captures=80)
    u = lab.u
    beyond = 2.0 * np.logaddexp(0, (u[:, :, 0] - 40.0) / 2.0)
    u[:, :, 0] -= 0.8 * beyond
    _, values, _ = found(lab, lab.predict(u), "contact")
    assert values["limit"].item() == pytest.approx(2 / 3, abs=0.12)


def test_marker_slip(make_lab) -> None:
    """Marker 3 creeps away over three captures and stays 2 mm off."""
    lab = make_lab(chambers=2)
    values = lab.predict(lab.u)
    gone = np.clip((np.arange(lab.captures) - 28) / 3, 0, 1)
    values[:, :, 9:12] += gone[:, None, None] * np.array([1.2, -1.0, 1.2])
    result, fitted, sd = found(lab, values, "marker_slip")
    steps = result.signatures[0]
    slipped = steps.group == "m3"
    assert np.ptp(steps.measured[slipped]) > 1.7
    assert np.ptp(steps.measured[~slipped]) < 1.2
    assert fitted["marker"].item() == 3
    assert "marker m3" in values_words(result.summary["added"][0]["parameters"])
    assert abs(fitted["since_s"].item() - lab.time_s[30, 0]) <= 3 * np.diff(lab.event_s).max()
    assert within(fitted["slip"], np.array([1.2, -1.0, 1.2]), sd["slip"], 0.1)


def test_marker_slip_among_mistaken_positions(make_lab) -> None:
    """The step is found beside larger mistakes of other markers, the very first capture among them."""
    lab = make_lab(chambers=2)
    values = lab.predict(lab.u)
    values[30:, :, 9:12] += np.array([1.2, -1.0, 1.2])
    for capture, marker in ((0, 5), (3, 5), (12, 1), (33, 2)):
        values[capture, :, 3 * marker : 3 * marker + 3] += 25.0
    result = diagnose(lab.dataset(values + lab.noise()), lab.model())
    assert result.summary["effects"] == ["marker_slip"]
    assert result.improved is not None
    fitted = result.improved.file.effects[-1].parameters
    assert fitted["marker"].value == 3
    assert fitted["slip"].value == pytest.approx([1.2, -1.0, 1.2], abs=0.2)


def test_frame_of_another_scale(make_lab) -> None:
    """A wand that is 2 % too long, about a point far from the markers' centre: frame, with the scale."""
    lab = make_lab(chambers=2)
    q = lab.predict(lab.u).reshape(*lab.hold_s.shape, -1, 3)
    pivot = q.mean(axis=(0, 1, 2)) + np.array([30.0, -20.0, 10.0])
    values = (pivot + 1.02 * (q - pivot)).reshape(*lab.hold_s.shape, -1)
    _, fitted, sd = found(lab, values, "frame")
    assert within(fitted["scale"], 0.02, sd["scale"], 0.05)


def test_frame(make_lab) -> None:
    """A finite rotation by two degrees (Rodrigues) and a shift: both come back, in rad and mm."""
    lab = make_lab(chambers=2)
    axis, angle = np.array([0.6, 0.0, 0.8]), np.radians(2.0)
    S = np.array([[0, -0.8, 0.0], [0.8, 0, -0.6], [0.0, 0.6, 0]])
    R = np.eye(3) + np.sin(angle) * S + (1 - np.cos(angle)) * S @ S
    q = lab.predict(lab.u).reshape(*lab.hold_s.shape, -1, 3)
    middle = lab.rest_mm.mean(axis=0)
    values = ((q - middle) @ R.T + middle + np.array([0.5, -1.0, 0.8])).reshape(*lab.hold_s.shape, -1)
    _, fitted, sd = found(lab, values, "frame")
    true = np.array([0.5, -1.0, 0.8, *angle * axis])
    assert within(fitted["shift"], true, sd["shift"], 0.05)


def test_delay(make_lab) -> None:
    """Two volumes fill one after the other: just after a step some of the old shape is there."""
    lab = make_lab(rows_s=(1.0, 1.5, 2.0, 3.0, 5.0))
    before = np.concatenate([np.zeros((1, 3)), lab.commanded[:-1]])[:, None]
    s = lab.hold_s[:, :, None] / 0.5
    u = lab.u + (before - lab.u) * (1 + s) * np.exp(-s)
    result, _, _ = found(lab, lab.predict(u), "delay")
    shown = result.signatures[0]
    early, late = (np.abs(shown.fitted[own]).mean() for own in (shown.x < 2.0, shown.x > 4.0))
    assert late < 0.2 * early


def test_friction(make_lab) -> None:
    """Dahl's bristles (1968), which slide after a twentieth of the range, hold back against the last motion."""
    lab = make_lab(captures=80)
    u = lab.u
    z = np.zeros(3)
    for i, way in lab.path(40):
        last = lab.commanded[i - 1] if i else np.zeros(3)
        for point in way:
            d = (point - last) / 60.0
            z = z + d / 0.01 * (1 - np.sign(d) * z)
            z = np.clip(z, -1, 1)
            last = point
        u[i] -= 3.0 * z
    _, values, _ = found(lab, lab.predict(u), "friction")
    assert np.mean(values["coulomb"]) == pytest.approx(3.0, rel=0.3)


def test_friction_along_the_path(make_lab) -> None:
    """One sheath rubs on what all chambers bend together: Dahl's bristles as a vector, whoever moves."""
    lab = make_lab(captures=80)
    u, z, last = lab.u, np.zeros(3), np.zeros(3)
    for i, way in lab.path(400):
        for point in way:
            step = (point - last) / 0.6
            z, last = z + step - z * np.linalg.norm(step), point
        u[i] -= 5.0 * z
    result, values, _ = found(lab, lab.predict(u), "friction", named=True)
    assert result.improved is not None
    assert result.improved.file.effects[-1].form == "along the path"
    assert values["coulomb"] == pytest.approx(5.0, rel=0.1)


def test_rest_shape(make_lab) -> None:
    """Every marker was glued somewhere else than drawn, by a millimetre or so."""
    lab = make_lab(chambers=2)
    off = lab.random.normal(0, 1.0, 18)
    _, values, sd = found(lab, lab.predict(lab.u) + off, "rest_shape")
    assert within(values["offset"], off, sd["offset"], size=0.02)


def test_contact_of_one_chamber(make_lab) -> None:
    """A chamber that alone meets an elastic stop is found, by number and name; its neighbours go on."""
    lab = make_lab(captures=80)
    low, high = np.zeros_like(lab.u[..., 1]), lab.u[..., 1].copy()
    for _ in range(50):
        middle = (low + high) / 2
        too_far = middle + 0.35 * np.maximum(middle - 33.0, 0.0) ** 1.5 > lab.u[..., 1]
        low, high = np.where(too_far, low, middle), np.where(too_far, middle, high)
    u = lab.u.copy()
    u[..., 1] = low
    result, values, _ = found(lab, lab.predict(u), "contact")
    assert result.summary["added"][0]["form"] == "one chamber"
    assert (values["chamber"], values["limit"]) == (1.0, pytest.approx(33.0 / 60.0, abs=0.12))
    assert "chamber c2" in values_words(result.summary["added"][0]["parameters"])


def test_regulator_of_a_vented_chamber(make_lab) -> None:
    """An offset that a chamber open to the room does not have is fitted to the held ones alone."""
    lab = make_lab(captures=80)
    lab.commanded[::4, 0] = lab.commanded[1::4, 1] = lab.commanded[2::4, 2] = 0.0
    held = 3.0 * np.tanh(lab.u / 2.0)
    result, values, _ = found(lab, lab.predict(1.03 * lab.u + held), "regulator")
    assert result.summary["added"][0]["form"].endswith("open when vented")
    assert values["offset"] == pytest.approx(3.0, abs=0.7)


def test_tension(make_lab) -> None:
    """A membrane mounted a fifth tighter pushes back with its deflection: the pressure that it takes is missing."""
    lab = make_lab(chambers=2, bent=2.0)
    x = lab.u / 60.0
    low, high = np.zeros_like(x), x.copy()
    for _ in range(50):
        middle = (low + high) / 2
        out = middle * (1 + lab.bent) / (1 + lab.bent * middle)
        too_far = middle + 0.15 * out > x
        low, high = np.where(too_far, low, middle), np.where(too_far, middle, high)
    _, values, _ = found(lab, lab.predict(60 * low), "tension")
    assert next(iter(values.values())) == pytest.approx(-0.15, abs=0.06)
