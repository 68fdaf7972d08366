"""Sensors that are not connected and chambers that never move: said, and nothing is concluded from them."""

import numpy as np
import pytest

from labrig.diagnosis import compare, diagnose
from labrig.model import Model
from labrig.view._report import report_html
from tests.sensors import model_of_both, two_sensors


def test_a_sensor_that_is_not_connected_is_left_out(make_lab, few_effects) -> None:
    """Zero volts throughout, where the model says that they change, is no effect: what is there is found without it."""
    few_effects("leak", "creep", "delay", "drift", "regulator")
    lab = make_lab(force=True, chambers=2, captures=60, long_s=(3.0, 4.0, 6.0, 10.0, 20.0, 40.0))
    left = (
        np.maximum(np.sqrt(lab.u) - 0.03 * np.nan_to_num(lab.hold_s[:, :, None]), 0.0) ** 2
    )  # by an orifice
    values = lab.predict(left) + lab.noise()
    data = two_sensors(lab, values, 0.0)
    found = diagnose(data, model_of_both(lab))
    alone = diagnose(lab.dataset(values), lab.model())
    assert found.summary["effects"] == alone.summary["effects"] == ["leak"]
    assert found.summary["error"]["model"] == pytest.approx(alone.summary["error"]["model"], rel=0.02)
    assert found.summary["units"] == "N"
    assert (
        "voltage is 0 V all the time, where the model says that it changes: it is left out; is its sensor connected?"
        in found.summary["warnings"]
    )
    assert "<html" in report_html(found)


def test_a_sensor_that_stands_still_beside_a_fitted_map_is_left_out(make_lab, tmp_path) -> None:
    """A map that is fitted to it says that it does not change, and no model is needed to see that it is dead."""
    lab = make_lab(force=True, chambers=2, captures=60)
    data = two_sensors(lab, lab.predict(lab.u) + lab.noise(), 1.2)
    (tmp_path / "fitted.yaml").write_text("base: {kind: static, degree: 2}\n")
    said = compare(data, Model.load(tmp_path / "fitted.yaml")).summary
    assert "voltage is 1.2 V all the time: it is left out; is its sensor connected?" in said["warnings"]


def test_what_never_changes_and_need_not_is_kept(make_lab) -> None:
    """A coordinate that stays where the model says that it stays is no broken sensor."""
    lab = make_lab()
    lab.reach[1::3] = 0.0
    values = lab.predict(lab.u) + lab.noise()
    values[..., 1::3] = lab.rest[1::3]
    assert not [
        w for w in compare(lab.dataset(values), lab.model()).summary["warnings"] if "all the time" in w
    ]


def test_a_chamber_that_never_moves_is_named(make_lab) -> None:
    """Nothing can be learnt of a chamber whose set-point is the same in every capture."""
    lab = make_lab()
    lab.commanded[:, 1] = 12.0
    warnings = compare(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()).summary["warnings"]
    assert "chamber c2 is at 12 kPa all the time: nothing can be said of it" in warnings


def test_chambers_that_only_move_together_are_named(make_lab) -> None:
    """Chambers whose set-points only change together are said, once for each group, and no others."""
    lab = make_lab(chambers=4)
    lab.commanded[:, 1] = lab.commanded[:, 0] * 0.8
    together = compare(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()).summary["warnings"]
    assert [w for w in together if "together" in w] == [
        "chambers c1 and c2 only moved together: what is missing of one may be another's, and where they are apart "
        "the model may be off by more than these errors say; move each alone in some set-points"
    ]
    lab.commanded[::3, 1] = 0.0
    apart = compare(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()).summary["warnings"]
    assert not any("together" in w for w in apart)
