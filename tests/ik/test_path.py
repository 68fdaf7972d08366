"""Surfaces that remember: what a path does to them, and the path after which they have the wanted shape."""

from pathlib import Path as FilePath

import numpy as np
import pytest
import yaml

from labrig import LabrigError
from labrig.effects._skin import at_events
from labrig.ik import Remembering, Solver, SurfaceModel, plan_path, solve_with_path
from labrig.ik._after import after
from labrig.ik._path import SETTLE_S, paths_to
from labrig.model import EffectEntry, Model, ModelFile
from labrig.physics import load_surface
from labrig.surface import Mesh, Target, distances, grid
from labrig_drivers.simulated import build_plant

RIG = {
    "name": "r",
    "simulated": {"surface": "mannequin", "noise_mm": 0.02, "occlusion": 0.0, "repeatability_mm": 0.0},
}


def remembering(*effects):
    base = {"kind": "simulator", "rig": "rig.yaml"}
    file = ModelFile.model_validate({"base": base, "effects": list(effects)})
    return Remembering(Model(file, FilePath()), SurfaceModel(load_surface(RIG)))


def play(weight=0.3, width=0.1):
    return {
        "name": "hysteresis",
        "form": "play",
        "parameters": {"weight": {"value": weight}, "width": {"value": width}},
    }


def creep(amplitude=0.2, tau_s=5.0):
    values = {"amplitude": {"value": amplitude}, "tau_s": {"value": tau_s}, "known": {"value": 0.0}}
    return {"name": "creep", "form": "Kelvin-Voigt", "parameters": values}


def test_without_effects_nothing_is_remembered():
    """The pressures that count are the last set-points, and no marker is displaced."""
    setpoint = np.full(9, 30.0)
    effective, displaced = remembering().after(paths_to(setpoint, np.zeros(9), np.full(9, 60.0), 0.4, 3.0))
    np.testing.assert_array_equal(effective, setpoint)
    assert not displaced.any()


def test_what_acts_on_the_surface_knows_where_it_was():
    """At every set-point of the path the surface was where the shape has it, not where a fit to its end would be."""
    memory = remembering()
    rows = memory._rows(paths_to(np.linspace(10.0, 45.0, 9), np.zeros(9), np.full(9, 60.0), 0.4, 3.0))
    context = memory._context(rows)
    marked = memory.shape.points(rows.event_actuation, memory.shape.marker_uv).reshape(
        len(rows.event_actuation), -1
    )
    np.testing.assert_allclose(at_events(context), marked - context.base_vented, atol=1e-9)


@pytest.mark.parametrize(("overshoot", "sign"), [(0.0, -1.0), (0.4, 1.0)])
def test_play_lags_behind_from_both_sides(overshoot, sign):
    """From below a play of a tenth of the range and a weight of 0.3 costs 1.8 kPa, from above it adds as much."""
    path = paths_to(np.full(9, 30.0), np.zeros(9), np.full(9, 60.0), overshoot, 3.0)
    effective, _ = remembering(play()).after(path)
    np.testing.assert_allclose(effective, 30.0 + sign * 0.3 * 0.1 * 60.0)


def test_play_is_inverted():
    """The last set-point makes up for the play; the shortest path is taken."""
    wanted = np.linspace(10.0, 45.0, 9)
    plan = plan_path(wanted, remembering(play()))
    assert plan.path.name == "straight"
    assert plan.path.holds_s == (SETTLE_S,)
    np.testing.assert_allclose(plan.path.setpoints_kpa[-1], wanted + 1.8, atol=0.02)
    assert plan.error_mm < 0.01


def test_from_above_it_needs_less():
    """An approach from above, where that is asked for, ends as much below as one from below ends above."""
    wanted = np.full(9, 30.0)
    plan = plan_path(wanted, remembering(play()), overshoots=(0.4,))
    assert plan.path.name == "from 40 % above"
    np.testing.assert_allclose(plan.path.setpoints_kpa[-1], wanted - 1.8, atol=0.02)
    assert plan.error_mm < 0.01


def test_limits_of_the_rig_hold_on_the_way():
    """No set-point of a path is above the limit; what that costs is said."""
    wanted = np.full(9, 59.5)
    plan = plan_path(wanted, remembering(play()))
    assert (plan.path.setpoints_kpa <= 60.0).all()
    assert 0.3 < plan.error_mm < 1.5


def test_creep_is_allowed_for():
    """With creep the surface is where it is wanted at the end of the hold, not before."""
    memory = remembering(creep())
    wanted = np.full(9, 30.0)
    effective, _ = memory.after(paths_to(wanted, np.zeros(9), np.full(9, 60.0), 0.0, 3.0))
    assert (effective > 31.0).all()
    plan = plan_path(wanted, memory)
    assert plan.error_mm < 0.01
    np.testing.assert_allclose(plan.effective_kpa, wanted, atol=0.05)


def test_displaced_markers_are_taken_into_the_surface():
    """An effect that acts on the markers themselves changes what is asked of the pressures."""
    shift = {"name": "rest_shape", "parameters": {"offset": {"value": [0.0, 2.0, 0.0] * 34}}}
    memory = remembering(shift)
    uv, triangles = grid(61, 71)
    truth = np.full(9, 30.0)
    points = memory.shape.points(truth[None], uv)[0] + [0.0, 2.0, 0.0]
    result, plan = solve_with_path(Mesh(points, triangles), memory)
    np.testing.assert_allclose(plan.displaced_mm, np.tile([0.0, 2.0, 0.0], (34, 1)), atol=1e-9)
    assert result.mean_mm < 0.05


