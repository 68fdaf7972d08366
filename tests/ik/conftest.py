"""Models that are quick to evaluate and true: a quick surface, and a control net in a reduced basis with a warp."""

import numpy as np
import pytest

from labrig.ik import Solver
from labrig.ik._models import SurfaceModel
from labrig.physics import load_surface
from labrig.surface import Mesh, Spline, grid


class Net:
    """A control net whose coordinates are smooth functions of the pressures."""

    def __init__(self, chambers=4, modes=6):
        rng = np.random.default_rng(0)
        self.chamber_names = tuple(f"c{c + 1}" for c in range(chambers))
        self.low_kpa, self.high_kpa = np.zeros(chambers), np.full(chambers, 60.0)
        self.spline = Spline((12, 14), 2)
        self.mean_mm = self.spline.interpolate(
            lambda u, v: np.stack(
                [150 * np.sin(2.4 * (u - 0.5)), 100 * np.cos(2.2 * (u - 0.5)) + 12 * u * v, 400 * v], axis=-1
            )
        )
        u, v = np.meshgrid(np.linspace(0, 1, 12), np.linspace(0, 1, 14), indexing="ij")
        bumps = [
            np.exp(-(((u - a) / 0.15) ** 2) - ((v - b) / 0.15) ** 2)
            for a, b in rng.uniform(0.2, 0.8, (modes, 2))
        ]
        out = self.mean_mm - [0.0, 0.0, 200.0]
        self.modes_mm = 25.0 * np.stack(bumps)[..., None] * out / np.linalg.norm(out, axis=-1, keepdims=True)
        self.mix = np.concatenate([np.eye(chambers), rng.uniform(0, 0.4, (modes - chambers, chambers))])

    def latent(self, pressure_kpa):
        x = np.asarray(pressure_kpa) / 60.0
        return self.mix @ np.tanh(x), self.mix * (1 - np.tanh(x) ** 2) / 60.0

    def points(self, pressure_kpa, uv):
        control = [
            self.mean_mm + np.tensordot(self.latent(p)[0], self.modes_mm, 1)
            for p in np.atleast_2d(pressure_kpa)
        ]
        return self.spline.evaluate(np.array(control), uv)

    def jacobian(self, pressure_kpa, uv):
        slopes = [np.tensordot(self.latent(p)[1].T, self.modes_mm, 1) for p in np.atleast_2d(pressure_kpa)]
        return np.moveaxis(self.spline.evaluate(np.array(slopes), uv), 1, -1)


class WarpedNet:
    """The same behind a warp whose coefficients follow the pressures."""

    def __init__(self, forward):
        rng = np.random.default_rng(1)
        self.forward, self.c = forward, 3e-5
        self.chamber_names, self.low_kpa, self.high_kpa = (
            forward.chamber_names,
            forward.low_kpa,
            forward.high_kpa,
        )
        self.marker_uv = rng.uniform(0.1, 0.9, (9, 2))
        self.base = np.concatenate([rng.normal(0, 1, (1, 3)), np.eye(3) + rng.normal(0, 0.01, (3, 3))])
        self.base = np.concatenate([self.base, rng.normal(0, 2, (9, 3))])
        self.by_latent = 0.05 * rng.normal(0, 1, (*self.base.shape, len(forward.modes_mm)))
        self.by_latent[1:4] *= 0.02

    def warp_state(self, pressure_kpa):
        z, slope = self.forward.latent(pressure_kpa)
        return self.base + self.by_latent @ z, self.by_latent @ slope

    def points(self, pressure_kpa, uv):
        out = []
        for p in np.atleast_2d(pressure_kpa):
            x, q = self.forward.points(p, uv)[0], self.forward.points(p, self.marker_uv)[0]
            gamma, _ = self.warp_state(p)
            bells = np.exp(-self.c * ((x[:, None] - q) ** 2).sum(axis=-1))
            out.append(gamma[0] + x @ gamma[1:4] + bells @ gamma[4:])
        return np.array(out)


@pytest.fixture(scope="session")
def mannequin():
    """The quick surface of the mannequin as a model, nine chambers."""
    return SurfaceModel(load_surface({"simulated": {"surface": "mannequin"}}))


@pytest.fixture(scope="session")
def solver(mannequin):
    return Solver(mannequin)


@pytest.fixture(scope="session")
def net():
    return Net()


@pytest.fixture(scope="session")
def warped(net):
    return WarpedNet(net)


@pytest.fixture(scope="session")
def make_target():
    """A scan of a model's surface: noise of 0.1 mm, turned and shifted."""

    def make(model, pressure_kpa, rotation=None, shift=None, seed=0, count=(71, 81)):
        uv, triangles = grid(*count)
        points = model.points(np.asarray(pressure_kpa, float)[None], uv)[0]
        points = points + np.random.default_rng(seed).normal(0, 0.1, points.shape)
        if rotation is not None:
            points = (points - shift) @ rotation
        return Mesh(points, triangles)

    return make
