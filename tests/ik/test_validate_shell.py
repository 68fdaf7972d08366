"""The closed loop with a learned model, on a rig whose plant is a shell that is not the model's."""

import json

import numpy as np
import pytest
import yaml

from labrig.campaign import resume, run
from labrig.campaign._scans import keep_scan
from labrig.cli._validate import report
from labrig.ik import outcomes
from labrig.log import read_run_yaml, summarise
from labrig.physics import load_shell, plant_shell, simulate
from labrig.rig import connect, load_rig
from labrig.surface import grid
from labrig.surrogate import Frames, save_model, train_forward, train_warp, training_set
from labrig_drivers import Scan, SimulatedClock
from labrig_procedures import Validate

TRUTH = np.array([35.0, 10.0, 45.0, 20.0, 40.0, 15.0, 30.0, 25.0, 20.0])
PLAY = {
    "name": "hysteresis",
    "form": "play",
    "parameters": {"weight": {"value": 0.3}, "width": {"value": 0.1}},
}
FORMS = ["the whole model", "without the warp", "without the effects"]


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A coarse rig, what was learned of it from twenty frames, and that with an effect which the rig does not have."""
    folder = tmp_path_factory.mktemp("shell")
    shell = load_shell("mannequin").changed(count=(12, 12))
    rig = {
        "name": "coarse",
        "chambers": [{"name": name, "max_kpa": 60, "slew_kpa_s": 400} for name in shell.chamber_names],
        "markers": list(shell.marker_names),
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "scanner": {"kind": "simulated"},
        "simulated": {
            "shell": shell.content(),
            "plant": {"count": [12, 12], "shapes": 32, "seed": 5},
            "noise_mm": 0.02,
            "occlusion": 0.0,
        },
    }
    (folder / "rig.yaml").write_text(yaml.safe_dump(rig))
    plant = plant_shell(rig)
    pressures = np.random.default_rng(1).uniform(0, 50, (20, 9))
    markers = [plant.spline.evaluate(plant.solve(p).control_mm, plant.marker_uv) for p in pressures]
    made = simulate(shell, folder / "simulations", 60, jacobians=True, workers=1)
    forward = train_forward(training_set(made), samples=12).model
    learned = train_warp(forward, Frames(shell.marker_names, pressures, np.array(markers))).model
    save_model(learned, folder / "sim2real.pt")
    model = {"base": {"kind": "surrogate", "file": "sim2real.pt"}, "effects": [PLAY]}
    (folder / "model.yaml").write_text(yaml.safe_dump(model))
    uv, triangles = grid(31, 41)
    points = plant.spline.evaluate(plant.solve(TRUTH).control_mm, uv)
    kept = keep_scan(Scan(0.0, points, triangles, (), ""), folder)[0]
    (folder / kept).rename(folder / "asked.ply")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LABRIG_CACHE", str(folder / "cache"))
        yield folder


@pytest.fixture(scope="module")
def validated(lab):
    """The procedure, and its run: the target with the whole model, without its warp, and without its effect."""
    chosen = Validate(
        targets=(str(lab / "asked.ply"),),
        model=str(lab / "model.yaml"),
        unit="mm",
        without=("warp", "effects"),
        record_s=0.2,
    )
    clock = SimulatedClock(0.0)
    with connect(load_rig(lab / "rig.yaml"), clock) as rig:
        return chosen, run(chosen, rig, lab / "run", clock)


def test_what_the_model_promised_comes_about(validated):
    """A shape that the rig can take is realised close to it and to what was predicted; a wrong effect stands out."""
    found = [one.summary() for one in outcomes(validated[1])]
    assert [one["model"] for one in found] == FORMS
    whole, unwarped, plain = found
    assert plain["hardware_mm"]["mean"] < 0.06
    assert plain["predicted_mm"]["mean"] < 0.2
    assert plain["realised_mm"]["mean"] < 0.2
    assert plain["realised_against_predicted_mm"]["mean"] < 0.25
    np.testing.assert_allclose(plain["pressure_kpa"], TRUTH, atol=2.0)
    for mistaken in (whole, unwarped):
        assert (
            mistaken["realised_against_predicted_mm"]["mean"]
            > 1.5 * plain["realised_against_predicted_mm"]["mean"]
        )
        assert (
            mistaken["markers_against_predicted_mm"]["mean"]
            > 2.0 * plain["markers_against_predicted_mm"]["mean"]
        )
    assert np.abs(np.subtract(whole["pressure_kpa"], unwarped["pressure_kpa"])).max() > 0.1


def test_report_and_json_say_what_is_what(validated):
    """Both name the target, every form of the model, and what was predicted and realised of it."""
    folder = validated[1]
    report(folder)
    realisations = json.loads((folder / "validation.json").read_text())["realisations"]
    assert [(one["target"], one["model"]) for one in realisations] == [("asked.ply", form) for form in FORMS]
    for one in realisations:
        for key in ("hardware_mm", "predicted_mm", "realised_mm", "realised_against_predicted_mm"):
            assert 0.0 < one[key]["mean"] < one[key]["p95"] < one[key]["max"] < 10.0
    html = (folder / "report.html").read_text()
    for form in FORMS:
        assert f"asked.ply, {form}" in html
    for title in ("hardware’s best", "predicted", "realised", "realised – predicted"):
        assert html.count(f"<h3>{title}</h3>") == len(FORMS)


def test_it_goes_on_where_it_was_stopped(validated, lab):
    """A log that ends in the middle is gone on with, and shows the same in the end."""
    chosen, folder = validated
    before = [one.summary() for one in outcomes(folder)]
    log = max(folder.glob("log.*.mcap"))
    log.write_bytes(log.read_bytes()[: int(0.5 * log.stat().st_size)])
    assert summarise(folder).state != "completed"
    assert len(outcomes(folder)) < len(before)
    clock = SimulatedClock(10_000.0)
    with connect(load_rig(lab / "rig.yaml"), clock) as rig:
        resume(chosen, rig, folder, clock)
    assert summarise(folder).state == "completed"
    assert read_run_yaml(folder)["parameters"]["without"] == ["warp", "effects"]
    for one, again in zip(before, outcomes(folder), strict=True):
        assert again.summary()["pressure_kpa"] == one["pressure_kpa"]
        assert abs(again.summary()["realised_mm"]["mean"] - one["realised_mm"]["mean"]) < 0.03
