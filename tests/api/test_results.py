"""What compare, diagnose, improve and propose_experiment give back, as a notebook uses it."""

import json
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.effects._registry import shipped
from labrig.physics import reduced_surface
from tests.rigs import RIG


def test_a_comparison_says_how_far_off_the_model_is_and_where(lab: Path, tmp_path: Path) -> None:
    """The error against the floor, the places as a table, and the files of the command line."""
    found = labrig.compare(labrig.open_run(lab / "first"), labrig.Model.load(lab / "model.yaml"))
    assert found.error["model"] > found.error["floor"] > 0
    assert found.units == "mm"
    assert {"marker", "chamber"} <= set(found.where["group"])
    assert max(found.where["error"].tolist()) > found.error["model"]
    assert found.save(tmp_path / "out") == tmp_path / "out" / "report.html"
    saved = json.loads((tmp_path / "out" / "compare.json").read_text(encoding="utf-8"))
    assert saved["error"]["model"] == pytest.approx(found.error["model"], rel=1e-5)


def test_a_diagnosis_is_read_as_tables(diagnosis: labrig.Diagnosis) -> None:
    """The verdict, every effect with its probability and size, the most probable first."""
    effects = diagnosis.effects
    assert diagnosis.verdict in {"identified", "confounded", "multiple"}
    assert "creep" in set(effects["effect"][:3])
    assert effects["probability"].is_monotonic_decreasing
    assert len(effects) == 15
    assert set(diagnosis.sure) == set(effects["effect"][effects["call"] == "sure"])
    assert 0 <= diagnosis.probability <= 1


def test_what_is_shown_is_short(diagnosis: labrig.Diagnosis) -> None:
    """A repr of a few lines with each name and its probability, and a view for notebooks with the same sentence."""
    text = repr(diagnosis)
    assert text.startswith("Diagnosis: ")
    assert len(text) < 400
    assert diagnosis.headline() in text
    assert "creep" in text.splitlines()[1]
    assert "creep" in diagnosis._repr_html_()
    assert len(diagnosis._repr_html_()) < 10_000


def test_what_to_keep_in_mind_is_shown(diagnosis: labrig.Diagnosis) -> None:
    """Who looks at a result in a notebook sees its warnings, as who reads a terminal does."""
    lines = ["the noise is an estimate", "rows at t < 1 s were left out"]
    result = diagnosis._result
    warned = labrig.Diagnosis(replace(result, summary={**result.summary, "warnings": lines}))
    assert repr(warned).splitlines()[-2:] == [f"note: {line}" for line in lines]
    for line in lines:
        assert f"<li>{escape(line)}</li>" in warned._repr_html_()


def test_every_picture_of_the_report_can_be_drawn(diagnosis: labrig.Diagnosis) -> None:
    """Each by its name, as a figure with data; a name that is none says which there are."""
    assert {"error", "surface", "fit", "captures"} <= set(diagnosis.pictures)
    for picture in diagnosis.pictures:
        assert diagnosis.plot(picture).to_dict()["data"]
    bars = diagnosis.plot().to_dict()["data"][0]
    assert list(bars["y"])[-1] == pytest.approx(diagnosis.error["floor"])
    with pytest.raises(LabrigError) as caught:
        diagnosis.plot("surfaces")
    assert str(caught.value).startswith("there is no picture 'surfaces'; there are error, surface")


def test_an_improvement_lowers_the_error_and_can_be_saved(lab: Path, tmp_path: Path) -> None:
    """From a table to a lower error: the new model predicts the run better than the old one."""
    better = labrig.improve(lab / "first", lab / "model.yaml", "creep")
    assert better.added == ["creep"]
    assert better.error["model"] < better.error["base"]
    assert 0 < better.drop <= 1.05
    better.model.save(tmp_path / "improved.yaml")
    again = labrig.compare(lab / "first", tmp_path / "improved.yaml")
    assert again.error["model"] < labrig.compare(lab / "first", lab / "model.yaml").error["model"]
    assert any("creep" in line for line in better.values)


