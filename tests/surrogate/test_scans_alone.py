"""Scans alone show how a surface moves across itself: what they do not show is not taken for known, and is said."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.surface import Mesh, grid
from labrig.surrogate import Frames, Shot, _sim_to_real, load_model, save_model, train_forward, train_warp
from labrig.surrogate._field_settings import Settings, places_of
from labrig.surrogate._scans import SLIDES, frame_of
from labrig.surrogate._unseen import Unseen, by_gain
from labrig.view import write_sim2real_report

UV, TRIANGLES = grid(31, 31)
AT, _ = grid(9, 9)


@pytest.fixture(scope="module")
def forward(data):
    """A forward model of the simulated sheet."""
    return train_forward(data, samples=6).model


@pytest.fixture(scope="module")
def real(forward):
    """The rig: 1 mm higher where it bulges."""

    def points(pressure_kpa, uv):
        fade = np.sin(np.pi * uv[:, 0]) * np.sin(np.pi * uv[:, 1])
        return forward.points(pressure_kpa, uv) + fade[:, None] * [0.0, 1.0, 0.0]

    return points


@pytest.fixture(scope="module")
def trained(forward, real):
    """What is learned from eight scans of it."""
    pressure = np.random.default_rng(6).random((8, 3)) * 60.0
    noise = 0.03 * np.random.default_rng(7).normal(size=(8, len(UV), 3))
    shots = [
        Shot(f"scan{k}", p, Mesh(real(p[None], UV)[0] + noise[k], TRIANGLES)) for k, p in enumerate(pressure)
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_sim_to_real, "PLACES_ACROSS", 9)
        return train_warp(forward, None, shots, method="scans")


def test_what_scans_do_not_show_is_not_taken_for_known(forward):
    """Deviations are what the dense equations of the process leave open once the normal coordinates alone are known."""
    rng = np.random.default_rng(4)
    settings, gain, gain_sd = Settings.usual(), np.array([0.9, 1.1, 1.0]), np.full(3, 0.1)
    x, new, uv, at = rng.random((4, 3)), rng.random((2, 3)), rng.random((5, 2)), rng.random((3, 2))
    precision, along = rng.random(5) + 0.5, rng.normal(size=(5, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    places, others = places_of(forward, uv, precision), places_of(forward, at)
    across, own = places.towards(others, settings)
    sight = np.zeros((5, 15))
    for q in range(5):
        sight[q, 3 * q : 3 * q + 3] = along[q]

    def moved(fractions, where):
        kpa = forward.low_kpa + fractions * (forward.high_kpa - forward.low_kpa)
        return by_gain(forward, gain, kpa, where).reshape(3, len(fractions), -1)

    G, H = moved(x, uv) @ sight.T, moved(new, at)
    K = np.kron(settings.pressure(x, x), sight @ places.covariance(settings) @ sight.T)
    K += np.einsum("cm,c,cn->mn", G.reshape(3, -1), gain_sd**2, G.reshape(3, -1))
    K += np.diag(np.tile(settings["noise_mm"] ** 2 / precision, 4))
    between = np.kron(settings.pressure(x, new), sight @ across)
    between += np.einsum("cm,c,cn->mn", G.reshape(3, -1), gain_sd**2, H.reshape(3, -1))
    prior = np.tile(settings.variance * own, 2) + np.einsum("cn,c->n", H.reshape(3, -1) ** 2, gain_sd**2)
    left = prior - (between * np.linalg.solve(K, between)).sum(axis=0)
    unseen = Unseen(forward, settings, x, uv, precision, gain, gain_sd, 0.0, along)
    kpa = forward.low_kpa + new * (forward.high_kpa - forward.low_kpa)
    assert unseen.variance(kpa, at) == pytest.approx(left.reshape(2, 3, 3).sum(axis=2), rel=1e-6)


def test_deviations_count_what_scans_do_not_show(trained, real):
    """Deviations hold the error across the surface, and are larger than if points had been seen whole."""
    pressure = np.random.default_rng(8).random((10, 3)) * 60.0
    off = np.linalg.norm(trained.model.points(pressure, AT) - real(pressure, AT), axis=-1)
    sd_mm = trained.model.sd_mm(pressure, AT)
    whole = replace(trained.model, doubt=replace(trained.model.doubt, along=None))
    assert (off <= 1.96 * sd_mm).mean() > 0.9
    assert (sd_mm > 1.2 * whole.sd_mm(pressure, AT)).mean() > 0.9


def test_errors_from_scans_are_said_to_be_across_the_surface(trained, forward, tmp_path):
    """The result, its model and its report say that the error is across the surface; with markers none does."""
    assert "mm across the surface (how points move along it, scans alone do not show)" in trained.left_out
    assert "noise across the surface " in repr(trained.model)
    page = write_sim2real_report(trained, "run", "scans", "rig.pt", tmp_path).read_text(encoding="utf-8")
    assert "mm error across the surface at held-out points" in page
    assert "scans alone do not show how points move along it" in page
    pressure = np.random.default_rng(5).random((6, 3)) * 60.0
    position = forward.points(pressure, forward.marker_uv) + [0.0, 1.0, 0.0]  # noqa: RUF005
    assert "across" not in repr(train_warp(forward, Frames(forward.marker_names, pressure, position)))


def test_a_saved_model_keeps_what_its_scans_showed(trained, tmp_path):
    """Saved and loaded, a model from scans has the same deviations to the last bit."""
    save_model(trained.model, tmp_path / "scans.pt")
    again = load_model(tmp_path / "scans.pt")
    pressure = np.array([[14.0, 33.0, 48.0]])
    assert np.array_equal(again.sd_mm(pressure, AT), trained.model.sd_mm(pressure, AT))
    assert np.array_equal(again.doubt.along, trained.model.doubt.along)


def test_scans_that_can_slide_turn_nothing_and_that_is_said():
    """Scans of a round dome on a flat sheet leave the model where it is, and say that they may lie elsewhere."""
    uv, triangles = grid(41, 41)
    dome = np.stack(
        [200 * uv[:, 0], 20 * np.exp(-((uv - 0.5) ** 2).sum(axis=1) / 0.03), 200 * uv[:, 1]], axis=1
    )
    noise = 0.1 * np.random.default_rng(1).normal(size=(3, *dome.shape))
    shots = [Shot(f"scan{k}", np.zeros(3), Mesh(dome + noise[k], triangles)) for k in range(3)]
    rotation, translation, notes = frame_of(shots, [Mesh(dome, triangles)] * 3)
    assert np.array_equal(rotation, np.eye(3))
    assert np.array_equal(translation, np.zeros(3))
    assert notes == (SLIDES,)
    two = dome + 10 * np.exp(-((uv - [0.2, 0.3]) ** 2).sum(axis=1) / 0.02)[:, None] * [0.0, 1.0, 0.0]
    held = Shot("held", np.zeros(3), Mesh(two + noise[0], triangles))
    assert frame_of([*shots, held], [*[Mesh(dome, triangles)] * 3, Mesh(two, triangles)])[2] == ()
