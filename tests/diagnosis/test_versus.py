"""Two models on the same run: which is nearer, by how much, and where."""

import json
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig.diagnosis import compare, versus
from labrig.log import write_dataset
from labrig.model import Model

GAIN = (
    '[{name: regulator, form: gain, parameters: {gain: {value: 0.1, sd: 0.01, unit: "1"}}, '
    "fitted_on: {chambers: [c1, c2, c3], low: [0, 0, 0], high: [60, 60, 60]}}]"
)


def second_model(lab, effects: str, name: str = "gained") -> Model:
    """The rig's own model with effects, in a file of its own beside the plain one."""
    lab.model()
    path = lab.folder / f"{name}.yaml"
    path.write_text((lab.folder / "model.yaml").read_text().replace("effects: []", f"effects: {effects}"))
    return Model.load(path)


@pytest.fixture
def gained(make_lab):
    """A rig whose pressures are a tenth above what is commanded, measured; the plain model, and one that knows."""
    lab = make_lab(captures=60)
    data = lab.dataset(lab.predict(1.1 * lab.u) + lab.noise())
    return lab, data, lab.model(), second_model(lab, GAIN)


def test_the_model_that_knows_the_gain_is_nearer(gained) -> None:
    """Its name, the errors that compare finds, their difference, and an interval that leaves zero out."""
    _, data, plain, knows = gained
    summary = versus(data, plain, knows).summary
    assert summary["better"] == "gained"
    for name, model in (("model", plain), ("gained", knows)):
        assert summary["error"][name] == pytest.approx(
            compare(data, model).summary["error"]["model"], rel=0.02
        )
    found = summary["difference"]
    assert found["value"] == pytest.approx(summary["error"]["model"] - summary["error"]["gained"])
    assert 0 < found["low"] < found["value"] < found["high"]
    turned = versus(data, knows, plain).summary
    assert turned["better"] == "gained"
    assert turned["difference"]["value"] == pytest.approx(-found["value"])
    assert turned["difference"]["low"] == pytest.approx(-found["high"])


def test_where_each_is_nearer(make_lab) -> None:
    """One model knows the first chamber, the other the last: each is nearer over its own, and only there."""
    lab = make_lab(captures=80, markers=9)
    u = lab.u * np.array([1.1, 1.0, 1.1])
    data = lab.dataset(lab.predict(u) + lab.noise())
    each = []
    for name, values in (("left", "[0.1, 0, 0]"), ("right", "[0, 0, 0.1]")):
        text = GAIN.replace("form: gain", "form: gain per chamber").replace("value: 0.1", f"value: {values}")
        each.append(second_model(lab, text.replace("sd: 0.01, ", ""), name))
    rows = versus(data, *each).summary["where"]
    regions = {row["name"]: row for row in rows if row["group"] == "region"}
    assert regions["over c1"]["better"] == "left"
    assert regions["over c3"]["better"] == "right"
    assert regions["over c1"]["error"][0] < regions["over c1"]["error"][1]
    assert regions["over c2"]["better"] is None


def test_two_models_that_differ_by_nothing_that_shows(make_lab) -> None:
    """The run cannot tell: the interval holds zero and no name is given."""
    lab = make_lab(captures=40)
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    summary = versus(data, lab.model(), second_model(lab, GAIN.replace("0.1", "0.0002"))).summary
    assert summary["better"] is None
    assert summary["difference"]["low"] < 0 < summary["difference"]["high"]


def test_a_model_is_not_helped_by_values_that_only_it_misses(make_lab) -> None:
    """What one model calls a mistake counts where the other explains it; a true mistake counts for neither."""
    lab = make_lab(captures=60, markers=12)
    values = lab.predict(lab.u) + lab.noise()
    clean = versus(lab.dataset(values), lab.model(), second_model(lab, GAIN)).summary
    values[20, :, 7] += 200.0
    spoilt = versus(lab.dataset(values), lab.model(), second_model(lab, GAIN)).summary
    for name in ("model", "gained"):
        assert spoilt["error"][name] == pytest.approx(clean["error"][name], rel=0.05)
    assert any("were left out of both errors" in line for line in spoilt["warnings"])


def test_models_that_are_one_file_are_refused(gained) -> None:
    """One line says so; models of the same name in two folders go by their paths."""
    lab, data, plain, _ = gained
    with pytest.raises(LabrigError, match="both models are this file; name another for the second"):
        versus(data, plain, lab.model())
    other = lab.folder / "other" / "model.yaml"
    other.parent.mkdir()
    plain.save(other)
    names = [model["name"] for model in versus(data, plain, Model.load(other)).summary["models"]]
    assert [Path(name).parent.name for name in names] == [lab.folder.name, "other"]


def test_what_makes_it_unfair_is_said(make_lab) -> None:
    """A map that is fitted to the run itself, and effects that may have been."""
    lab = make_lab(captures=30)
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    path = lab.folder / "map.yaml"
    path.write_text("base: {kind: static, degree: 1}\neffects: []\n")
    warnings = versus(data, Model.load(path), second_model(lab, GAIN)).summary["warnings"]
    assert warnings[0].startswith("the base of “map” is fitted to this run")
    assert warnings[1].startswith("if the effects of “gained” were fitted to this run")
    alone = [w for w in compare(data, Model.load(path)).summary["warnings"] if "fitted to this run anew" in w]
    assert len(alone) == 1
    assert not [w for w in compare(data, lab.model()).summary["warnings"] if "fitted to this run" in w]


@pytest.mark.parametrize(("begun", "said"), [("2026-03-01", True), ("2026-03-03", False)])
def test_effects_that_were_fitted_before_the_run_began_are_fair(make_lab, begun: str, said: bool) -> None:
    """Where the model says that its effects were fitted to runs that had ended, a later run needs no caution."""
    lab = make_lab(captures=30)
    start_s = datetime.fromisoformat(f"{begun}T00:00+00:00").timestamp()
    data = lab.dataset(lab.predict(lab.u) + lab.noise()).assign_attrs(start_s=start_s)
    gained = second_model(lab, GAIN)
    file = gained.file.model_copy(update={"fitted_until": datetime(2026, 3, 2, tzinfo=UTC)})
    warnings = versus(data, lab.model(), replace(gained, file=file)).summary["warnings"]
    assert any("were fitted to this run" in line for line in warnings) is said


def test_the_command(gained, labrig, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both errors and the interval in the terminal, in comparison.json and on one page; a third model is refused."""
    lab, data, _, _ = gained
    monkeypatch.chdir(lab.folder)
    write_dataset(data, Path("run"), run_yaml={"source": "test"})
    code, out, err = labrig("compare", "run", "--model", "model.yaml", "--model", "gained.yaml", "--out", "c")
    assert (code, err) == (0, "")
    assert out.startswith("“gained” is nearer to the measurements than “model”, by ")
    assert "95 % interval" in out
    saved = json.loads(Path("c/comparison.json").read_text(encoding="utf-8"))
    assert saved["better"] == "gained"
    assert saved["difference"]["low"] > 0
    page = Path("c/report.html").read_text(encoding="utf-8")
    for text in (
        "“gained” is nearer",
        "95 % interval",
        "Where each is nearer",
        'data-show="0">model</button>',
    ):
        assert text in page
    code, _, err = labrig("compare", "run", *(f"--model={name}.yaml" for name in "abc"))
    assert (code, err) == (2, "labrig: --model was given 3 times; compare takes one model or two\n")
