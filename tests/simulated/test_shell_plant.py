"""Rigs whose plant is a shell: what the model does not know, what streams see, scans, hidden effects, campaigns."""

import logging
import os
import threading
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.physics import (
    ShellSurface,
    Surface,
    load_body,
    load_shell,
    load_surface,
    plant_shell,
    rig_shell,
)
from labrig.rig import load_rig, parse_rig
from labrig_drivers import RealClock, SimulatedClock
from labrig_drivers.simulated import build_plant, hide
from labrig_drivers.simulated._wire_plant import SharedPlant

PLANT = {"count": [12, 12], "shapes": 32, "seed": 5}


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A cache of its own for this module, so that the plant's shapes are solved once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LABRIG_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def rig(**simulated):
    """The content of a rig with the flat membrane of four chambers, coarse."""
    shell = load_shell("membrane4").changed(count=(10, 10)).content()
    return {
        "name": "membrane",
        "chambers": [{"name": f"p{k}", "max_kpa": 50} for k in range(4)],
        "markers": ["m16", "m02", "m07"],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "scanner": {"kind": "simulated"},
        "simulated": {
            "shell": shell,
            "plant": PLANT,
            "seed": 2,
            "noise_mm": 0.0,
            "occlusion": 0.0,
            **simulated,
        },
    }


def load_model(content):
    """The shell as the rig's model knows it."""
    surface = load_surface(content)
    assert isinstance(surface, ShellSurface)
    return surface.shell


def test_the_model_is_the_shell_with_the_rigs_names(cache):
    """`load_surface` gives the nominal shell: the rig's chambers and markers, solved shapes, a mesh."""
    surface = load_surface(rig())
    assert isinstance(surface, ShellSurface)
    assert surface.chamber_names == ("p0", "p1", "p2", "p3")
    assert surface.marker_names == ("m16", "m02", "m07")
    assert surface.parameters["modulus_1_kpa"] == 400.0
    pressure = np.array([[40.0, 3.0, 17.0, 0.0], [0, 0, 0, 0], [np.nan, 0, 0, 0], [40.0, 3.0, 17.0, -1.0]])
    seen = surface.predict(pressure)
    exact = surface.shell.spline.evaluate(surface.shell.solve(pressure[0]).control_mm, surface.marker_uv)
    assert np.abs(seen[0] - exact).max() < 0.03
    np.testing.assert_array_equal(seen[1], surface.rest_mm)
    assert np.isnan(seen[2]).all()
    np.testing.assert_array_equal(seen[3], seen[0])
    np.testing.assert_allclose(surface.normal, [[0, 1, 0]] * 3, atol=1e-12)
    vertices, triangles = surface.mesh(pressure[0])
    assert vertices.shape == (61 * 81, 3)
    assert triangles.max() == 61 * 81 - 1


def test_the_models_derivatives_are_those_of_its_predictions(cache):
    """Jacobians by pressure and by parameter equal differences of predictions and of other shells' shapes."""
    surface = load_surface(rig())
    assert isinstance(surface, ShellSurface)
    pressure = np.array([[31.0, 12.0, 22.0, 40.0]])
    jacobian = surface.jacobian(pressure)
    assert jacobian.shape == (1, 3, 3, 4)
    for chamber in range(4):
        step = 2.0 * np.eye(4)[chamber]
        numeric = (surface.predict(pressure + step) - surface.predict(pressure - step)) / 4.0
        np.testing.assert_allclose(jacobian[..., chamber], numeric, atol=0.03 * np.abs(jacobian).max())
    (by_modulus,) = surface.parameter_jacobian(pressure, ["modulus_1_kpa"])
    softer, stiffer = (
        ShellSurface(surface.shell.changed(modulus_1_kpa=value), surface.marker_names).predict(pressure)[0]
        for value in (396.0, 404.0)
    )
    np.testing.assert_allclose(by_modulus[..., 0], (stiffer - softer) / 8.0, atol=2e-4)


