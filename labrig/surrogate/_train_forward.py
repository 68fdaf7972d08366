"""Training of forward models: labrig's Gaussian process, networks, and the network of the source paper."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from labrig._linalg import svd
from labrig.arrays import Floats
from labrig.surface import grid
from labrig.surrogate._calibration import NORMAL_95, calibrated
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._gaussian import fit_gaussian
from labrig.surrogate._models import save_model
from labrig.surrogate._network import Network, NetworkHead
from labrig.surrogate._provenance import provenance
from labrig.surrogate._torch_training import Recipe, train_network
from labrig.surrogate._training_set import TrainingSet

Method = Literal["gaussian", "network", "paper"]

PAPER = Recipe((128, 128), "relu", batch_norm=True, epochs=150, batch=32, rate=1e-3)
OURS = Recipe((256, 256, 256), "gelu", epochs=400, batch=32, rate=3e-3, one_cycle=True)
_MEMBERS = 3
_MODES = 160
_TAIL = 2e-4
"""Share of the variance (its root) that the modes may leave out."""
_CALIBRATION_SHARE = 0.85
_FOLDS = 5
TEST_GRID = 134
"""Samples of the surface in each direction at which errors are measured: 17,956 in all."""


_LEVELS = np.linspace(0.0, 1.0, 101)


@dataclass(frozen=True)
class Measured:
    """Errors on shapes that were not learned from.

    `summary`: mean, p95, p99, max and the worst shape's mean, mm; the share within the 95 % interval; the rank
    correlation of a shape's error with its doubt. `by_place` (n_u, n_v) and `by_shape` (n,) are mean errors, mm;
    `ratio` (101,) percentiles of the error over the standard deviation.
    """

    summary: dict[str, float]
    by_place: Floats
    by_shape: Floats
    ratio: Floats


@dataclass(frozen=True)
class Trained:
    """A forward model, how it did, and what processor time it took, s; `notes` of what it was learned from."""

    model: ForwardModel
    fit_s: float
    calibration_s: float
    measured: Measured
    notes: tuple[str, ...] = ()

    @property
    def errors(self) -> dict[str, float]:
        """The summary of its errors."""
        return self.measured.summary

    def save(self, path: str | Path) -> None:
        """Write the model, in one piece or not at all."""
        save_model(self.model, path)

    def __repr__(self) -> str:
        mean, worst = self.errors["mean_mm"], self.errors["max_mm"]
        return f"Trained in {self.fit_s:.1f} s: {self.model!r}\nleft out: mean {mean:.3g} mm, at most {worst:.3g} mm"


def train_forward(
    data: TrainingSet,
    method: Method = "gaussian",
    share: float = 0.7,
    seed: int = 0,
    recipe: Recipe | None = None,
    samples: int = TEST_GRID,
    calibrate: bool = True,
) -> Trained:
    """Learn from a share of the shapes and measure on the others.

    Methods: `gaussian`, a Gaussian process on a reduced basis; `network`, an ensemble of GELU networks on it; `paper`,
    the network of the source paper, which uses no slopes. `recipe` is a network's, if not the usual one. Without
    `calibrate` standard deviations mean nothing. Raises `LabrigError` for too few shapes.
    """
    learn, test = data.split(share, seed)
    own = data.take(learn)
    started = time.process_time()
    model, left_out = _METHODS[method](own, seed, recipe)
    fitted = time.process_time()
    if not calibrate:
        pass
    elif left_out is None:
        inner, outer = own.split(_CALIBRATION_SHARE, seed + 1)
        other, _ = _METHODS[method](own.take(inner), seed, recipe)
        beside = own.take(outer)
        missed = other.control(beside.pressure_kpa) - beside.control_mm
        model = calibrated(model, missed.reshape(len(beside), -1), other.head.doubt(beside.fraction))
    else:
        model = calibrated(model, *left_out())
    done = time.process_time()
    measured = measure_errors(model, data.take(test), samples)
    settings = {"method": method, "share": share, "seed": seed, "slopes": data.slopes is not None}
    if method != "gaussian":
        chosen = recipe or (PAPER if method == "paper" else OURS)
        settings |= {k: v for k, v in vars(chosen).items() if method == "network" or k != "slope_weight"}
    settings["hidden"] = list(settings["hidden"]) if "hidden" in settings else []
    facts = provenance("forward", settings) | {
        "source": data.source,
        "split": {"learn": learn.tolist(), "test": test.tolist()},
        "test": measured.summary,
    }
    return Trained(replace(model, provenance=facts), fitted - started, done - fitted, measured, data.notes)


def measure_errors(model: ForwardModel, data: TrainingSet, samples: int = TEST_GRID) -> Measured:
    """Distances between predicted and simulated surface, and how often the intervals hold them."""
    uv, _ = grid(samples, samples)
    basis = data.spline.basis(uv)
    missed = (model.control(data.pressure_kpa) - data.control_mm).reshape(len(data), -1, 3)
    error = np.stack([np.linalg.norm(basis @ one, axis=1) for one in missed])
    ratio = error / model.sd_mm(data.pressure_kpa, uv)
    by_shape = error.mean(axis=1)
    ranked = _rank_correlation(model.head.doubt(data.fraction), by_shape)
    summary = {
        "shapes": float(len(data)),
        "samples": float(len(uv)),
        "mean_mm": float(error.mean()),
        "p95_mm": float(np.quantile(error, 0.95)),
        "p99_mm": float(np.quantile(error, 0.99)),
        "max_mm": float(error.max()),
        "worst_shape_mm": float(by_shape.max()),
        "coverage_95": float((ratio <= NORMAL_95).mean()),
    } | ({} if ranked is None else {"doubt_rank": ranked})
    return Measured(
        summary, error.mean(axis=0).reshape(samples, samples).T, by_shape, np.quantile(ratio, _LEVELS)
    )


def _rank_correlation(a: Floats, b: Floats) -> float | None:
    """Spearman's, None where one of them is constant."""
    if np.ptp(a) == 0 or np.ptp(b) == 0:
        return None
    from scipy.stats import rankdata  # half a second, so only where it is needed

    return float(np.corrcoef(rankdata(a), rankdata(b))[0, 1])


