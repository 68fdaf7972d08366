"""From simulation to reality: what each method makes of markers, incomplete frames and scans of a small rig."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from xarray import Dataset

import labrig
from labrig import LabrigError, surrogate
from labrig.surface import Mesh, grid
from labrig.surrogate import Frames, Shot, _sim_to_real, load_model, save_model, train_forward, train_warp
from labrig.view import write_sim2real_report

NAMES = tuple(f"m{i + 1:02d}" for i in range(9))
UV, TRIANGLES = grid(21, 21)


@pytest.fixture(scope="module", autouse=True)
def _few_places():
    """Scans are matched at 81 places, half as many as otherwise: enough for so small a sheet."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_sim_to_real, "PLACES_ACROSS", 9)
        yield


@pytest.fixture(scope="module")
def reality(shapes):
    """Control points of a rig whose chambers push otherwise than simulated, and which leans a little."""
    return partial(_reality, shapes)


def _reality(shapes, pressure_kpa, spline):
    control, _ = shapes(pressure_kpa * np.array([0.9, 1.1, 0.95]), spline)
    control[..., 1] += 0.3 * np.sin(np.pi * control[..., 0] / 200.0) * np.sin(np.pi * control[..., 2] / 200.0)
    return control


@pytest.fixture(scope="module")
def forward(data):
    """A forward model of the simulated sheet."""
    return train_forward(data, samples=6).model


@pytest.fixture(scope="module")
def frames(data, reality):
    """Sixteen frames of nine markers, 0.02 mm of noise, a third of them incomplete."""
    rng = np.random.default_rng(5)
    pressure = rng.random((16, 3)) * 60.0
    position = data.spline.evaluate(reality(pressure, data.spline), data.marker_uv)
    position += 0.02 * rng.normal(size=position.shape)
    for frame in range(0, 16, 3):
        position[frame, rng.integers(9)] = np.nan
    return Frames(NAMES, pressure, position)


@pytest.fixture(scope="module")
def shots(data, reality):
    """Six scans, each with a hole, none of which says which point is which."""
    rng = np.random.default_rng(6)
    made = []
    for number, pressure in enumerate(rng.random((6, 3)) * 60.0):
        points = data.spline.evaluate(reality(pressure[None], data.spline)[0], grid(31, 31)[0])
        uv, triangles = grid(31, 31)
        hole = np.linalg.norm(uv - rng.random(2), axis=1) < 0.12
        mesh = Mesh(points + 0.03 * rng.normal(size=points.shape), triangles[~hole[triangles].any(axis=1)])
        made.append(Shot(f"scan{number}", pressure, mesh))
    return made


@pytest.fixture(scope="module")
def error(data, reality):
    """Distances from reality at pressures that nothing was learned from."""
    pressure = np.random.default_rng(7).random((20, 3)) * 60.0
    real = data.spline.evaluate(reality(pressure, data.spline), UV)
    return lambda model: np.linalg.norm(model.points(pressure, UV) - real, axis=-1)


def test_ours_from_markers(forward, frames, error):
    """Markers, complete or not, take most of the error off the whole surface."""
    fixed = train_warp(forward, frames).model
    assert error(fixed).mean() < 0.25 * error(forward).mean()


def test_a_corrected_model_says_the_noise_that_it_found(forward, frames):
    """The markers' 0.02 mm, which stand in the field's settings, and not 0."""
    said = repr(train_warp(forward, frames).model)
    assert 0.005 < float(said.split("noise ")[1].removesuffix(" mm")) < 0.1


def test_ours_from_scans(forward, shots, error):
    """Scans without correspondences and without any marker take most of the error off as well."""
    trained = train_warp(forward, None, shots, method="scans")
    assert error(trained.model).mean() < 0.5 * error(forward).mean()
    assert 0.0 <= trained.model.confidence.min() < trained.model.confidence.max() <= 1.0


def test_both(forward, frames, shots, error):
    """Markers and scans together are used together."""
    few = frames.take(slice(0, 4))
    both = train_warp(forward, few, shots, method="both")
    assert both.facts["scans"] == 6
    assert error(both.model).mean() < 0.3 * error(forward).mean()


