"""Points with derivatives against what the machine must at least take for them."""

from typing import Any

import numpy as np

from _ik.setup import clock
from labrig.ik import evaluator
from labrig.surface import grid

SAMPLES = 134


def measured_rates() -> dict[str, float]:
    """What one core does: products in 32 bits, copies, exponentials."""
    rng = np.random.default_rng(0)
    a, b = (rng.random((512, 512), dtype=np.float32) for _ in range(2))
    block = rng.random(2_000_000, dtype=np.float32)
    copied = np.empty_like(block)
    small = -rng.random(100_000, dtype=np.float32)
    out = np.empty_like(small)
    return {
        "flop_s": 2 * 512**3 / clock(lambda: a @ b),
        "byte_s": 2 * block.nbytes / clock(lambda: np.copyto(copied, block)),
        "exp_s": len(small) / clock(lambda: np.exp(small, out=out)),
    }


def floor_s(model: Any, points: int, rates: dict[str, float], centers: int = 0) -> float:
    """The least time: every sum and product at the speed of a large product, every exponential at the speed of many,

    and every number of the result written once. Without the latent coordinates, which do not depend on the points.
    """
    chambers, modes = len(model.low_kpa), len(model.modes_mm)
    width = 3 * (1 + chambers)
    flops = (
        2 * modes * model.spline.size * 3 * (1 + chambers)
        + 2 * points * (model.spline.degree + 1) ** 2 * width
    )
    if centers:
        flops += 2 * points * centers * (3 + 12 + 12 * chambers) + 2 * points * 3 * chambers * 7
    return flops / rates["flop_s"] + 4 * points * width / rates["byte_s"] + points * centers / rates["exp_s"]


class Warp:
    """A warp as learned ones are, for its cost: 34 centers whose coefficients follow the latent coordinates."""

    def __init__(self, forward: Any, count: int = 34) -> None:
        rng = np.random.default_rng(7)
        self.forward, self.chamber_names = forward, forward.chamber_names
        self.low_kpa, self.high_kpa, self.c = forward.low_kpa, forward.high_kpa, 3e-5
        self.marker_uv = rng.uniform(0.08, 0.92, (count, 2))
        self._base = np.concatenate([np.zeros((1, 3)), np.eye(3), rng.normal(0, 0.3, (count, 3))])
        self._by_pressure = 1e-3 * rng.normal(0, 1, (*self._base.shape, len(self.low_kpa)))
        self._by_pressure[:4] *= 1e-2

    def warp_state(self, pressure_kpa: Any) -> tuple[Any, Any]:
        """Coefficients and their derivatives."""
        return self._base + self._by_pressure @ pressure_kpa, self._by_pressure


def measure(model: Any) -> dict[str, float]:
    """Times, s: 17,956 points with derivatives, without the latent coordinates; floors; 729 points altogether."""
    rates = measured_rates()
    pressure = 0.4 * model.high_kpa
    uv, _ = grid(SAMPLES, SAMPLES)
    plain = evaluator(model, uv)
    latent = plain.latent(pressure)  # type: ignore[attr-defined]
    few = evaluator(model, grid(27, 27)[0])
    warp = Warp(model)
    warped = evaluator(warp, uv)
    latent_s = clock(lambda: plain.latent(pressure))  # type: ignore[attr-defined]
    return {
        "latent_s": latent_s,
        "plain_s": clock(lambda: plain.at(*latent)),  # type: ignore[attr-defined]
        "plain_floor_s": floor_s(model, len(uv), rates),
        "warped_s": clock(lambda: warped(pressure)) - latent_s,
        "warped_floor_s": floor_s(model, len(uv), rates, len(warp.marker_uv)),
        "few_s": clock(lambda: few(pressure)),
        "gflop_s": rates["flop_s"] / 1e9,
    }