def test_two_models_are_compared_on_one_run(lab: Path, tmp_path: Path) -> None:
    """Which is nearer and by how much, where as a table, every picture, and one short line for another number."""
    labrig.improve(lab / "first", lab / "model.yaml", "creep").model.save(tmp_path / "improved.yaml")
    both = labrig.compare(lab / "first", [lab / "model.yaml", tmp_path / "improved.yaml"])
    assert isinstance(both, labrig.ModelComparison)
    assert both.models == ["model", "improved"]
    assert both.better == "improved"
    assert 0 < both.interval[0] < both.difference < both.interval[1]
    assert both.difference == pytest.approx(both.error["model"] - both.error["improved"])
    assert {"marker", "chamber", "pressure band"} <= set(both.where["group"])
    assert (both.where["difference"] == both.where["model"] - both.where["improved"]).all()
    assert repr(both).startswith("ModelComparison: “improved” is nearer to the measurements than “model”")
    assert "95 % interval" in both._repr_html_()
    assert {"error", "surface model", "surface improved", "where marker"} <= set(both.pictures)
    for picture in both.pictures:
        assert both.plot(picture).to_dict()["data"]
    both.save(tmp_path / "out")
    assert (
        json.loads((tmp_path / "out" / "comparison.json").read_text(encoding="utf-8"))["better"] == "improved"
    )
    with pytest.raises(
        LabrigError, match=r"^compare: 3 models were given; it takes one model, or a list of two$"
    ):
        labrig.compare(lab / "first", ["a", "b", "c"])


@pytest.fixture(scope="module")
def doubt(lab: Path) -> labrig.Diagnosis:
    """What three captures leave open of two effects: each more takes as long again to plan for."""
    others = set(shipped()) - {"creep", "tension"}
    return labrig.diagnose(_few(lab), lab / "model.yaml", without=sorted(others))


def _few(lab: Path) -> Any:
    return labrig.open_run(lab / "first").isel(capture=slice(3))


def test_a_proposal_can_be_run(lab: Path, doubt: labrig.Diagnosis, tmp_path: Path) -> None:
    """Where few captures leave a doubt, the programme is a table, a picture, and the parameters of a run."""
    few, model = _few(lab), lab / "model.yaml"
    assert doubt.verdict == "confounded"
    proposal = labrig.propose_experiment(few, model, rig=lab / "rig.yaml", diagnosis=doubt, minutes=2)
    assert 0 < proposal.minutes <= 2.5
    assert {"c1", "c2", "c3", "c4", "hold_s"} <= set(proposal.points.columns)
    assert repr(proposal).startswith("Proposal: ")
    assert proposal.plot().to_dict()["data"]
    assert proposal.save(tmp_path / "next").is_file()
    table = pd.read_csv(tmp_path / "next" / "programme.csv")
    assert table["c1 [kPa]"].tolist() == proposal.points["c1"].tolist()
    assert table["hold_s"].tolist() == proposal.points["hold_s"].tolist()
    folder = labrig.run("programme", lab / "rig.yaml", out=tmp_path / "second", **proposal.procedure())
    assert labrig.open_run(folder).sizes["capture"] == len(proposal.points)


def test_set_points_that_are_no_kpa_are_a_table_only(
    lab: Path, doubt: labrig.Diagnosis, tmp_path: Path
) -> None:
    """A rig of somebody's own that takes volts has its set-points in volts, and no procedure that calls them kPa; the
    table is there all the same.
    """
    surface = reduced_surface(RIG)
    # the simulator as a function: by itself it takes no volts
    few, model = _few(lab), labrig.Model.of(lambda u: surface.predict(u).reshape(len(u), -1))
    for name in ("commanded", "event_commanded"):
        few[name].attrs["units"] = "V"
    proposal = labrig.propose_experiment(few, model, diagnosis=doubt, minutes=1)
    with pytest.raises(
        LabrigError,
        match=r"^a rig's procedure is in kPa, and these set-points are in V: no procedure file was written; "
        r".*programme\.csv has them, .*report\.html shows them$",
    ):
        proposal.save(tmp_path / "next", tmp_path / "next.yaml")
    with pytest.raises(LabrigError, match="in V"):
        proposal.procedure()
    assert not (tmp_path / "next.yaml").exists()
    assert "c1 [V]" in pd.read_csv(tmp_path / "next" / "programme.csv").columns