def test_the_result_is_what_the_path_comes_to():
    """Where the limits keep a path from what was wanted, distances, limits and gaps are those after the path."""
    memory = remembering(play(0.5, 0.3))
    uv, triangles = grid(61, 71)
    wanted = np.where(np.arange(9) == 5, 59.0, 30.0)
    target = Mesh(memory.shape.points(wanted[None], uv)[0], triangles)
    result, plan = solve_with_path(target, memory)
    left = distances(result.to_target(memory.shape.points(plan.effective_kpa[None], uv)[0]), target).summary()
    np.testing.assert_array_equal(result.pressure_kpa, plan.path.setpoints_kpa[-1])
    assert result.mean_mm > 0.2
    assert result.mean_mm == pytest.approx(left["mean_mm"], rel=0.1)
    assert result.limited == ("c6",)
    assert (result.gaps[0].chamber, result.gaps[0].limit) == ("c6", "highest")
    assert 0.0 < result.sd_kpa.max() < 5.0


def test_a_result_speaks_of_pressures_beyond_the_models_limits():
    """Where creep takes what counts beyond the limits, distances are those at the pressures that count."""
    memory = remembering(creep(0.3, 1.0))
    uv, triangles = grid(61, 71)
    target = Mesh(memory.shape.points(np.full((1, 9), 30.0), uv)[0], triangles)
    search = Solver(memory.shape).solve(target)
    found = after(
        Target(target),
        memory.shape,
        np.full(9, 75.0),
        search,
        np.full(9, 60.0),
        (np.zeros(9), np.full(9, 60.0)),
    )
    left = distances(found.to_target(memory.shape.points(np.full((1, 9), 75.0), uv)[0]), target).summary()
    assert found.mean_mm == pytest.approx(left["mean_mm"], rel=0.15)


@pytest.mark.parametrize("kept", [1, 2, 3])
def test_too_few_markers_are_said(kept):
    """One marker, two, or three in a line do not say how the surface moves beside them: one line says so."""
    memory = remembering()
    memory.shape.marker_uv = np.array([[0.2, 0.5], [0.5, 0.5], [0.8, 0.5]])[:kept]
    with pytest.raises(LabrigError) as error:
        memory.displaced(np.ones((kept, 3)))
    assert str(error.value) == (
        "an effect that displaces markers moves the surface between them: that needs three markers, not in a line"
    )


def campaign_of(rig, tmp_path):
    """A repeatability run on a simulated rig."""
    from labrig import open_run
    from labrig.campaign import run
    from labrig.rig import connect, load_rig
    from labrig_drivers import SimulatedClock
    from labrig_procedures import Repeatability

    path = tmp_path / "rig.yaml"
    path.write_text(yaml.safe_dump(rig))
    clock = SimulatedClock(0.0)
    with connect(load_rig(path), clock) as connected:
        run(Repeatability(points=6, visits=2, reach=0.3, record_s=0.3), connected, tmp_path / "run", clock)
    return open_run(tmp_path / "run")


def test_it_beats_the_static_answer_on_a_plant_that_hides_hysteresis(tmp_path):
    """With an effect fitted to the rig's own runs, its path leaves less than 70 % of the static answer's error."""
    from labrig.diagnosis import improve

    rig = {
        **RIG,
        "chambers": [{"name": f"c{c + 1}", "min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 400} for c in range(9)],
        "markers": [f"m{m + 1:02d}" for m in range(34)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
    }
    hidden = {"effects": [{"name": "hysteresis", "amplitude": 1.0}], "seed": 3}
    rig["simulated"] = {**rig["simulated"], "hidden": hidden}
    data = campaign_of(rig, tmp_path)
    bare = Model(ModelFile.model_validate({"base": {"kind": "simulator", "rig": "rig.yaml"}}), tmp_path)
    improved = improve(data, bare, ["hysteresis"]).improved
    assert improved is not None
    memory = Remembering(improved, SurfaceModel(load_surface(rig)))
    rng = np.random.default_rng(5)
    errors = {"static": [], "planned": []}
    for _ in range(6):
        wanted = rng.uniform(10, 50, 9)
        aim = memory.shape.points(wanted[None], memory.shape.marker_uv)[0]
        for name, path in (
            ("static", paths_to(wanted, np.zeros(9), np.full(9, 60.0), 0.0, SETTLE_S)),
            ("planned", plan_path(wanted, memory).path),
        ):
            plant, now_s = build_plant(rig, tmp_path), 1.0
            plant.command(0.0, np.zeros(9))
            for setpoint, hold_s in zip(path.setpoints_kpa, path.holds_s, strict=True):
                plant.command(now_s, setpoint)
                now_s += hold_s
            errors[name].append(np.sqrt(((plant.markers_mm(now_s) - aim) ** 2).sum(axis=1).mean()))
    assert np.mean(errors["planned"]) < 0.7 * np.mean(errors["static"]), errors


def test_entries_of_the_wrong_size_are_said():
    """Values that do not fit the rig are an error that names the effect."""
    entry = EffectEntry.model_validate(
        {"name": "rest_shape", "parameters": {"offset": {"value": [1.0, 2.0]}}}
    )
    with pytest.raises(LabrigError) as error:
        remembering(entry).after(paths_to(np.full(9, 30.0), np.zeros(9), np.full(9, 60.0), 0.0, 3.0))
    assert str(error.value) == "effect 'rest_shape': 'offset' has 2 values, this surface needs 102"