def test_confidence_falls_where_scans_have_holes(forward, shots):
    """Where half of the scans show nothing, the confidence is at most a half."""
    cut = []
    for number, shot in enumerate(shots):
        keep = (
            shot.mesh.vertices_mm[:, 0] < 100.0 if number % 2 else np.ones(len(shot.mesh.vertices_mm), bool)
        )
        triangles = shot.mesh.triangles[keep[shot.mesh.triangles].all(axis=1)]
        cut.append(Shot(shot.name, shot.pressure_kpa, Mesh(shot.mesh.vertices_mm, triangles)))
    model = train_warp(forward, None, cut, method="scans").model
    there = model.confidence_at(np.array([[0.8, 0.5]]))[0]
    here = model.confidence_at(np.array([[0.25, 0.5]]))[0]
    assert there < 0.55
    assert here > there


def test_deviations_are_honest(forward, frames, error):
    """About 95 % of the real surface lies within 1.96 standard deviations, and they are no wider than that needs."""
    fixed = train_warp(forward, frames).model
    pressure = np.random.default_rng(7).random((20, 3)) * 60.0
    sd_mm = fixed.sd_mm(pressure, UV)
    inside = error(fixed) <= 1.96 * sd_mm
    assert 0.85 < inside.mean() <= 1.0
    assert sd_mm.mean() < 2.0 * error(fixed).mean()


@pytest.mark.parametrize("bent", [0.0, 2.0])
def test_deviations_at_markers_are_not_those_of_their_noise(forward, data, reality, bent):
    """At markers, at new set-points, deviations hold the model's error and are near to it, not to ten times as much."""

    def real(pressure):
        shift = bent * np.sin(3 * data.marker_uv[None, :, :1]) * [0.0, 1.0, 0.0]
        return data.spline.evaluate(reality(pressure, data.spline), data.marker_uv) + shift

    held, ratio = [], []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        pressure, new = rng.random((20, 3)) * 60.0, rng.random((40, 3)) * 60.0
        noise = 0.1 * rng.normal(size=(20, 9, 3))
        model = train_warp(forward, Frames(NAMES, pressure, real(pressure) + noise)).model
        off = np.linalg.norm(model.points(new, data.marker_uv) - real(new), axis=-1)
        sd_mm = model.sd_mm(new, data.marker_uv)
        held.append((off <= 1.96 * sd_mm).mean())
        ratio.append(sd_mm.mean() / off.mean())
    assert np.mean(held) > 0.9
    assert np.mean(ratio) < 2.5


@pytest.mark.parametrize(("count", "markers"), [(20, 1), (1, 9)])
def test_what_one_marker_or_one_set_point_says(forward, data, reality, count, markers, tmp_path):
    """With nothing to leave out no error is claimed, deviations hold what is really off, and it is said."""
    pressure = np.random.default_rng(5).random((count, 3)) * 50.0
    place = data.marker_uv[:markers]
    position = data.spline.evaluate(reality(pressure, data.spline), place)
    position += [0.0, 2.0, 0.0] * np.sin(3 * place[None, :, :1])
    trained = train_warp(forward, Frames(NAMES[:markers], pressure, position))
    assert len(trained.fixed_mm) == len(trained.simulated_mm) == 0
    said = (
        "nothing was left out, so how far it is off is not known: that takes two set-points and two markers"
    )
    assert repr(trained).endswith(said)
    assert said[1:] in write_sim2real_report(trained, "run", "ours", "rig.pt", tmp_path).read_text()
    new = np.random.default_rng(7).random((20, 3)) * 50.0
    real = data.spline.evaluate(reality(new, data.spline), data.marker_uv)
    real += [0.0, 2.0, 0.0] * np.sin(3 * data.marker_uv[None, :, :1])
    off = np.linalg.norm(trained.model.points(new, data.marker_uv) - real, axis=-1)
    assert (off <= 1.96 * trained.model.sd_mm(new, data.marker_uv)).mean() > 0.6


def test_deviations_of_older_files(forward, frames, tmp_path):
    """A model from before a field's doubt was kept has the deviations of its grid, times the doubt of its pressures."""
    now = train_warp(forward, frames).model
    older = replace(now, doubt=None, noise_mm=0.1, field_mm=np.array([[1.0, 2.0]]), factor=0.5)
    save_model(older, tmp_path / "older.pt")
    pressure = np.array([[14.0, 33.0, 48.0]])
    doubt = now.head.doubt(now.forward.fraction(pressure))[0]
    simulated = now.forward.sd_mm(pressure, [[0.3, 0.5]])[0, 0]
    expected = 0.5 * np.sqrt(0.1**2 + (1.5 * doubt) ** 2 + simulated**2)
    assert load_model(tmp_path / "older.pt").sd_mm(pressure, [[0.3, 0.5]])[0, 0] == pytest.approx(expected)


