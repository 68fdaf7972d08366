"""Textbook laws that other laboratories' rigs have: each is taken for what it is, not for its neighbour."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import labrig
from labrig.diagnosis import considered
from labrig.diagnosis._diagnose import _counted
from labrig.diagnosis._verdict import Verdict
from tests.conftest import HIGH_KPA, Lab

NEIGHBOURS = ("regulator", "tension", "stiffening", "contact", "creep")


def evidence(lab: Lab, values: np.ndarray, named: tuple[str, ...] = NEIGHBOURS) -> dict[str, float]:
    """What evidence gives to each of these effects, of measured values with an error of three noises in them."""
    size = float(np.sqrt(np.mean((values - lab.predict(lab.u)) ** 2)))
    noise = size / 3 * lab.noise(0.5, 1.0) / 1.05
    model = lab.model()
    others = set(model.library()) - set(named)
    found = considered(lab.dataset(values + noise), model, tuple(others))
    return {c.effect: c.by_evidence for c in found}


def test_a_dead_band_is_the_regulators(make_lab) -> None:
    """A valve that opens softly, in each chamber at a pressure of its own, and lags by it from there on: no tension."""
    lab = make_lab(captures=60)
    opens_kpa = 0.1 * HIGH_KPA * np.array([0.9, 1.0, 1.1])
    soft_kpa = opens_kpa / 8
    passed = soft_kpa * np.logaddexp(0, (lab.u - opens_kpa) / soft_kpa)
    found = evidence(lab, lab.predict(passed - soft_kpa * np.log1p(np.exp(-opens_kpa / soft_kpa))))
    assert found["regulator"] > 0.75
    assert found["tension"] < 0.6


def test_a_spring_beside_the_body_is_tension(make_lab) -> None:
    """What holds all that moves back, a little more the farther it goes, is no creep, though what has crept by now is
    as large.
    """
    lab = make_lab(captures=60)
    moved = lab.predict(lab.u) - lab.rest
    far = np.abs(moved) / np.abs(moved).max()
    found = evidence(lab, lab.rest + moved / (1.15 + 0.04 * far))
    assert found["tension"] > 0.5 > found["creep"]


def test_a_loop_that_fades_as_the_chamber_moves_on_is_hysteresis(make_lab) -> None:
    """A wide loop after Bouc and Wen, which turns on as much as the whole range, is no creep: while nothing moves it
    stays as it is.
    """
    lab = make_lab(chambers=2, captures=60, force=True, rows_s=(3.0, 4.0, 5.0), long_s=(3.0, 10.0, 60.0))
    found = evidence(lab, lab.predict(lab.looped(10.0, 1.0)), ("hysteresis", "creep", "regulator", "tension"))
    assert found["hysteresis"] > 0.5 > found["creep"]


def test_a_supply_that_sags_is_coupling(make_lab) -> None:
    """Of what all chambers ask for together each gets less: the others matter, so no wall is stiffer."""
    lab = make_lab(captures=60)
    asked = lab.u.sum(axis=-1, keepdims=True) / (3 * HIGH_KPA)
    found = evidence(lab, lab.predict(lab.u / (1 + 0.15 * asked)), ("coupling", "stiffening", "contact"))
    assert found["coupling"] > 0.5 > found["stiffening"]


def test_a_supply_that_ends_below_the_top_may_be_the_regulators(make_lab) -> None:
    """What is lost above a pressure is the supply's as well as an obstacle's: either, and no more is said."""
    lab = make_lab(captures=60)
    reaches_kpa, soft_kpa = 0.8 * HIGH_KPA * np.array([0.99, 1.0, 1.01]), 0.5
    short = soft_kpa * np.logaddexp(0, (lab.u - reaches_kpa) / soft_kpa)
    found = evidence(lab, lab.predict(lab.u - short), ("regulator", "contact", "stiffening"))
    assert found["regulator"] > 0.1


def test_a_shifted_camera_before_an_even_body_is_no_gravity_surely(make_lab) -> None:
    """A body that gives way alike everywhere sags as one: as much as by a camera that was shifted, and by no more. The
    camera, 2 m away, was turned a little as it was shifted.
    """
    lab = make_lab(chambers=4, markers=10, captures=60, bent=0.0)
    places = lab.predict(lab.u).reshape(*lab.u.shape[:2], -1, 3)
    away = np.array([300.0, -200.0, 2000.0])
    turn = Rotation.from_rotvec(np.cross(away, [1.0, 0.5, -0.3]) / (away @ away))
    seen = places + turn.apply((places - away).reshape(-1, 3)).reshape(places.shape) - (places - away)
    found = evidence(lab, seen.reshape(*lab.u.shape[:2], -1), ("frame", "gravity", "rest_shape", "contact"))
    assert found["frame"] > 0.25
    assert found["gravity"] < 0.75


def test_a_load_that_was_another_in_each_session_is_gravity(make_lab) -> None:
    """A weight at the tip bends a body as its pressures do, with an arm that shortens as it bends: what steps with the
    session steps with what was logged.
    """
    lab = make_lab(captures=60, sessions=3)
    tilt_deg = np.array([0.0, 12.0, 0.0])[lab.session]
    pull = np.sin(np.deg2rad(tilt_deg)) / 0.2
    arm = np.cos(0.6 * lab.u.mean(axis=-1, keepdims=True) / HIGH_KPA)
    values = lab.predict(lab.u - 2.0 * pull[:, None, None] * arm * [1.0, 0.6, 0.8])
    size = float(np.sqrt(np.mean((values - lab.predict(lab.u)) ** 2)))
    data = lab.dataset(values + size / 3 * lab.noise(0.5, 1.0) / 1.05, {"tilt": ("deg", tilt_deg)})
    model = lab.model()
    others = set(model.library()) - {"gravity", "drift", "regulator", "tension"}
    found = {c.effect: c.by_evidence for c in considered(data, model, tuple(others))}
    assert found["gravity"] > 0.5 > found["drift"]


def test_a_spring_with_a_preload_may_be_tension(make_lab) -> None:
    """A band along the body, tight already at rest, that stiffens as it is drawn: not surely the regulator's."""
    lab = make_lab(captures=60)
    moved = lab.u / HIGH_KPA * 1.8 / (1 + 0.8 * lab.u / HIGH_KPA)
    found = evidence(
        lab,
        lab.predict(lab.u - 1.5 - 3.0 * moved * np.sqrt(1 + 0.3 * moved)),
        ("tension", "regulator", "stiffening"),
    )
    assert found["tension"] > 0.5