def test_what_took_long_is_kept(cache, monkeypatch):
    """Solved nodes are found again by the next surface of the same shell; a spoilt file is as if it were not there."""
    monkeypatch.setattr("labrig.physics._shell_surface._LONG_S", 0.0)
    shell = load_model(rig())
    pressures = np.random.default_rng(0).uniform(0, 50, (20, 4))
    seen = ShellSurface(shell).predict(pressures)
    by = ShellSurface(shell).parameter_jacobian(pressures[:2], ["modulus_1_kpa"])
    again = ShellSurface(shell)
    monkeypatch.setattr(again, "solve", None)
    np.testing.assert_array_equal(again.predict(pressures), seen)
    np.testing.assert_array_equal(again.parameter_jacobian(pressures[:2], ["modulus_1_kpa"]), by)
    spoilt = max(Path(os.environ["LABRIG_CACHE"]).glob("shell-membrane4-*"), key=lambda f: f.stat().st_mtime)
    for path in spoilt.glob("*.npz"):
        path.write_bytes(b"no file at all")
    np.testing.assert_allclose(ShellSurface(shell).predict(pressures), seen, atol=1e-3)


def test_what_does_not_fit_is_refused(cache):
    """Unknown markers, wrong shapes of pressures and a wrong number of chambers are one line each."""
    surface = load_surface(rig())
    with pytest.raises(LabrigError, match=r"pressures of shape \(3,\) given, \(captures, 4\) needed$"):
        surface.predict(np.zeros(3))
    with pytest.raises(
        LabrigError, match=r"^rig: markers: shell 'membrane4' has no marker 'nose' \(it has m01..m16\)$"
    ):
        load_surface({**rig(), "markers": ["nose"]})
    with pytest.raises(LabrigError, match=r"^rig: chambers: shell 'membrane4' has 4, the rig names 1$"):
        load_surface({**rig(), "chambers": [{"name": "p", "max_kpa": 1}]})


def test_the_plant_has_parameters_that_the_model_has_not(cache):
    """They are drawn with the plant's seed, a mesh of its own, and those that are given are taken."""
    model = load_model(rig())
    plant, again = plant_shell(rig()), plant_shell(rig())
    assert plant.spline.count == (12, 12)
    assert plant.content() == again.content()
    values = {name: parameter.value for name, parameter in plant.parameters.items()}
    off = [name for name, parameter in model.parameters.items() if values.get(name) != parameter.value]
    assert "modulus_1_kpa" in off
    assert "core_offset_mm" in off
    for name in off:
        parameter = plant.parameters[name]
        assert parameter.low <= parameter.value <= parameter.high
    other = plant_shell(rig(plant={**PLANT, "seed": 6}))
    assert other.parameters["modulus_1_kpa"].value != values["modulus_1_kpa"]
    given = plant_shell(rig(plant={**PLANT, "spread": 0.0, "parameters": {"seam_kpa_per_mm": 10.0}}))
    assert given.parameters["seam_kpa_per_mm"].value == 10.0
    assert given.parameters["modulus_1_kpa"].value == 400.0


def test_a_rig_that_names_no_surface_is_the_mannequin_of_other_materials():
    """Without shell or surface the model is the mannequin's shell, and the plant a finer mesh of other materials."""
    bare = {"simulated": {"seed": 4, "noise_mm": 0.1}}
    model, plant = rig_shell(bare), plant_shell(bare)
    assert isinstance(load_surface(bare), ShellSurface)
    assert isinstance(load_surface({"simulated": {"surface": "mannequin"}}), Surface)
    assert model.content() == load_shell("mannequin").content()
    assert plant.spline.count == (34, 34)
    other = {n for n, p in plant.parameters.items() if p.value != model.parameters[n].value}
    assert other == {"modulus_1_kpa", "modulus_2_kpa", "thickness_1_mm", "thickness_2_mm", "seam_kpa_per_mm"}
    assert plant.content() == plant_shell({"simulated": {"seed": 5}}).content()


def test_a_held_plant_shows_the_solved_shape(cache):
    """After settling, markers and scan are the equilibrium of the plant's shell, and not of the model's."""
    plant, model = build_plant(rig(), Path()), load_surface(rig())
    pressure = np.array([44.0, 7.0, 23.0, 31.0])
    plant.pressure_kpa(0.0)
    plant.command(1.0, pressure)
    shell = plant_shell(rig())
    solution = shell.solve(pressure)
    uv = shell.marker_uv[[15, 1, 6]]
    exact = shell.spline.evaluate(solution.control_mm, uv)
    np.testing.assert_allclose(plant.markers_mm(5.0), exact, atol=5e-3)
    vertices, triangles = plant.surface(5.0)
    assert triangles.shape == (2 * 60 * 80, 3)
    nearest = [np.linalg.norm(vertices - point, axis=1).min() for point in exact]
    assert max(nearest) < 3.0
    middle = vertices[40 * 61 + 30]
    np.testing.assert_allclose(middle, shell.spline.evaluate(solution.control_mm, [[0.5, 0.5]])[0], atol=5e-3)
    assert 0.1 < np.linalg.norm(exact - model.predict(pressure[None])[0], axis=1).max() < 10.0


