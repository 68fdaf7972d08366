"""The field between simulation and reality: what it says is what the dense equations of a Gaussian process say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from labrig.surrogate._field import Seen, coordinates, infer
from labrig.surrogate._field_settings import Grid, Places, Settings, Spatial, fit_settings
from labrig.surrogate._left_out import left_out
from labrig.surrogate._unseen import unseen

J, Q, C, K = 5, 4, 2, 6


@pytest.fixture
def problem():
    """Frames, places, two directions; some places seen whole, some along a direction, some not at all."""
    rng = np.random.default_rng(1)
    places = Places(
        rng.normal(size=(3 * Q, K)), rng.random(K) + 0.1, 80 * rng.normal(size=(Q, 3)), rng.random(Q) + 0.5
    )
    known = np.tile(np.eye(3), (J, Q, 1, 1))
    known[0, 0] = 0.0
    for j, q in ((1, 1), (2, 3), (4, 0)):
        n = rng.normal(size=3)
        known[j, q] = np.outer(n, n) / (n @ n)
    value = rng.normal(size=(J, Q, 3))
    value[0, 0] = np.nan
    seen = Seen(rng.random((J, C)), value, known, rng.normal(size=(2, J, Q, 3)), np.array([0.3, 0.7]))
    return seen, places, Settings.usual()


def _dense(seen, places, settings):
    """Prior covariance of all coordinates of all frames (J 3 Q) without noise, and the noise's variances."""
    kernel = settings.kernel(C)
    bent = kernel.bent(seen.x)
    P = settings["still"] ** 2 + settings["moving"] ** 2 * kernel.covariance(bent, bent)
    G = seen.directions.reshape(2, -1)
    prior = np.kron(P, places.covariance(settings)) + (G.T * seen.direction_sd**2) @ G
    noise = settings["noise_mm"] ** 2 / np.tile(np.repeat(places.precision, 3), J)
    return prior, noise


def test_inference_is_exact(problem):
    """Displacements and directions' sizes are those of the dense equations, whatever was seen of each place."""
    seen, places, settings = problem
    prior, noise = _dense(seen, places, settings)
    projector = np.zeros((J * Q * 3, J * Q * 3))
    for j in range(J):
        for q in range(Q):
            own = slice(3 * (j * Q + q), 3 * (j * Q + q) + 3)
            projector[own, own] = seen.known[j, q]
    wanted = projector @ np.nan_to_num(seen.value_mm).ravel()
    matrix = projector @ prior @ projector + np.diag(noise)
    alpha = np.linalg.solve(matrix, wanted)
    found = infer(seen, places.covariance(settings), places.precision, settings)
    assert np.allclose(found.expected.ravel(), prior @ projector @ alpha, atol=1e-4)
    theta = seen.direction_sd**2 * (seen.directions.reshape(2, -1) @ projector @ alpha)
    assert np.allclose(found.theta, theta, atol=1e-4)


def test_likelihood_is_exact(problem):
    """The marginal likelihood on a full grid is that of the dense normal distribution, up to a constant."""
    seen, places, _ = problem
    value = np.nan_to_num(seen.value_mm).reshape(J, -1)
    root = np.repeat(np.sqrt(places.precision), 3)
    directions = seen.directions.reshape(2, J, -1)
    differences = []
    for shift in (0.0, 0.2):
        settings = Settings(Settings.usual().values + shift)
        spatial = Spatial(places.covariance(settings), root)
        grid = Grid(seen.x, spatial, directions * root, seen.direction_sd, settings)
        prior, noise = _dense(seen, places, settings)
        exact = multivariate_normal(np.zeros(J * Q * 3), prior + np.diag(noise)).logpdf(value.ravel())
        differences.append(grid.cost(value * root) + exact)
    assert differences[0] == pytest.approx(differences[1], abs=1e-6)


