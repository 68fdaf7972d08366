"""The plant: valves, noise, occlusion, determinism, and effects of the size that was asked for."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from labrig.physics import reduced_surface
from labrig_drivers import DeviceError, MarkerStatus, SimulatedClock
from labrig_drivers.simulated import build_plant, hide, reveal, seal
from labrig_drivers.simulated._calibration import reference_programme, run_programme
from labrig_drivers.simulated._plant import make_hidden
from labrig_drivers.simulated._wire_plant import SharedPlant
from labrig_drivers.simulated.hidden import EFFECTS


def rig(**simulated: object) -> dict:
    """A simulated rig with the reduced surface, which is quick."""
    return {"simulated": {"surface": "mannequin", **simulated}}


def test_a_chamber_fills_through_its_valve() -> None:
    """Pressure follows a first-order lag of 0.15 s and then stays at the set-point."""
    plant = build_plant(rig(), Path())
    plant.pressure_kpa(100.0)
    plant.command(101.0, np.full(9, 40.0))
    after = plant.pressures_kpa(101.0 + np.array([0.15, 0.30, 3.0]))
    np.testing.assert_allclose(after[:, 0], 40.0 * (1.0 - np.exp([-1.0, -2.0, -20.0])), atol=0.05)


def test_without_anything_hidden_the_settled_plant_is_the_base_simulator() -> None:
    """True positions after settling are what `labrig.physics` predicts."""
    plant = build_plant(rig(), Path())
    pressure = np.linspace(5.0, 60.0, 9)
    plant.command(0.0, pressure)
    np.testing.assert_allclose(plant.markers_mm(4.0), reduced_surface({}).predict(pressure)[0], atol=1e-6)


def test_the_past_may_be_asked_for_after_the_present() -> None:
    """Devices that look late see the same plant as those that looked in time."""
    first, second = build_plant(rig(), Path()), build_plant(rig(), Path())
    for plant in (first, second):
        plant.pressure_kpa(0.0)
        plant.command(1.0, np.full(9, 30.0))
    early = [first.pressure_kpa(t) for t in (1.1, 1.2, 5.0)]
    second.pressure_kpa(9.0)
    late = [second.pressure_kpa(t) for t in (1.1, 1.2, 5.0)]
    np.testing.assert_allclose(early, late, atol=0.03)


@pytest.mark.parametrize("effect", ["hysteresis", "creep", "friction", "delay"])
def test_looking_often_changes_nothing(effect: str) -> None:
    """Memory effects evolve alike however often the plant is polled in between."""
    quick = rig(hidden=hide(effect, seed=1))
    often, seldom = build_plant(quick, Path()), build_plant(quick, Path())
    random = np.random.default_rng(0)
    for plant in (often, seldom):
        plant.pressure_kpa(0.0)
    for k in range(6):
        pressure = random.uniform(0.0, 60.0, 9)
        for plant in (often, seldom):
            plant.command(4.0 * k, pressure)
        for t in np.arange(0.05, 4.0, 0.13):
            often.markers_mm(4.0 * k + t)
    np.testing.assert_allclose(often.markers_mm(24.0), seldom.markers_mm(24.0), atol=1e-9)


def test_noise_is_what_the_documentation_says() -> None:
    """Frames scatter by noise_mm; means of holds scatter by hypot(repeatability, noise / sqrt(n))."""
    plant = build_plant(rig(occlusion=0.0), Path())
    true = plant.rest_mm
    means, scatter = [], []
    for k in range(1, 60):
        plant.command(10.0 * k, np.full(9, 1e-9 * (k % 2)))
        seen, _ = plant.observe_frames(10.0 * k + 5.0 + 0.01 * np.arange(20))
        means.append(seen.mean(axis=0) - true)
        scatter.append(seen.std(axis=0, ddof=1))
    assert np.sqrt(np.mean(np.square(scatter))) == pytest.approx(0.1, rel=0.03)
    assert np.sqrt(np.mean(np.square(means))) == pytest.approx(plant.capture_floor_mm, rel=0.03)
    assert plant.capture_floor_mm == pytest.approx(np.hypot(0.1, 0.1 / np.sqrt(20)))


def test_an_occluded_marker_stays_so_in_its_hold() -> None:
    """Occlusion has the rate asked for, lasts through a hold, and is NaN with the status that says why."""
    plant = build_plant(rig(occlusion=0.1), Path())
    whole = []
    for k in range(1, 200):
        plant.command(5.0 * k, np.full(9, float(k % 2)))
        seen, status = plant.observe_frames(5.0 * k + 3.0 + 0.05 * np.arange(20))
        assert np.array_equal(np.isnan(seen[..., 0]), status == MarkerStatus.OCCLUDED)
        whole.append((status == MarkerStatus.OCCLUDED).all(axis=0))
    assert 0.07 < np.mean(whole) < 0.13
    by_marker = np.mean(whole, axis=0)
    assert by_marker.max() > 2.0 * by_marker.min()


def test_the_same_seed_gives_the_same_campaign_and_another_does_not() -> None:
    """Noise, occlusion and hidden effects follow from the seed alone."""

    def frame(seed: int) -> np.ndarray:
        plant = build_plant(rig(seed=seed, hidden=hide("friction", seed=4)), Path())
        plant.command(0.0, np.full(9, 25.0))
        return plant.observe(5.0)[0]

    np.testing.assert_array_equal(frame(1), frame(1))
    assert not np.array_equal(frame(1), frame(2))


@pytest.mark.parametrize("name", list(EFFECTS))
@pytest.mark.parametrize("rms_mm", [0.1, 1.0])
def test_a_hidden_effect_has_the_size_that_was_asked_for(name: str, rms_mm: float) -> None:
    """Over the reference campaign every effect changes the markers by its amplitude."""
    surface, high = reduced_surface({}), np.full(9, 60.0)
    made = make_hidden(hide(name, seed=5, amplitude=rms_mm), surface, high, 0.1)
    programme = reference_programme(high)
    change = run_programme(surface, made, programme)[1] - run_programme(surface, [], programme)[1]
    assert np.sqrt(np.mean(change**2)) == pytest.approx(rms_mm, rel=0.03)


def test_creep_goes_on_and_recovers() -> None:
    """Under load the surface goes on moving out; after a long hold and a vent it comes back slowly."""
    plant = build_plant(rig(hidden=hide("creep", seed=2)), Path())
    normal = reduced_surface({}).normal
    plant.command(0.0, np.full(9, 50.0))
    out = [np.sum(normal * plant.markers_mm(t), axis=-1).mean() for t in (3.0, 30.0, 300.0)]
    plant.command(300.0, np.zeros(9))
    back = [np.sum(normal * (plant.markers_mm(t) - plant.rest_mm), axis=-1).mean() for t in (303.0, 330.0)]
    assert out[0] < out[1] < out[2]
    assert back[0] > back[1] > 0.0


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_hysteresis_depends_on_the_side_but_not_on_the_time(seed: int) -> None:
    """A set-point reached from above lies further out than from below, and stays put in the hold."""
    plant = build_plant(rig(hidden=hide("hysteresis", seed=seed)), Path())
    for k, level in enumerate([60.0, 0.0, 30.0, 60.0, 30.0]):
        plant.command(5.0 * k, np.full(9, level))
    lower, higher = (np.sum(reduced_surface({}).normal * plant.markers_mm(t)) for t in (14.5, 24.9))
    assert higher > lower + 5.0
    np.testing.assert_allclose(plant.markers_mm(24.9), plant.markers_mm(34.9), atol=1e-6)


def test_a_sealed_effect_is_not_readable_and_is_revealed(tmp_path: Path) -> None:
    """The sealed file does not show what it hides; `reveal` gives back exactly what was sealed."""
    hidden = hide("coupling", seed=9, amplitude=2.0, unit="floors")
    path = seal(tmp_path, hidden)
    assert b"coupling" not in path.read_bytes()
    assert reveal(tmp_path) == hidden
    plant = build_plant(rig(hidden="sealed.json"), tmp_path)
    plant.command(0.0, np.full(9, 60.0))
    assert np.abs(plant.markers_mm(5.0) - reduced_surface({}).predict(np.full(9, 60.0))[0]).max() > 0.2


def test_what_cannot_be_hidden_or_revealed_is_said(tmp_path: Path) -> None:
    """Unknown effects, missing and damaged seals are one line each."""
    with pytest.raises(
        DeviceError, match=r"^simulated: hidden: there is no effect 'magic' \(known: nothing, "
    ):
        hide("magic")
    with pytest.raises(DeviceError) as error:
        reveal(tmp_path)
    assert (
        str(error.value)
        == f"simulated: {tmp_path / 'sealed.json'} does not exist: copy it from where rig.yaml was "
        "made, or take `hidden:` out of rig.yaml"
    )
    (tmp_path / "sealed.json").write_text('{"sealed": "zzz"}', encoding="utf-8")
    with pytest.raises(DeviceError) as error:
        reveal(tmp_path)
    assert str(error.value) == f"simulated: {tmp_path / 'sealed.json'} is no sealed file, or damaged"


def test_pressures_do_not_wait_for_a_shape_that_is_worked_out() -> None:
    """A controller answers and takes commands while the cameras' picture of the surface is still being made."""
    import threading

    plant = build_plant(rig(), Path())
    shared = SharedPlant(plant, SimulatedClock(0.0))
    looking, go_on = threading.Event(), threading.Event()
    shape_mm = plant._surface.shape_mm

    def slow(deflection_mm: np.ndarray) -> np.ndarray:
        looking.set()
        assert go_on.wait(30.0)
        return shape_mm(deflection_mm)

    plant._surface = SimpleNamespace(shape_mm=slow)  # type: ignore[assignment]
    seen: list[np.ndarray] = []
    camera = threading.Thread(target=lambda: seen.append(shared.observe()[0]))
    camera.start()
    assert looking.wait(30.0)
    shared.command(np.full(9, 20.0))
    shared.clock.sleep(3.0)
    assert shared.pressure_kpa() == pytest.approx(np.full(9, 20.0), abs=0.5)
    assert not seen
    go_on.set()
    camera.join()
    assert seen[0].shape == plant.rest_mm.shape