@pytest.mark.parametrize("method", ["ours", "function", "marker"])
def test_jacobian(method, forward, frames):
    """The derivative by the pressures is that of central differences, through network, warp and linear system."""
    model = train_warp(forward, frames, method=method, calibrate=False).model
    a = np.array([[14.0, 33.0, 48.0]])
    uv = UV[::50]
    J = model.jacobian(a, uv)
    for c in range(3):
        step = 1e-4 * np.eye(3)[c]
        numeric = (model.points(a + step, uv) - model.points(a - step, uv)) / 2e-4
        assert np.allclose(J[..., c], numeric, atol=5e-5)


@pytest.mark.parametrize("method", ["ours", "function", "marker"])
def test_warp_state(method, forward, frames):
    """A warp by itself gives the model's points, and its derivative is that of central differences."""
    model = train_warp(forward, frames, method=method, calibrate=False).model
    a = np.array([14.0, 33.0, 48.0])
    assert np.allclose(model.warp(a).apply(model.forward.points(a, UV)[0]), model.points(a, UV)[0], atol=1e-9)
    change = model.warp_state(a)[1]
    step = 1e-4 * np.eye(3)[1]
    numeric = (model.warp_state(a + step)[0] - model.warp_state(a - step)[0]) / 2e-4
    assert np.allclose(change[..., 1], numeric, rtol=1e-3, atol=1e-4 * np.abs(numeric).max())


@pytest.mark.parametrize("method", ["ours", "function", "marker"])
def test_round_trip(method, forward, frames, tmp_path):
    """A fixed model that was saved predicts the same bits when it is loaded."""
    model = train_warp(forward, frames, method=method, calibrate=False).model
    save_model(model, tmp_path / "fixed.pt")
    loaded = load_model(tmp_path / "fixed.pt")
    a = np.array([[14.0, 33.0, 48.0]])
    for name in ("points", "jacobian", "sd_mm"):
        assert np.array_equal(getattr(loaded, name)(a, UV), getattr(model, name)(a, UV))
    assert loaded.provenance == model.provenance


def test_rig_in_another_frame(forward, frames, data, reality):
    """A rig whose coordinates are turned and shifted is learned in its own coordinates."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = Frames(NAMES, frames.pressure_kpa, frames.position_mm @ turn.T + np.array([500.0, 0.0, 20.0]))
    fixed = train_warp(forward, moved).model
    pressure = np.random.default_rng(7).random((5, 3)) * 60.0
    real = data.spline.evaluate(reality(pressure, data.spline), UV) @ turn.T + np.array([500.0, 0.0, 20.0])
    assert np.linalg.norm(fixed.points(pressure, UV) - real, axis=-1).mean() < 0.6
    step = 1e-4 * np.eye(3)[0]
    numeric = (fixed.points(pressure + step, UV) - fixed.points(pressure - step, UV)) / 2e-4
    assert np.allclose(fixed.jacobian(pressure, UV)[..., 0], numeric, atol=5e-5)


@pytest.mark.parametrize("marker", [0, 4, 8])
def test_one_marker_says_nothing_of_a_turn(forward, frames, marker, error):
    """The way of one marker is not taken for a turn of the rig: the rest of the surface stays where it is."""
    alone = np.arange(len(NAMES)) == marker
    seen = replace(frames, position_mm=np.where(alone[:, None], frames.position_mm, np.nan))
    fixed = train_warp(forward, seen).model
    assert np.array_equal(fixed.rotation, np.eye(3))
    assert error(fixed).max() < 8.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda p: p / 1000, r"times as far apart as the model's: are their places in mm\?"),
        (lambda p: p * [-1, 1, 1], "are a mirror image of the model's"),
        (lambda p: p[..., [0, 2, 1]], "are a mirror image of the model's"),
        (lambda p: p[:, [0, 7, 2, 3, 4, 5, 6, 1, 8]], "m02 and m08 are each where the model has the other"),
    ],
    ids=["metres", "mirrored", "y up", "names"],
)
def test_markers_that_cannot_be_the_models(forward, frames, change, message):
    """Metres, a left-handed frame and exchanged names are refused by what they are, and no rig is learned from them."""
    with pytest.raises(LabrigError, match=message):
        train_warp(forward, replace(frames, position_mm=change(frames.position_mm)))


@pytest.mark.parametrize("order", [[1, 0, 2], [1, 2, 0]], ids=["two", "three"])
def test_chambers_that_are_exchanged(forward, frames, order):
    """Tubes on each other's chambers are refused and named, not learned as a difference between rig and simulator."""
    exchanged = replace(frames, pressure_kpa=frames.pressure_kpa[:, order])
    run, model = forward.chamber_names[0], forward.chamber_names[order[0]]
    with pytest.raises(LabrigError, match=f"the run's {run} is the model's {model}"):
        train_warp(forward, exchanged)