def test_a_zero_that_drifts_in_the_one_force_is_drift(tmp_path: Path, few_effects) -> None:
    """A load cell beside eight markers that warms up, and nothing moves: no creep of the body, and errors are quoted
    of the force.
    """
    few_effects("drift", "creep", "regulator", "frame", "leak", "hysteresis")
    random = np.random.default_rng(6)
    u = np.repeat(np.vstack([random.uniform(0, 60, (50, 2)).round(1)]), 3, axis=0)
    time_s = np.repeat(6.0 * np.arange(50), 3) + np.tile([2.0, 3.0, 4.0], 50)
    share = np.arange(1, 9) / 8

    def finger(u: np.ndarray) -> np.ndarray:
        turn = 0.012 * u[:, :1] + 0.006 * u[:, 1:] + 1e-9
        x, z = (
            90 * share * (1 - np.cos(turn * share)) / (turn * share),
            90 * share * np.sin(turn * share) / (turn * share),
        )
        places = np.stack([x, 0.05 * u[:, 1:] * share, z], axis=2).reshape(len(u), -1)
        return np.column_stack([places, 0.03 * u.sum(axis=1)])

    seen = finger(u) + random.normal(0, [0.1] * 24 + [0.02], (len(u), 25))
    seen[:, -1] += 0.25 * (1 - 1 / (1 + time_s / 90.0))
    names = [f"m{m}_{a} (mm)" for m in range(8) for a in "xyz"] + ["tip force (N)"]
    table = pd.DataFrame(
        np.column_stack([time_s, u, seen]), columns=["t (s)", "p1 set (kPa)", "p2 set (kPa)", *names]
    )
    run = labrig.import_table(table, tmp_path / "run")
    found = labrig.diagnose(run, finger).summary
    assert (found["verdict"], found["effects"]) == ("identified", ["drift"])
    assert found["units"] == "N"
    assert found["error"]["model"] < 0.5 * found["error"]["base"]


def test_what_is_logged_counts_by_its_changes(make_lab) -> None:
    """22 degrees that hardly change are no constant motion of the body; what is nothing at times makes nothing then."""
    from labrig.diagnosis import prepared, rows_from
    from labrig.diagnosis._unnamed import unnamed

    lab = make_lab(captures=20)
    for name, values, mean in (
        ("crate", np.repeat([0.0, 2.0], 10), 0.5),
        ("room", np.linspace(20, 24, 20), 0.0),
    ):
        data = lab.dataset(lab.predict(lab.u), {name: ("1", values)})
        context = prepared(rows_from(data), lab.model()).context
        (space,) = (s for s in unnamed(context) if s.key == f"{name}, as one body")
        (held,) = (f for f in space.features if f.name == "held")
        assert held.values.mean() == pytest.approx(mean, abs=1e-9)


def test_of_a_doubtful_nothing_no_record_is_quoted() -> None:
    """How often "nothing is missing" was right was counted of verdicts that were surer."""
    doubtful, sure = (_counted(Verdict("nothing_missing", (), p)) for p in (0.53, 0.86))
    assert doubtful is None
    assert sure is not None
    assert _counted(Verdict("unknown", (), 0.53)) is not None


@pytest.mark.parametrize("law", ["supply", "loop"])
def test_the_formula_of_a_textbook_law_holds_on_another_programme(make_lab, law: str) -> None:
    """A supply that ends softly at four fifths, and a wide loop after Bouc and Wen: most of the error goes by a formula
    of its own, and the supply's end is found.
    """
    from labrig.diagnosis import improve
    from labrig.effects import rows_of

    name = {"supply": "regulator", "loop": "hysteresis"}[law]

    def measured(lab: Lab) -> np.ndarray:
        if law == "loop":
            return lab.predict(lab.looped(10.0, 1.0))
        soft_kpa, reaches_kpa = 0.5, 0.8 * HIGH_KPA
        return lab.predict(lab.u - soft_kpa * np.logaddexp(0, (lab.u - reaches_kpa) / soft_kpa))

    lab = make_lab(captures=60, seed=1)
    model = lab.model()
    better = improve(lab.dataset(measured(lab) + lab.noise()), model, [name]).improved
    assert better is not None
    (entry,) = better.file.effects
    assert entry.form == {"supply": "supply ends", "loop": "fading"}[law]
    if law == "supply":
        assert entry.parameters["top"].value == pytest.approx(0.8, abs=0.03)
    fresh = make_lab(captures=40, seed=2)
    rows = rows_of(fresh.dataset(measured(fresh)))
    left, before = (float(np.sqrt(np.mean(each.context(rows).residual ** 2))) for each in (better, model))
    assert left < 0.35 * before