def test_streams_are_smooth_and_depend_on_commands_alone(cache):
    """Frames of a transition have no jumps, whoever looks when, and a set-point that comes back looks the same."""
    first, second = build_plant(rig(), Path()), build_plant(rig(), Path())
    programme = [(1.0, [50.0, 0, 20, 0]), (4.0, [10.0, 40, 0, 0]), (7.0, [50.0, 0, 20, 0])]
    times = np.arange(0.0, 10.0, 0.02)
    pieces = []
    for plant in (first, second):
        plant.pressure_kpa(0.0)
    for k, (time_s, pressure) in enumerate(programme):
        end = programme[k + 1][0] if k + 1 < len(programme) else 10.0
        first.command(time_s, pressure)
        second.command(time_s, pressure)
        pieces += [first.markers_mm(t) for t in times[(times >= time_s) & (times < end)]]
    late = second.observe_frames(times[times >= 1.0])[0]
    np.testing.assert_allclose(np.array(pieces), late, atol=0.05)
    steps = np.linalg.norm(np.diff(late, axis=0), axis=-1).max(axis=1)
    travel = np.linalg.norm(late - late[0], axis=-1).max()
    assert steps.max() < 0.2 * travel
    np.testing.assert_allclose(late[149], late[-1], atol=1e-3)


def test_a_plant_on_wires_is_solved_before_it_is_asked(cache, monkeypatch):
    """A set-point that is held is solved in the background, so that a stream finds it done; ramps are not."""
    plant = build_plant(rig(), Path())
    prepared: list[np.ndarray] = []
    done = threading.Event()
    solve = plant.prepare

    def watched(pressure):
        solve(pressure)
        prepared.append(pressure)
        done.set()

    plant.prepare = watched
    monkeypatch.setattr("labrig_drivers.simulated._wire_plant._HELD_S", 1.5)
    shared = SharedPlant(plant, RealClock())
    for level in (10.0, 20.0, 30.0):
        shared.command(np.full(4, level))
    assert done.wait(60.0)
    np.testing.assert_array_equal(prepared, [np.full(4, 30.0)])


def test_the_quick_shapes_are_near_the_solved_ones(cache):
    """Without a correction the stand-in is within a millimetre or so; a few kPa from a hold, within a tenth."""
    body = load_body(rig())
    random = np.random.default_rng(4)
    pressures = random.uniform(0, 50, (12, 4))
    solved = np.array([body.solved_mm(p) for p in pressures])
    quick = body.shape_mm(body.deflection_mm(pressures))
    assert np.sqrt(np.mean((quick - solved) ** 2)) < 0.5
    nearby = np.clip(pressures + random.normal(0, 2, pressures.shape), 0, 50)
    solved = np.array([body.solved_mm(p) for p in nearby])
    deflection = body.deflection_mm(nearby)
    seen = body.shape_mm(deflection)
    for k, held in enumerate(pressures):
        seen[k] += body.correction_mm(held, deflection[k : k + 1])[0]
    assert np.sqrt(np.mean((seen - solved) ** 2)) < 0.1


def test_deflections_and_pressures_belong_together(cache):
    """A chamber's deflection grows with its pressure, and the law can be read both ways."""
    body = load_body(rig())
    pressure = np.linspace(0, 50, 30)[:, None] * np.ones(4)
    deflection = body.deflection_mm(pressure)
    assert (np.diff(deflection, axis=0) > 0).all()
    np.testing.assert_allclose(body.pressure_kpa(deflection), pressure, atol=1e-9)
    assert body.weight.shape == (3, 4)
    assert body.weight[0].argmax() == 3  # m16 sits on the fourth chamber


def test_the_plants_shapes_are_solved_once(cache, caplog):
    """A second plant of the same rig reads what the first one solved; a spoilt cache is made again."""
    load_body(rig()).shape_mm(np.zeros(4))
    caplog.clear()
    with caplog.at_level(logging.WARNING, "labrig.physics"):
        load_body(rig()).shape_mm(np.zeros(4))
        assert caplog.messages == []
        (folder,) = Path(os.environ["LABRIG_CACHE"]).glob("plant-membrane4-*")
        (folder / "simulations.npz").write_bytes(b"")
        load_body(rig()).shape_mm(np.zeros(4))
    assert caplog.messages == ["labrig: solving 32 shapes of shell membrane4 for the simulated rig, once"]