def test_what_was_left_out(problem):
    """Errors are of predictions that used neither the frame nor the place: far off data changes only its own."""
    seen, places, settings = problem
    covariance = places.covariance(settings)
    posterior = infer(seen, covariance, places.precision, settings)
    left = left_out(seen, covariance, places.precision, posterior)
    value = seen.value_mm.copy()
    value[3, 2] += 1000.0
    changed = replace(seen, value_mm=value)
    again = left_out(changed, covariance, places.precision, posterior)
    assert again.both_mm[3, 2] == pytest.approx(np.sqrt(3.0) * 1000.0, rel=0.01)
    assert np.allclose(again.both_mm[3, [0, 1, 3]], left.both_mm[3, [0, 1, 3]], atol=1e-2)
    assert np.isnan(left.both_mm[0, 0])
    assert (left.both_mm2[seen.used] > left.frames_mm2[seen.used]).mean() > 0.8


@pytest.mark.parametrize("part", [slice(0, 1), slice(0, 5)])
def test_what_cannot_be_left_out_is_not_known(problem, part):
    """With one frame, or one place, nothing is said of errors, above all not that there are none."""
    seen, places, settings = problem
    frames, which = np.arange(J)[part], np.arange(Q if part.stop == 1 else 1) + (part.stop == 1)
    which = which[which < Q]
    few, own = seen.part(frames, which), coordinates(which)
    covariance = places.covariance(settings)[np.ix_(own, own)]
    posterior = infer(few, covariance, places.precision[which], settings)
    assert np.isnan(left_out(few, covariance, places.precision[which], posterior).both_mm).all()


def test_variance_is_exact(problem):
    """What is not known of other frames and places is what the dense equations leave open, directions included."""
    seen, places, settings = problem
    rng = np.random.default_rng(4)
    others = Places(rng.normal(size=(9, K)), places.size, 80 * rng.normal(size=(3, 3)), np.ones(3))
    x, directions = rng.random((2, C)), rng.normal(size=(2, 2, 9))
    across, own = places.towards(others, settings)
    prior, noise = _dense(seen, places, settings)
    pressure = settings.pressure(seen.x, x)
    G = seen.directions.reshape(2, -1)
    matrix = prior + np.diag(noise)
    root = np.repeat(np.sqrt(places.precision), 3)
    spatial = Spatial(places.covariance(settings), root)
    grid = Grid(seen.x, spatial, seen.directions.reshape(2, J, -1) * root, seen.direction_sd, settings)
    found = unseen(grid, pressure, own, across * root[:, None], directions)
    for f in range(2):
        towards = np.kron(pressure[:, f : f + 1], across) + (G.T * seen.direction_sd**2) @ directions[:, f]
        there = settings.variance * own + (directions[:, f] ** 2 * seen.direction_sd[:, None] ** 2).sum(
            axis=0
        )
        expected = there - (towards * np.linalg.solve(matrix, towards)).sum(axis=0)
        assert np.allclose(found[f], expected, atol=1e-8)


def test_settings_find_the_noise():
    """The noise that data were drawn with is found again."""
    rng = np.random.default_rng(3)
    places = Places(rng.normal(size=(30, K)), np.ones(K), 80 * rng.normal(size=(10, 3)), np.ones(10))
    x, truth = rng.random((25, C)), Settings.usual()
    kernel = truth.kernel(C)
    P = truth["still"] ** 2 + truth["moving"] ** 2 * kernel.covariance(kernel.bent(x), kernel.bent(x))
    roots = [np.linalg.cholesky(m + 1e-9 * np.eye(len(m))) for m in (P, places.covariance(truth))]
    value = roots[0] @ rng.normal(size=(25, 30)) @ roots[1].T + 0.05 * rng.normal(size=(25, 30))
    none = np.zeros((0, 25, 30))
    found = fit_settings(x, value, none, np.zeros(0), lambda s: Spatial(places.covariance(s), np.ones(30)))
    assert found["noise_mm"] == pytest.approx(0.05, rel=0.2)


def test_coordinates():
    """The three coordinates of places stand one after the other."""
    assert coordinates(np.array([0, 2])).tolist() == [0, 1, 2, 6, 7, 8]