def test_pressures_of_another_unit_are_a_procedure_in_kpa(
    lab: Path, doubt: labrig.Diagnosis, tmp_path: Path
) -> None:
    """A rig that was logged in bar gets its set-points in bar, and a procedure in the unit of procedures."""
    few, model = _few(lab), lab / "model.yaml"
    for name in ("commanded", "event_commanded"):
        few[name] = (few[name] / 100).assign_attrs(units="bar")
    few = few.assign_coords({f"chamber_{end}": few[f"chamber_{end}"] / 100 for end in ("min", "max")})
    proposal = labrig.propose_experiment(few, model, diagnosis=doubt, minutes=1)
    proposal.save(tmp_path / "next", tmp_path / "next.yaml")
    table = pd.read_csv(tmp_path / "next" / "programme.csv")
    points = yaml.safe_load((tmp_path / "next.yaml").read_text())["points"]
    kpa = [point.get("pressure_kpa", {}).get("c1", 0.0) for point in points]
    assert kpa == pytest.approx((100 * table["c1 [bar]"]).tolist())
    assert max(kpa) > 0


def test_each_input_is_planned_in_its_own_unit(lab: Path, doubt: labrig.Diagnosis, tmp_path: Path) -> None:
    """Where one input is in bar and the others in psi, the table says so of each, and the procedure is in kPa."""
    surface = reduced_surface(RIG)
    few, model = _few(lab), labrig.Model.of(lambda u: surface.predict(u).reshape(len(u), -1))
    units = ["bar", *["psi"] * (few.sizes["chamber"] - 1)]
    for name in ("commanded", "event_commanded"):
        few[name].attrs["units"] = "bar or psi"
    few.attrs["chamber_units"] = units
    proposal = labrig.propose_experiment(few, model, diagnosis=doubt, minutes=1)
    proposal.save(tmp_path / "next", tmp_path / "next" / "next.yaml")
    table = pd.read_csv(tmp_path / "next" / "programme.csv")
    points = yaml.safe_load((tmp_path / "next" / "next.yaml").read_text())["points"]
    for chamber, unit, kpa in (("c1", "bar", 100.0), ("c2", "psi", 6.894757)):
        planned = [point.get("pressure_kpa", {}).get(chamber, 0.0) for point in points]
        assert planned == pytest.approx((kpa * table[f"{chamber} [{unit}]"]).tolist(), rel=1e-6)
        assert max(planned) > 0


def test_what_needs_a_person_is_no_set_point_of_the_table(lab: Path) -> None:
    """Who goes through the table alone is not sent to a set-point before which something is to be done by hand."""
    from labrig.api import _propose
    from labrig.experiment import Experiment, Limits
    from labrig.experiment._plan import Point

    hand = {"effect": "gravity", "what": "turn the base", "points": True}
    summary: Any = {"actuation_units": "kPa", "by_hand": [hand]}
    limits = Limits(np.zeros(1), np.full(1, 60.0), np.ones(1))
    point = Point((0.5,), 4.0)
    experiment = Experiment(summary, (point,), ("",), ("alone",), limits, ("c1",))
    assert len(experiment.programme()) == 3
    assert _propose.Proposal(experiment).points["label"].tolist() == ["alone"]


def test_runs_of_two_kinds_are_taken_together(lab: Path) -> None:
    """A list of paths and opened runs is one campaign."""
    one, two = (labrig.compare(runs, lab / "model.yaml") for runs in (lab / "first", [lab / "first"]))
    assert one.error == two.error
    assert np.isfinite(list(one.error.values())).all()
