"""compare and improve: a model as it stands, and a model with what it lacked."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.diagnosis import compare, diagnose, improve, versus
from labrig.log import write_dataset
from labrig.model import Model

LONG_S = (3.0, 4.0, 6.0, 10.0, 20.0, 40.0)


@pytest.fixture
def leaking(make_lab, monkeypatch: pytest.MonkeyPatch):
    """A laboratory whose chambers leak through an orifice, and what it measured."""
    lab = make_lab(captures=40, long_s=LONG_S)
    monkeypatch.chdir(lab.folder)
    u = np.maximum(np.sqrt(lab.u) - 0.03 * lab.hold_s[:, :, None], 0.0) ** 2
    return lab, lab.dataset(lab.predict(u) + lab.noise())


def test_compare_measures_without_fitting(leaking) -> None:
    """The error of the model as it stands, the floor, and where; the same figures as a hand would find."""
    lab, data = leaking
    summary = compare(data, lab.model()).summary
    assert set(summary) == {"units", "error", "error_by_unit", "where", "floor", "warnings", "runs", "model"}
    assert set(summary["error"]) == {"model", "floor"}
    left = data["position_mm"].values.reshape(40, -1, 18) - lab.predict(lab.u)
    means = np.nanmean(left, axis=1)
    by_hand = np.sqrt(np.mean(means**2) + np.nanmean((left - means[:, None]) ** 2))
    assert summary["error"]["model"] == pytest.approx(by_hand, rel=0.05)
    assert summary["error"]["floor"] == pytest.approx(0.11, rel=0.4)


@pytest.mark.parametrize("captures", [1, 2])
@pytest.mark.parametrize("noisy", [True, False])
def test_of_one_or_two_captures_the_whole_error_counts(make_lab, captures: int, noisy: bool) -> None:
    """A model that is off by 10 mm all along one hold, or two, is off by 10 mm, whatever the noise within them."""
    lab = make_lab(captures=captures, repeats=False)
    runs = lab.dataset(lab.predict(lab.u) + 10.0 + (lab.noise() if noisy else 0.0))
    assert compare(runs, lab.model()).summary["error"]["model"] == pytest.approx(10.0, abs=0.5)
    lab.model()
    off, lab.folder, lab.rest = lab.folder / "model.yaml", lab.folder / "right", lab.rest + 10.0
    lab.folder.mkdir()
    errors = versus(runs, Model.load(off), lab.model()).summary["error"]
    assert max(errors.values()) == pytest.approx(10.0, abs=0.5)
    assert min(errors.values()) < 0.5


def test_a_fit_to_two_captures_says_that_its_errors_are_within_holds(make_lab) -> None:
    """Where an effect is fitted to two captures, their means are in no error, and a warning says so."""
    lab = make_lab(captures=2, repeats=False)
    runs = lab.dataset(lab.predict(lab.u) + 10.0 + lab.noise())
    found = improve(runs, lab.model(), ["regulator"], force=True)
    assert any("along the holds alone" in line for line in found.summary["warnings"])


def test_an_effect_is_added(leaking, few_effects) -> None:
    """The model gets exactly one more entry, and its error falls as the diagnosis said."""
    few_effects("leak", "creep", "delay", "drift")
    lab, data = leaking
    model = lab.model()
    said = diagnose(data, model).summary
    result = improve(data, model, ["leak"])
    summary = result.summary
    assert set(summary) == {
        "units",
        "effects",
        "error",
        "error_by_unit",
        "drop",
        "added",
        "where",
        "warnings",
        "runs",
        "model",
    }
    assert summary["effects"] == ["leak"]
    assert summary["error"]["base"] == pytest.approx(said["error"]["base"], rel=1e-6)
    assert summary["error"]["model"] == pytest.approx(said["error"]["model"], rel=0.15)
    assert summary["drop"] > 0.8
    assert result.improved is not None
    assert result.improved.file.base == model.file.base
    assert [e.model_dump(exclude_none=True) for e in result.improved.file.effects] == summary["added"]
    assert [label for label, _ in result.waterfall] == ["base", "+ leak", "floor"]
    fitted = dict(result.improved.file.effects[0].parameters)
    lag = fitted.pop("tau_s")  # found on a grid, and refined
    assert lag.unit == "s"
    assert isinstance(lag.value, float)
    assert isinstance(lag.sd, float)
    assert 0 < lag.sd < lag.value
    assert fitted
    for value in fitted.values():
        assert value.unit == "1"
        assert value.sd is not None
        largest = int(np.argmax(np.abs(value.value)))
        assert 0 < np.ravel(value.sd)[largest] < np.abs(np.ravel(value.value)[largest])


def test_two_effects_are_fitted_together(make_lab) -> None:
    """Each name once, in the order asked for, whatever else is there already."""
    lab = make_lab(captures=40, long_s=LONG_S)
    values = lab.predict(1.1 * lab.u * np.exp(-lab.hold_s / 120.0)[:, :, None]) + lab.noise()
    data = lab.dataset(values)
    both = improve(data, lab.model(), ["regulator", "leak", "regulator"])
    assert [e["name"] for e in both.summary["added"]] == ["regulator", "leak"]
    assert [label for label, _ in both.waterfall] == ["base", "+ regulator", "+ leak", "floor"]
    steps = [value for _, value in both.waterfall]
    assert steps[0] > steps[1] > steps[2]
    assert both.improved is not None
    gain = both.improved.file.effects[0].parameters["gain"].value
    assert np.mean(gain) == pytest.approx(0.1, abs=0.02)
    with pytest.raises(LabrigError) as error:
        improve(data, both.improved, ["leak"])
    assert str(error.value) == "the model has 'leak' already; remove its entry to fit it again"


def test_one_effect_after_the_other(make_lab) -> None:
    """A second improvement builds on the first, and the entries before it stay as they are."""
    lab = make_lab(captures=40, long_s=LONG_S)
    data = lab.dataset(lab.predict(1.1 * lab.u * np.exp(-lab.hold_s / 120.0)[:, :, None]) + lab.noise())
    first = improve(data, lab.model(), ["regulator"]).improved
    assert first is not None
    second = improve(data, first, ["leak"])
    assert second.improved is not None
    assert second.improved.file.effects[0] == first.file.effects[0]
    assert [e.name for e in second.improved.file.effects] == ["regulator", "leak"]
    assert second.summary["error"]["model"] < 0.3


def test_what_does_not_help_is_refused_unless_forced(make_lab) -> None:
    """An effect that noise alone asks for is refused with its figures; forced in, the result says so."""
    lab = make_lab(captures=40)
    data, model = lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()
    with pytest.raises(LabrigError) as error:
        improve(data, model, ["hysteresis"])
    text = str(error.value)
    assert text.startswith("'hysteresis' does not lower the held-out error enough to matter (by ")
    assert text.endswith("; the model is left as it is; --force (force=True) adds it all the same")
    forced = improve(data, model, ["hysteresis"], force=True)
    assert forced.improved is not None
    assert [e.name for e in forced.improved.file.effects] == ["hysteresis"]
    assert forced.summary["warnings"] == [
        "'hysteresis' does not lower the held-out error enough to matter; it was added because of --force"
    ]


def test_what_cannot_act_is_refused(make_lab) -> None:
    """An effect without a form on this run is no candidate, and where to read why is said."""
    lab = make_lab(captures=20, chambers=1, force=True)
    with pytest.raises(LabrigError) as error:
        improve(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model(), ["coupling"])
    assert str(error.value) == "effect 'coupling' can't act on this run; see: labrig effects show coupling"


def test_from_measurements_to_a_better_model_by_commands(make_lab, labrig, few_effects, monkeypatch) -> None:
    """compare, diagnose, improve, compare: files, tables and the same figures, as a person types it."""
    few_effects("marker_slip", "frame", "drift")
    lab = make_lab(chambers=2, captures=40)
    monkeypatch.chdir(lab.folder)
    values = lab.predict(lab.u) + lab.noise()
    values[20:, :, 9:12] += 2.0
    data = lab.dataset(values)
    write_dataset(data, Path("run"), run_yaml={"procedure": "test"})
    lab.model()
    old = Path("model.yaml").read_text()
    code, out, err = labrig("compare", "run", "--model", "model.yaml", "--out", "c")
    assert (code, err) == (0, "")
    assert "where it fails" in out
    assert "old model" not in out
    before = json.loads(Path("c/compare.json").read_text())
    assert set(before) == {"units", "error", "error_by_unit", "where", "floor", "warnings", "runs", "model"}
    code, out, err = labrig("diagnose", "run", "--model", "model.yaml", "--out", "d")
    assert (code, err) == (0, "")
    assert out.startswith("verdict: identified (one effect is missing)\n")
    assert re.search("marker.slip, sure", out)
    assert "to add it: labrig improve run --model model.yaml --add marker_slip -o improved.yaml\n" in out
    assert sorted(p.name for p in Path("d").iterdir()) == ["diagnosis.json", "report.html"]
    words = (
        "improve",
        "run",
        "--model",
        "model.yaml",
        "--add",
        "marker_slip",
        "-o",
        "new.yaml",
        "--out",
        "i",
    )
    code, out, err = labrig(*words)
    assert (code, err) == (0, "")
    assert out.startswith("new model: new.yaml\n")
    assert "where the old model fails" in out
    assert Path("model.yaml").read_text() == old
    new = yaml.safe_load(Path("new.yaml").read_text())
    assert new["base"] == yaml.safe_load(old)["base"]
    assert [e["name"] for e in new["effects"]] == ["marker_slip"]
    code, out, err = labrig("compare", "run", "--model", "new.yaml", "--out", "c2")
    assert (code, err) == (0, "")
    after = json.loads(Path("c2/compare.json").read_text())
    assert after["error"]["model"] < 0.5 * before["error"]["model"]
    assert labrig(*words) == (
        2,
        "",
        "labrig: new.yaml: already exists; choose another name for the new model\n",
    )


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (
            ("diagnose", "run", "--model", "model.yaml", "--tolerance", "0"),
            "--tolerance 0: must be larger than 0",
        ),
        (
            ("improve", "run", "--model", "model.yaml", "--add", "leak", "-o", "no/new.yaml"),
            "no/new.yaml: the folder no does not exist",
        ),
        (
            ("compare", "run", "--model", "none.yaml"),
            "cannot read the model none.yaml: No such file or directory",
        ),
    ],
)
def test_words_that_make_no_sense(make_lab, labrig, monkeypatch, words: tuple, complaint: str) -> None:
    """One line, exit code 2, no folder of results."""
    lab = make_lab(captures=12)
    monkeypatch.chdir(lab.folder)
    write_dataset(lab.dataset(lab.predict(lab.u) + lab.noise()), Path("run"), run_yaml={"procedure": "test"})
    lab.model()
    before = sorted(Path().rglob("*"))
    assert labrig(*words) == (2, "", f"labrig: {complaint}\n")
    assert sorted(Path().rglob("*")) == before


def test_a_run_that_is_not_there(make_lab, labrig, monkeypatch) -> None:
    """The run is named."""
    lab = make_lab(captures=12)
    monkeypatch.chdir(lab.folder)
    lab.model()
    code, out, err = labrig("diagnose", "none", "--model", "model.yaml")
    assert (code, out) == (2, "")
    assert err.startswith("labrig: none")
    assert err.count("\n") == 1


def test_a_chamber_that_loses_a_vacuum_too(make_lab):
    """Where set-points have both signs, a leak is drawn as a share of pressures that are not near ambient."""
    lab = make_lab(chambers=2, bent=0.0, rows_s=(3.0, 10.0, 20.0))
    lab.commanded[:] = (lab.commanded - 50.0).round(-1)
    assert (lab.commanded[:, 1] == 0).any()
    left = lab.u.copy()
    left[:, :, 1] *= np.exp(-lab.hold_s / 60.0)
    data = lab.dataset(lab.predict(left) + lab.noise())
    data["chamber_min"][:] = -50.0
    data["chamber_max"][:] = 50.0
    result = improve(data, lab.model(), ["leak"])
    (signature,) = result.signatures
    assert set(signature.group) == {"c2"}
    assert signature.y_unit == "%"
    assert np.isfinite(signature.measured).all()
    assert -100 < signature.fitted.min() < -20


def test_what_begins_at_a_moment_of_a_run_without_a_date_is_said(make_lab) -> None:
    """Cameras that were moved in the middle: the model has that at one moment, and of which run nobody may know."""
    lab = make_lab(captures=40)
    values = lab.predict(lab.u) + lab.noise()
    values[24:] += np.tile([3.0, -2.0, 4.0], lab.markers)
    run = lab.dataset(values)

    def said(run) -> list[str]:
        return [line for line in improve(run, lab.model(), ["frame"]).summary["warnings"] if "begins" in line]

    (line,) = said(run)
    assert re.match(
        r"frame begins [\d.]+ min after the start of this run, and nothing says when that was: ", line
    )
    assert said(run.assign_attrs(start_s=1.7e9)) == []
