"""Several markers that slipped in one run, each by itself, are all in the formula."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import diagnose
from labrig.effects import rows_of
from labrig.effects._registry import shipped
from labrig.model import base_context, build_base, evaluate, read_model_file, write_model_file
from labrig.view._values import values_words

FIRST, SECOND = np.array([1.2, -1.0, 1.2]), np.array([-0.8, 0.6, 0.5])


@pytest.fixture
def lab(make_lab) -> Any:
    """A rig of two chambers."""
    return make_lab(chambers=2)


def slipped(lab: Any, values: np.ndarray, first: int, second: int) -> np.ndarray:
    """Marker 3 creeps away over three captures, marker 1 at once but for a tenth, which its glue gives later."""
    capture = np.arange(len(values))[:, None, None]
    values[:, :, 9:12] += np.clip((capture - first + 3) / 3, 0, 1) * FIRST
    values[:, :, 3:6] += (1 - 0.1 * np.exp(-(capture - second) / 2.0)) * (capture >= second) * SECOND
    return values


def test_both_of_two_markers_are_said(lab: Any, tmp_path, few_effects) -> None:
    """Each has its own way and moment, in the model file, too, and in words by their names."""
    few_effects("marker_slip", "frame", "rest_shape", "drift")
    data = lab.dataset(slipped(lab, lab.predict(lab.u), 24, 33) + lab.noise())
    result = diagnose(data, lab.model())
    assert result.summary["effects"] == ["marker_slip"]
    assert result.improved is not None
    write_model_file(result.improved.file, tmp_path / "model.yaml")
    entry = read_model_file(tmp_path / "model.yaml").effects[-1]
    got = entry.parameters
    assert entry.form == "two steps"
    assert [got["marker"].per, got["marker_2"].per] == [["m3"], ["m1"]]
    for name, capture in (("since_s", 24), ("since_2_s", 33)):
        assert (
            abs(float(np.asarray(got[name].value)) - lab.time_s[capture, 0]) <= 3 * np.diff(lab.event_s).max()
        )
    assert got["slip"].per == [f"{m}.{a}" for m in ("m3", "m1") for a in "xyz"]
    assert got["slip"].value == pytest.approx([*FIRST, *SECOND], abs=0.15)
    words = values_words({name: value.model_dump(exclude_none=True) for name, value in got.items()})
    assert "marker m3, since " in words
    assert "marker m1, since " in words
    model, rows = lab.model(), rows_of(data)
    context = base_context(build_base(model.file, model.folder, rows), rows)
    moved = evaluate(context, shipped()["marker_slip"], entry)
    assert moved[-1, 9:12] == pytest.approx(FIRST, abs=0.15)
    assert moved[-1, 3:6] == pytest.approx(SECOND, abs=0.15)
    assert not moved[0].any()
    assert result.summary["error"]["model"] < 1.2 * result.summary["error"]["floor"]


def test_one_marker_stays_one(lab: Any, few_effects) -> None:
    """Where one has slipped no second one is made up."""
    few_effects("marker_slip", "frame", "rest_shape", "drift")
    values = lab.predict(lab.u)
    values[24:, :, 9:12] += FIRST
    result = diagnose(lab.dataset(values + lab.noise()), lab.model())
    assert result.improved is not None
    assert result.improved.file.effects[-1].form == "step"