def test_scans_in_another_frame(forward, shots, error):
    """Scans whose coordinates are not the simulator's are brought there first."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = [Shot(s.name, s.pressure_kpa, s.mesh.moved(turn, [400.0, -30.0, 9.0])) for s in shots]
    fixed = train_warp(forward, None, moved, method="scans").model
    assert error(fixed).mean() < 0.4


def test_function_learns_from_incomplete_frames(forward, frames):
    """N_rbf uses frames with missing markers: without them it is another one; N_mk can't."""
    whole = frames.take(frames.complete)
    with_all = train_warp(forward, frames, method="function", calibrate=False).model
    with_whole = train_warp(forward, whole, method="function", calibrate=False).model
    assert not np.allclose(with_all.points([30.0] * 3, UV), with_whole.points([30.0] * 3, UV))
    markers = [train_warp(forward, f, method="marker", calibrate=False).model for f in (frames, whole)]
    assert np.array_equal(markers[0].points([30.0] * 3, UV), markers[1].points([30.0] * 3, UV))


def test_what_is_missing_is_said(forward, frames, shots):
    """Methods without the data that they need say so."""
    with pytest.raises(LabrigError) as caught:
        train_warp(forward, None, shots)
    assert str(caught.value) == "sim2real: the method ours needs markers; the run has none"
    with pytest.raises(LabrigError) as caught:
        train_warp(forward, frames, method="scans")
    assert str(caught.value) == "sim2real: the method scans needs scans; the run has none"
    incomplete = frames.take(~frames.complete)
    with pytest.raises(LabrigError) as caught:
        train_warp(forward, incomplete, method="marker")
    assert str(caught.value) == (
        "sim2real: the method marker needs 2 frames with every marker, the run has 0; "
        "other methods use incomplete frames too"
    )


@pytest.fixture
def runs(frames, monkeypatch):
    """Two opened runs, the second with the last ten of the sixteen frames."""
    opened = [Dataset({"commanded": ("capture", [0.0])}) for _ in range(2)]
    parts = {id(opened[0]): frames.take(slice(0, 6)), id(opened[1]): frames.take(slice(6, 16))}
    monkeypatch.setattr(surrogate, "frames_of", lambda run, chambers: parts[id(run)])
    return opened


def test_all_runs_are_used(forward, runs, shots, monkeypatch):
    """Of a list of runs all markers and all scans are learned from; `frames` counts from the first run on."""
    assert labrig.train_sim2real(runs, forward).facts["frames"] == 16
    assert labrig.train_sim2real(runs, forward, frames=8).facts["frames"] == 8
    monkeypatch.setattr(
        surrogate, "shots_of", lambda folder, chambers: shots[:4] if folder.name == "a" else shots[4:]
    )
    assert labrig.train_sim2real(["a", "b"], forward, method="scans").facts["scans"] == 6


@pytest.mark.parametrize("count", [0, -5, 2.5, True, "3"])
def test_a_number_of_frames_is_a_number(forward, runs, count):
    """No frames, fewer than none, and what is no whole number are refused in one line."""
    with pytest.raises(LabrigError) as caught:
        labrig.train_sim2real(runs, forward, frames=count)
    assert str(caught.value) == f"frames {count!r}: how many are used is a whole number, 1 or more"


@pytest.mark.parametrize("method", ["ours", "both", "function"])
def test_errors_before_and_after_are_of_the_same_points(forward, frames, shots, method):
    """As simulated and as fixed are compared over the same points, also where set-points come back."""
    pytest.importorskip("torch")
    twice = Frames(
        NAMES,
        np.concatenate([frames.pressure_kpa, frames.pressure_kpa[:5]]),
        np.concatenate([frames.position_mm, frames.position_mm[:5] + 0.01]),
    )
    trained = train_warp(forward, twice, shots if method == "both" else [], method=method)
    assert len(trained.simulated_mm) == len(trained.fixed_mm) > 0
    if method != "function":  # the paper's network wants more frames
        assert trained.fixed_mm.mean() < trained.simulated_mm.mean()
