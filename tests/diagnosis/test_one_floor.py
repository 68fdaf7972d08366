"""One floor for all commands: the noise that a diagnosis takes is the one that a comparison quotes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labrig.diagnosis import compare, diagnose, versus


@pytest.mark.parametrize(
    "settings", [{"force": True, "chambers": 1}, {"markers": 6, "chambers": 2}], ids=["force", "markers"]
)
def test_a_comparison_quotes_the_floor_of_the_diagnosis(make_lab, settings: dict) -> None:
    """Beside a loop of some floors, without repeats, a model is not said to be as good as the measurements."""
    lab = make_lab(captures=60, rows_s=(6.0,), repeats=False, seed=2, **settings)
    behind = np.concatenate([np.zeros((1, lab.chambers)), lab.commanded[:-1]])[:, None]
    values = lab.predict(lab.u + 0.12 * (behind - lab.u)) + lab.noise()
    run, model = lab.dataset(values), lab.model()
    said = diagnose(run, model).summary
    diagnosed = said["error"]["floor"]
    found = compare(run, model).summary
    assert found["error"]["floor"] == pytest.approx(diagnosed, rel=0.02)
    assert found["error"]["model"] > 1.5 * diagnosed
    estimated = "no repeats with the same history: the noise floor is an estimate, repeat some set-points"
    assert estimated in found["warnings"]
    assert estimated in said["warnings"]
    other = replace(lab.model(), path=Path("other.yaml"))
    both = versus(run, model, other)
    assert both.summary["error"]["floor"] == pytest.approx(diagnosed, rel=0.02)
