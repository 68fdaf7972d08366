"""Observables of which nobody has said the unit."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import diagnose
from labrig.model import Model

SAID = (
    "the unit of force is not known: where it is a length or an angle, say it in the mapping, since what stops a place "
    "or a joint is looked for among these alone"
)


@pytest.mark.parametrize(("unit", "said"), [("1", [SAID]), ("mm", [])])
def test_a_unit_that_nobody_said_is_asked_for(make_lab: Any, unit: str, said: list[str]) -> None:
    """Where something is missing; of what is a length nothing is asked."""
    lab = make_lab(force=True, captures=40)
    run = lab.dataset(lab.predict(lab.looped(6.0)) + lab.noise()).assign_coords(unit=("observable", [unit]))
    warnings = diagnose(run, lab.model()).summary["warnings"]
    assert [line for line in warnings if line.startswith("the unit of")] == said


def test_a_quaternion_has_none(make_lab: Any) -> None:
    """Four parts whose squares are one together are how a tracker is turned, and in no unit."""
    lab = make_lab(force=True, captures=40)
    run = lab.dataset(lab.predict(lab.looped(6.0)) + lab.noise())
    angle = run["observed"].values[..., 0] / 400.0
    axis = np.array([0.36, 0.48, 0.8])
    parts = np.concatenate([np.cos(angle)[..., None], np.sin(angle)[..., None] * axis], axis=2)
    names = ["force", "q0", "qx", "qy", "qz"]
    empty = ("observable", [""] * 5)
    turned = run.drop_vars(["observed", "observable", "unit", "marker_of", "axis_of"]).assign(
        observed=(("capture", "time", "observable"), np.concatenate([run["observed"].values, parts], axis=2))
    )
    turned = turned.assign_coords(
        observable=names, unit=("observable", ["N", *"1111"]), marker_of=empty, axis_of=empty
    )
    (lab.folder / "model.yaml").write_text("base: {kind: static, degree: 2}\n", encoding="utf-8")
    summary = diagnose(turned, Model.load(lab.folder / "model.yaml")).summary
    assert summary["verdict"] != "nothing_missing"
    assert not [line for line in summary["warnings"] if line.startswith("the unit of")]
