"""The closed loop on a simulated rig: realised, scanned, compared, refined, resumed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig import LabrigError
from labrig.api._validate import Validation
from labrig.campaign import dry_run, read_completed, resume, run
from labrig.campaign._scans import keep_scan
from labrig.cli._validate import _print as print_validation
from labrig.cli._validate import report
from labrig.ik import Approach, Refinement, make_trials, outcomes
from labrig.ik._load import rig_shape
from labrig.ik._outcome import _expected_markers, simulated_plant
from labrig.rig import connect, load_rig
from labrig.surface import Mesh, grid, read_mesh
from labrig_drivers import Scan, SimulatedClock
from labrig_procedures import Validate

PLAY = {
    "name": "hysteresis",
    "form": "play",
    "parameters": {"weight": {"value": 0.3}, "width": {"value": 0.1}},
}
TRUTH = np.array([20.0, 35.0, 10.0, 40.0, 25.0, 50.0, 15.0, 30.0, 45.0])


def write_target(folder, name, points, triangles):
    """A PLY in mm."""
    made = folder / keep_scan(Scan(0.0, points, triangles, (), ""), folder)[0]
    return str(made.rename(folder / name))


@pytest.fixture
def lab(tmp_path, mannequin):
    """A rig with a scanner whose plant is the model's, a model file, and a target that it can be."""
    rig = {
        "name": "r",
        "chambers": [{"name": f"c{c + 1}", "min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 400} for c in range(9)],
        "markers": [f"m{m + 1:02d}" for m in range(34)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "scanner": {"kind": "simulated"},
        "simulated": {"surface": "mannequin", "noise_mm": 0.05, "occlusion": 0.0, "repeatability_mm": 0.0},
    }
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(rig))
    (tmp_path / "model.yaml").write_text(yaml.safe_dump({"base": {"kind": "simulator", "rig": "rig.yaml"}}))
    uv, triangles = grid(31, 41)
    write_target(tmp_path, "a.ply", mannequin.points(TRUTH[None], uv)[0], triangles)
    return tmp_path


def procedure(lab, **fields):
    given = {"targets": (str(lab / "a.ply"),), "model": str(lab / "model.yaml"), "record_s": 0.2}
    return Validate(**{**given, **fields})


def go(lab, chosen, name="run"):
    clock = SimulatedClock(0.0)
    with connect(load_rig(lab / "rig.yaml"), clock) as rig:
        return run(chosen, rig, lab / name, clock)


def test_the_loop_closes(lab):
    """A shape that the rig can take is realised to the noise of its scan, and the model is right about it."""
    (found,) = outcomes(go(lab, procedure(lab)))
    summary = found.summary()
    assert summary["target"] == "a.ply"
    assert summary["hardware_mm"]["mean"] < 0.1
    assert summary["predicted_mm"]["mean"] < 0.1
    assert summary["realised_mm"]["mean"] < 0.1
    assert summary["realised_against_predicted_mm"]["p95"] < 0.3
    assert summary["markers_against_predicted_mm"]["mean"] < 0.2
    assert summary["registration"]["sd_mm"] < 0.1
    np.testing.assert_allclose(found.attempts[0].pressure_kpa, TRUTH, atol=0.5)


@pytest.mark.parametrize(("low", "high"), [(0, 80), (-10, 60)])
def test_a_rig_that_goes_further_than_most_has_its_report(lab, low, high):
    """What a simulated rig itself could do is looked for within that rig's own limits, above 60 kPa and in vacuum."""
    rig = yaml.safe_load((lab / "rig.yaml").read_text())
    for chamber in rig["chambers"]:
        chamber |= {"min_kpa": low, "max_kpa": high}
    (lab / "rig.yaml").write_text(yaml.safe_dump(rig))
    (found,) = outcomes(go(lab, procedure(lab)))
    assert found.summary()["hardware_mm"]["mean"] < 0.1
    plant = simulated_plant(rig, lab, np.full(9, low), np.full(9, high))
    assert plant is not None
    assert (set(plant.low_kpa), set(plant.high_kpa)) == ({low}, {high})
    shape = rig_shape(lab / "rig.yaml")
    assert (set(shape.low_kpa), set(shape.high_kpa)) == ({low}, {high})


def test_a_missing_yardstick_costs_no_report(lab, monkeypatch):
    """Where the simulator of the rig finds no equilibrium only its own best is missing."""

    def lost(*_):
        raise LabrigError("no equilibrium")

    monkeypatch.setattr("labrig.ik._outcome.hardware_best", lost)
    (found,) = outcomes(go(lab, procedure(lab)))
    assert found.summary()["hardware_mm"] is None
    assert found.summary()["realised_mm"]["mean"] < 0.1


def test_what_was_done_counts(lab):
    """A report made later speaks of the set-points in the log, not of those that would be chosen then."""
    folder = go(lab, procedure(lab))
    (lab / "model.yaml").write_text(
        yaml.safe_dump({"base": {"kind": "simulator", "rig": "rig.yaml"}, "effects": [PLAY]})
    )
    (found,) = outcomes(folder)
    np.testing.assert_allclose(found.attempts[0].pressure_kpa, TRUTH, atol=0.5)
    np.testing.assert_allclose(found.trial.approach.setpoints_kpa[-1], found.attempts[0].pressure_kpa)
    assert found.summary()["predicted_mm"]["mean"] > 0.3  # by now the model believes that play was in the way


def test_with_and_without_effects(lab):
    """A model that wrongly believes in hysteresis does worse with its effect than without; a word says the former."""
    (lab / "model.yaml").write_text(
        yaml.safe_dump({"base": {"kind": "simulator", "rig": "rig.yaml"}, "effects": [PLAY]})
    )
    whole, without = (one.summary() for one in outcomes(go(lab, procedure(lab, without=("effects",)))))
    assert [whole["model"], without["model"]] == ["the whole model", "without the effects"]
    said = repr(Validation(lab / "run", outcomes(lab / "run")))
    mean_mm = f"{whole['realised_mm']['mean']:.3g} mm"
    assert (
        said
        == f"Validation: 2 realisations of 1 targets, {mean_mm} from the target on the mean with the whole model"
    )
    assert (
        whole["realised_against_predicted_mm"]["mean"] > 3 * without["realised_against_predicted_mm"]["mean"]
    )


def test_refining_on_the_rig_makes_up_for_the_model(lab):
    """With a model that is wrong, three scans more take most of the error away; in a notebook, too, both are said."""
    (lab / "model.yaml").write_text(
        yaml.safe_dump({"base": {"kind": "simulator", "rig": "rig.yaml"}, "effects": [PLAY]})
    )
    (found,) = outcomes(go(lab, procedure(lab, refine=3)))
    summary = found.summary()
    refined = [one["realised_mm"]["mean"] for one in summary["refined"]]
    assert summary["scans"] == 1 + len(refined) <= 4
    assert min(refined) < 0.4 * summary["realised_mm"]["mean"]
    shown = Validation(lab / "run", [found])
    assert shown.realisations["refined"][0] == min(refined)
    assert f"{min(refined):.3g} mm after refining" in repr(shown)


def test_it_resumes_like_any_other(lab):
    """A run that lost its end goes on after its last step and shows the same."""
    chosen = procedure(lab, refine=1)
    folder = go(lab, chosen)
    whole = [done.step for done in read_completed(folder)]
    log = sorted(folder.glob("log.*.mcap"))[-1]
    data = log.read_bytes()
    log.write_bytes(data[: int(0.6 * len(data))])
    lost = len(whole) - len(read_completed(folder))
    assert lost > 0
    clock = SimulatedClock(10_000.0)
    with connect(load_rig(lab / "rig.yaml"), clock) as rig:
        resume(chosen, rig, folder, clock)
    assert [step.kind for step in whole][: len(whole) - lost] == [
        done.step.kind for done in read_completed(folder)
    ][: len(whole) - lost]
    assert outcomes(folder)[0].summary()["realised_mm"]["mean"] < 0.1
    report(folder)
    assert "<h3>refined, 1 scan more</h3>" in (folder / "report.html").read_text()


def test_chambers_are_matched_by_name(lab):
    """A rig that lists its chambers in another order gets each pressure in its own, within its limits."""
    config = load_rig(lab / "rig.yaml")
    turned = config.model_copy(update={"chambers": config.chambers[::-1]})
    plan = dry_run(procedure(lab, refine=1), turned)
    (asked,) = (step.pressure_kpa for step in plan.steps if step.kind == "actuate")
    np.testing.assert_allclose(asked, TRUTH[::-1], atol=0.5)
    names = tuple(channel.name for channel in turned.channels)
    high = np.array([60.0] * 3 + [30.0] + [60.0] * 5)  # that of c6, which the target has at 50
    given = [str(lab / "a.ply")], str(lab / "model.yaml"), "mm", (), names, np.zeros(9), high
    (trial,) = make_trials(*given)
    rig_kpa = trial.for_rig(trial.approach).setpoints_kpa[-1]
    assert (rig_kpa <= high).all()
    assert rig_kpa[3] == pytest.approx(30.0)
    np.testing.assert_array_equal(trial.of_rig(rig_kpa), trial.approach.setpoints_kpa[-1])
    (same,) = make_trials(*given[:4], names[::-1], np.zeros(9), high[::-1])
    here, there = trial.refinement(np.zeros(9), high), same.refinement(np.zeros(9), high[::-1])
    height = trial.heights(trial.predicted) + 1.0
    np.testing.assert_allclose(
        here.propose(rig_kpa, height), there.propose(rig_kpa[::-1], height)[::-1], atol=1e-6
    )


def test_a_dry_run_needs_no_scan(lab):
    """The plan is known beforehand, up to what depends on scans."""
    plan = dry_run(procedure(lab, refine=2), load_rig(lab / "rig.yaml"))
    kinds = [step.kind for step in plan.steps]
    assert kinds == ["note", "vent", "actuate", "settle", "record", "scan"]
    assert plan.stopped is None
    assert not plan.broken


def test_errors_for_people(lab):
    """What does not fit is said in one line before anything moves."""
    config = load_rig(lab / "rig.yaml")
    for fields, expected in (
        ({"without": ("warp",)}, f"{lab / 'model.yaml'}: has no warp that could be left out"),
        ({"without": ("effects",)}, f"{lab / 'model.yaml'}: has no effects that could be left out"),
        ({"targets": (str(lab / "b.ply"),)}, f"cannot read {lab / 'b.ply'}: No such file or directory"),
    ):
        with pytest.raises(LabrigError) as error:
            dry_run(procedure(lab, **fields), config)
        assert str(error.value) == expected
    with pytest.raises(LabrigError) as error:
        dry_run(procedure(lab, refine=1), config.model_copy(update={"scanner": None}))
    assert str(error.value) == "rig r has no scanner, and refining needs one"
    with pytest.raises(LabrigError) as error:
        dry_run(Validate(), config)
    expected = "validate needs targets and a model: labrig validate TARGET... --rig RIG --model MODEL"
    assert str(error.value) == expected
    with pytest.raises(LabrigError) as error:
        outcomes(Path(lab))
    assert str(error.value) == f"{lab} is no run of validate: it has no run.yaml"


def test_report(lab):
    """The report holds every figure and map; its JSON is plain."""
    folder = go(lab, procedure(lab))
    report(folder)
    content = json.loads((folder / "validation.json").read_text())
    assert content["realisations"][0]["target"] == "a.ply"
    html = (folder / "report.html").read_text()
    assert "<h3>predicted</h3>" in html
    assert "<h3>realised – predicted</h3>" in html
    assert '"type":"mesh3d"' in html


def test_a_narrow_scan_is_said(lab, capsys):
    """Distances of a scan of a third of the target stand beside the share that they are of."""
    (found,) = outcomes(go(lab, procedure(lab)))
    assert found.summary()["compared"] > 0.9
    height = found.attempts[0].height_mm.copy()
    height[len(height) // 3 :] = np.nan
    narrow = replace(found, attempts=(replace(found.attempts[0], height_mm=height),)).summary()
    assert 0.2 < narrow["compared"] < 0.45
    print_validation([found.summary(), narrow])
    assert capsys.readouterr().out.count(f"the scan shows {narrow['compared']:.0%} of it") == 1


def test_broyden_finds_what_the_model_has_wrong():
    """On a linear rig whose derivatives are 30 % off in places, the heights fall by each step."""
    rng = np.random.default_rng(0)
    truth = rng.normal(0, 0.2, (300, 4))
    believed = truth * rng.uniform(0.7, 1.3, (1, 4)) + rng.normal(0, 0.02, (300, 4))
    goal = np.array([20.0, 40.0, 30.0, 10.0])
    search = Refinement(believed, np.zeros((300, 6)), np.zeros(4), np.full(4, 60.0))
    pressure, misfits = goal + np.array([6.0, -8.0, 5.0, 9.0]), []
    for _ in range(5):
        height = truth @ (pressure - goal)
        misfits.append(np.abs(height).mean())
        pressure = search.propose(pressure, np.where(np.arange(300) % 10 == 0, np.nan, height))
    assert misfits[-1] < 0.02 * misfits[0]
    assert search.best is not None
    assert search.best[0] == pytest.approx(min(misfits), rel=0.2)


def test_refining_goes_the_right_way_for_a_target_that_is_inside_out(lab, mannequin):
    """On a rig that is a quarter too soft, a target takes as few scans whichever way its triangles face."""
    whole = read_mesh(lab / "a.ply", "mm")
    write_target(lab, "b.ply", whole.vertices_mm, whole.triangles[:, ::-1])
    uv, triangles = grid(31, 41)
    low, high = np.zeros(9), np.full(9, 60.0)
    for name in ("a.ply", "b.ply"):
        names = mannequin.chamber_names
        (trial,) = make_trials([str(lab / name)], str(lab / "model.yaml"), "mm", (), names, low, high)
        result, search = trial.solved.result, trial.refinement(low, high)
        pressure, misfits = result.pressure_kpa, []
        for _ in range(3):
            realised = Mesh(result.to_target(mannequin.points(0.75 * pressure[None], uv)[0]), triangles)
            height = trial.heights(realised)
            misfits.append(np.nanmean(np.abs(height)))
            pressure = search.propose(pressure, height)
        assert result.inverted == (name == "b.ply")
        assert misfits[1] < 0.6 * misfits[0], name
        assert misfits[2] < 0.4 * misfits[0], name


def test_markers_are_expected_where_effects_displace_them(lab):
    """Markers that an effect shifts are expected where it shifts them, whatever their order in the rig."""
    shift = {
        "name": "rest_shape",
        "parameters": {"offset": {"value": [0.0, 2.0, 0.0] * 33 + [0.0, 5.0, 0.0]}},
    }
    plain = _expected_markers(trial_of(lab), ("m34", "other", "m01"))
    (lab / "model.yaml").write_text(
        yaml.safe_dump({"base": {"kind": "simulator", "rig": "rig.yaml"}, "effects": [shift]})
    )
    moved = _expected_markers(trial_of(lab), ("m34", "other", "m01")) - plain
    np.testing.assert_allclose(moved, [[0.0, 5.0, 0.0], [np.nan] * 3, [0.0, 2.0, 0.0]], atol=1e-9)


def trial_of(lab):
    """The target of the lab, at the truth's pressures."""
    names = tuple(f"c{c + 1}" for c in range(9))
    given = str(lab / "a.ply"), str(lab / "model.yaml")
    (trial,) = make_trials([given[0]], given[1], "mm", (), names, np.zeros(9), np.full(9, 60.0))
    return replace(trial, solved=replace(trial.solved, path=Approach("straight", TRUTH[None], (3.0,))))


def test_limits_hold_while_refining():
    """No proposal leaves the limits, nor goes farther than a quarter of the range."""
    search = Refinement(np.eye(4), np.zeros((4, 6)), np.zeros(4), np.full(4, 60.0))
    following = search.propose(np.full(4, 55.0), np.full(4, -100.0))
    assert (following <= 60.0).all()
    following = search.propose(np.full(4, 30.0), np.full(4, 5.0))
    assert (np.abs(following - 30.0) <= 15.0 + 1e-9).all()


def test_a_scan_with_a_hand_and_inside_out_is_placed_like_a_good_one(lab, mannequin):
    """What lies far from the predicted surface is left out, the outside is out, and the heights are the scan's own."""
    given = procedure(lab)
    (trial,) = make_trials(
        given.targets, given.model, "mm", (), mannequin.chamber_names, np.zeros(9), np.full(9, 60)
    )
    uv, triangles = grid(31, 41)
    scan = Mesh(mannequin.points(TRUTH[None] + 12.0 * np.eye(9)[:1], uv)[0], triangles)
    good = trial.heights(trial.placed(scan)[0])
    hand = np.random.default_rng(0).normal(scan.vertices_mm.max(axis=0) + 150.0, 15.0, (60, 3))
    loose = np.arange(60).reshape(-1, 3) + len(scan.vertices_mm)
    bad = Mesh(np.concatenate([scan.vertices_mm, hand]), np.concatenate([triangles, loose])).turned()
    placed, registration = trial.placed(bad)
    assert len(placed.vertices_mm) == len(scan.vertices_mm)
    assert registration.turned
    assert np.nanmax(np.abs(good)) > 2.0
    np.testing.assert_allclose(trial.heights(placed), good, atol=0.05)


def test_replaced_fields_are_refused(lab):
    """A run of validate cannot be resumed with other targets."""
    folder = go(lab, procedure(lab))
    clock = SimulatedClock(10_000.0)
    with connect(load_rig(lab / "rig.yaml"), clock) as rig, pytest.raises(LabrigError, match="parameters"):
        resume(procedure(lab, refine=2), replace(rig), folder, clock)