def _reduced(data: TrainingSet) -> tuple[Floats, Floats, Floats]:
    """Mean (D,), orthonormal modes (K, D) and coordinates (n, K) of the shapes."""
    mean = data.flat.mean(axis=0)
    _, size, modes = svd(data.flat - mean)
    left = np.sqrt(np.maximum(1.0 - np.cumsum(size**2) / max(float((size**2).sum()), 1e-300), 0.0))
    count = min(_MODES, int((left > _TAIL).sum()) + 1, len(size))
    modes = modes[:count]
    return mean, modes, (data.flat - mean) @ modes.T


def _latent_slopes(data: TrainingSet, modes: Floats) -> Floats | None:
    """Slopes of the coordinates by the fraction of the range, (n, K, C), or None."""
    slopes = data.flat_slopes()
    if slopes is None:
        return None
    return np.stack([modes @ one for one in slopes.astype(float)])


def _model(data: TrainingSet, mean: Floats, modes: Floats, head: Any) -> ForwardModel:
    nu, nv = data.spline.count
    modes = np.ascontiguousarray(modes, dtype=np.float32).astype(float)  # as they are kept in a file
    return ForwardModel(
        chamber_names=data.chamber_names,
        low_kpa=data.low_kpa,
        high_kpa=data.high_kpa,
        spline=data.spline,
        mean_mm=mean.reshape(nu, nv, 3),
        modes_mm=modes.reshape(-1, nu, nv, 3),
        head=head,
        spread=np.zeros((len(modes), 1)),
        factor=1.0,
        marker_names=data.marker_names,
        marker_uv=data.marker_uv,
    )


_LeftOut = Callable[[], tuple[Floats, Floats]]
"""Errors of control points (n, D) and the head's doubt (n,) at shapes left out."""


def _gaussian(data: TrainingSet, seed: int, recipe: Recipe | None) -> tuple[ForwardModel, _LeftOut]:
    mean, modes, z = _reduced(data)
    head, errors = fit_gaussian(data.fraction, z, _latent_slopes(data, modes))
    return _model(data, mean, modes, head), lambda: (
        errors @ modes + _outside(data, len(modes)),
        head.left_out_doubt(),
    )


def _outside(data: TrainingSet, count: int) -> Floats:
    """What of each shape (n, D) is in none of the modes that the other shapes have."""
    left = np.empty_like(data.flat)
    fold = np.arange(len(data)) % _FOLDS
    for k in range(_FOLDS):
        there = data.flat[fold != k]
        mean = there.mean(axis=0)
        modes = svd(there - mean)[2][:count]
        moved = data.flat[fold == k] - mean
        left[fold == k] = moved - moved @ modes.T @ modes
    return left


def _network(data: TrainingSet, seed: int, recipe: Recipe | None) -> tuple[ForwardModel, None]:
    mean, modes, z = _reduced(data)
    scale = float(z[:, 0].std())
    slopes = _latent_slopes(data, modes)
    members = tuple(
        train_network(
            data.fraction,
            z / scale,
            recipe or OURS,
            1000 * seed + k,
            None if slopes is None else slopes / scale,
        )
        for k in range(_MEMBERS)
    )
    return _model(data, mean, modes, NetworkHead(members, scale)), None


def _paper(data: TrainingSet, seed: int, recipe: Recipe | None) -> tuple[ForwardModel, None]:
    """Translations of the control points from the mean shape; its last layer serves as modes."""
    mean = data.flat.mean(axis=0)
    net = train_network(data.fraction, data.flat - mean, recipe or PAPER, seed)
    weight, bias = net.layers[-1]
    head = NetworkHead((Network(net.layers[:-1], net.activation, linear_end=False),))
    return _model(data, mean + bias, weight.T, head), None


_METHODS: dict[str, Callable[..., tuple[ForwardModel, _LeftOut | None]]] = {
    "gaussian": _gaussian,
    "network": _network,
    "paper": _paper,
}