def test_a_cache_that_cannot_be_written_is_none(tmp_path, monkeypatch):
    """Without a place to keep anything the plant and its model work all the same."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LABRIG_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr("labrig.physics._shell_surface._LONG_S", 0.0)
    body = load_body(rig(plant={**PLANT, "shapes": 16}))
    assert np.isfinite(body.shape_mm(body.deflection_mm(np.full(4, 20.0)))).all()
    assert np.isfinite(ShellSurface(body.shell).predict(np.full(4, 20.0))).all()


@pytest.mark.parametrize("effect", ["creep", "coupling", "gravity"])
def test_hidden_effects_live_in_it(cache, effect):
    """An effect hidden in a shell's plant changes the settled markers by about its amplitude."""
    plain = build_plant(rig(), Path())
    sealed = build_plant(rig(hidden=hide(effect, seed=1)), Path())
    random = np.random.default_rng(1)
    changes = []
    for plant in (plain, sealed):
        plant.pressure_kpa(0.0)
    for k in range(6):
        pressure = random.uniform(0, 50, 4)
        seen = []
        for plant in (plain, sealed):
            plant.command(4.0 * k + 1.0, pressure)
            seen.append(plant.markers_mm(4.0 * k + 4.5))
        changes.append(seen[1] - seen[0])
    assert 0.02 < np.sqrt(np.mean(np.square(changes))) < 5.0


def test_a_campaign_is_captured_on_it(cache, tmp_path):
    """`capture` runs on a rig with a shell, and its markers are the plant's solved shapes."""
    from labrig.campaign import run
    from labrig.log import open_run
    from labrig.rig import connect
    from labrig_procedures import Capture

    content = {**rig(), "simulated": {**rig()["simulated"], "noise_mm": 0.02}}
    path = tmp_path / "rig.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    clock = SimulatedClock()
    with connect(load_rig(path), clock) as connected:
        run(Capture(captures=3, repeated=0), connected, tmp_path / "run", clock)
    seen = open_run(tmp_path / "run")
    shell = plant_shell(content)
    for capture in range(3):
        pressure = seen["commanded"].values[capture]
        exact = shell.spline.evaluate(shell.solve(pressure).control_mm, shell.marker_uv[[15, 1, 6]])
        settled = seen["settled"].values[capture]
        position = np.nanmean(seen["position_mm"].values[capture][settled], axis=0)
        assert np.abs(position - exact).max() < 0.1


@pytest.mark.parametrize(
    ("simulated", "message"),
    [
        ({"shell": "membrane4", "surface": "membrane"}, "simulated: either a surface (the reduced model) or a shell"),
        ({"surface": "membrane", "plant": {}}, "differs from its model: not for a surface (the reduced model)"),
        ({"shell": "nobody"}, "cannot read the shell nobody"),
        ({"shell": 3}, "simulated.shell: the name of a shell, a file, or the content of one is needed"),
        ({"shell": "mannequin"}, "chambers: shell 'mannequin' has 9, the rig names 4"),
        ({"seed": 1}, "shell 'mannequin' has 9, the rig names 4; name a shell with as many chambers: simulated: {"),
        ({"shell": "membrane4", "plant": {"mesh": 3}}, "simulated.plant: there is no 'mesh' (it has count, "),
        ({"shell": "membrane4", "plant": 3}, "simulated.plant: not a mapping"),
        ({"shell": "membrane4", "plant": {"count": 3}}, "simulated.plant: count: [34, 34], spread: 0 to 0.3, vary"),
        ({"shell": "membrane4", "plant": {"parameters": {"x": 1}}}, "shell membrane4: there is no parameter 'x'"),
    ],
)  # fmt: skip
def test_a_rig_file_is_checked_before_anything_is_connected(simulated, message):
    """What is wrong with a shell or its plant is said with the rig's other mistakes."""
    with pytest.raises(LabrigError) as caught:
        parse_rig({**rig(), "simulated": simulated}, "rig.yaml", Path())
    assert str(caught.value).startswith("rig.yaml: ")
    assert message in str(caught.value).replace(str(Path()) + "/", "")
