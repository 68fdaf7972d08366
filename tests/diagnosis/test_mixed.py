"""Markers with a few sensors of other kinds beside them: each unit has noise of its own, and a say of its own."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.diagnosis import observe, prepared, rows_from
from labrig.diagnosis._design import design_of
from labrig.diagnosis._diagnose import laid_out, verdict_on
from labrig.diagnosis._directions import directions
from labrig.diagnosis._noise_scale import noise_of_few, of_few
from labrig.diagnosis._verdict import Verdict
from tests.laws import orifice, power_law
from tests.sensors import beside_markers

LONGER = (1.0, 3.0, 8.0)
FORCE, VOLTAGE = 0.1, 0.01


def said(data, model) -> Verdict:
    """The verdict on a campaign."""
    effects = model.library()
    return verdict_on(*laid_out(prepared(rows_from(data), model), effects), effects)


def test_sensors_beside_markers_raise_no_alarm(make_lab) -> None:
    """Five repeats say the noise of a single force badly: what little they say is no effect."""
    lab = make_lab(chambers=2, captures=60, rows_s=LONGER, seed=1)
    assert said(*beside_markers(lab, lab.predict(lab.u) + lab.noise(), lab.u)).verdict == "nothing_missing"


@pytest.mark.parametrize("seen_by", ["markers", "sensors"])
def test_an_effect_has_its_name_whoever_sees_it(make_lab, seen_by: str) -> None:
    """Creep by a power law is creep where only the markers, or only the sensors follow it."""
    lab = make_lab(chambers=2, captures=45, rows_s=LONGER)
    u = power_law(lab)
    positions = lab.predict(lab.u if seen_by == "sensors" else u) + lab.noise()
    assert said(*beside_markers(lab, positions, lab.u if seen_by == "markers" else u)).effects == ("creep",)


def test_the_noise_of_each_unit_comes_back(make_lab) -> None:
    """Whatever repeats said of two lone sensors beside a leak; markers keep theirs."""
    lab = make_lab(chambers=2, captures=100, rows_s=LONGER)
    u = orifice(lab)
    data, model = beside_markers(lab, lab.predict(u) + lab.noise(), u)
    ready = prepared(rows_from(data), model)
    K = ready.residual.shape[1] - 2
    for wrong in (0.5, 2.0):
        mean, within = ready.floor.mean.copy(), ready.floor.within.copy()
        mean[K:] = (
            wrong * np.hypot(FORCE, FORCE / np.sqrt(3)),
            wrong * np.hypot(VOLTAGE, VOLTAGE / np.sqrt(3)),
        )
        few = np.where(np.arange(K + 2) < K, ready.floor.freedom, 1)
        floor = replace(ready.floor, mean=mean, within=within, freedom=few)
        observations = observe(ready.context, ready.residual, floor)
        again = noise_of_few(design_of(observations, model.library()))
        assert np.array_equal(again.mean[:K], floor.mean[:K])
        assert again.mean[K] == pytest.approx(np.hypot(FORCE, FORCE / np.sqrt(3)), rel=0.3)
        assert again.mean[K + 1] == pytest.approx(np.hypot(VOLTAGE, VOLTAGE / np.sqrt(3)), rel=0.3)


def test_noise_that_is_larger_within_holds_counts_as_such(make_lab) -> None:
    """One number says how much smaller noise is within holds; a sensor of which it says too little is trusted less."""
    lab = make_lab(captures=60, rows_s=LONGER)
    data, model = beside_markers(lab, lab.predict(lab.u) + lab.noise(), lab.u)
    ready = prepared(rows_from(data), model)
    K = ready.residual.shape[1] - 2
    mean, within = np.ones(K + 2), np.full(K + 2, 0.5)
    within[K:] = 2.0, 0.1
    observations = observe(ready.context, ready.residual, replace(ready.floor, mean=mean, within=within))
    assert observations.within == 0.5
    assert observations.unit.tolist() == [1.0] * K + [4.0, 1.0]


def test_a_sensor_beside_many_markers_has_a_direction(make_lab) -> None:
    """Of a body's motions the first few dozen are kept, and each sensor's own."""
    lab = make_lab(captures=60, markers=12, rows_s=LONGER)
    data, model = beside_markers(lab, lab.predict(lab.u) + lab.noise(), lab.u)
    ready = prepared(rows_from(data), model)
    observations = observe(ready.context, ready.residual, ready.floor)
    assert [int(np.flatnonzero(own)[0]) for own in of_few(observations)] == [36, 37]
    V, _ = directions(observations, ())
    assert V.shape[1] < 38
    for k in (36, 37):
        assert np.linalg.norm(np.asarray(V, dtype=float)[k]) == pytest.approx(1.0, abs=1e-5)
