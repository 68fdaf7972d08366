"""Textbook laws that other laboratories' rigs have: each is taken for what it is, not for its neighbour."""

import numpy as np
import pytest

from labrig.diagnosis import considered
from labrig.diagnosis._diagnose import _counted
from labrig.diagnosis._verdict import Verdict
from tests.conftest import HIGH_KPA, Lab

NEIGHBOURS = ("regulator", "tension", "stiffening", "contact", "creep")


def evidence(lab: Lab, values: np.ndarray) -> dict[str, float]:
    """What evidence gives to each of these effects, of measured values with an error of three noises in them."""
    size = float(np.sqrt(np.mean((values - lab.predict(lab.u)) ** 2)))
    noise = size / 3 * lab.noise(0.5, 1.0) / 1.05
    model = lab.model()
    others = set(model.library()) - set(NEIGHBOURS)
    found = considered(lab.dataset(values + noise), model, tuple(others))
    return {c.effect: c.by_evidence for c in found}


@pytest.mark.parametrize("width", [0.05, 0.1, 0.2])
def test_a_dead_band_is_the_regulators(make_lab, width: float) -> None:
    """A valve that opens softly, in each chamber at a pressure of its own, and lags by it from there on, is no tension,
    however wide that is.
    """
    lab = make_lab(captures=60)
    opens_kpa = width * HIGH_KPA * np.array([0.9, 1.0, 1.1])
    soft_kpa = opens_kpa / 8
    passed = soft_kpa * np.logaddexp(0, (lab.u - opens_kpa) / soft_kpa)
    found = evidence(lab, lab.predict(passed - soft_kpa * np.log1p(np.exp(-opens_kpa / soft_kpa))))
    assert found["regulator"] > 0.5 > found["tension"]


def test_a_spring_beside_the_body_is_tension(make_lab) -> None:
    """What holds all that moves back, a little more the farther it goes, is no creep, though what has crept by now is
    as large.
    """
    lab = make_lab(captures=60)
    moved = lab.predict(lab.u) - lab.rest
    far = np.abs(moved) / np.abs(moved).max()
    found = evidence(lab, lab.rest + moved / (1.15 + 0.04 * far))
    assert found["tension"] > 0.5 > found["creep"]


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
