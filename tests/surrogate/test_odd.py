"""Simulations that do not belong to the others are named by their number before anything is learned from them."""

from typing import Any

import numpy as np
import pytest

from labrig.physics import Simulations, load_shell
from labrig.surface import grid
from labrig.surrogate import training_set


@pytest.fixture
def made() -> dict[str, Any]:
    """Sixty shapes of a sheet that four chambers bulge, as the arrays of a file of simulations."""
    shell = load_shell("membrane4").changed(count=(8, 8))
    x = np.random.default_rng(0).random((60, 4))
    uv, _ = grid(8, 8)
    bumps = np.exp(
        -8.0 * ((uv[:, None] - [[0.3, 0.3], [0.7, 0.3], [0.3, 0.7], [0.7, 0.7]]) ** 2).sum(axis=-1)
    )
    rise = 15.0 * np.log1p(2.0 * x) @ bumps.T
    flat = np.stack([np.tile(200.0 * uv[:, 0], (60, 1)), rise, np.tile(200.0 * uv[:, 1], (60, 1))], axis=-1)
    ones = np.ones(60)
    return {
        "pressure_kpa": x * shell.max_kpa,
        "control_mm": flat.reshape(60, 8, 8, 3),
        "kind": np.array(["halton"] * 60),
        "residual": 0 * ones,
        "converged": ones.astype(bool),
        "jacobian": None,
        "cpu_s": ones,
        "shell": shell.content(),
    }


def test_simulations_that_are_alike_are_left_as_they_are(made: dict[str, Any]) -> None:
    """Nothing is said of shapes that belong together, and all of them are learned from."""
    data = training_set(Simulations(**made), "sims")
    assert (len(data), data.notes) == (60, ())


@pytest.mark.parametrize("fault", ["metres", "exploded", "pressures"])
def test_one_bad_simulation_among_many_is_named(made: dict[str, Any], fault: str) -> None:
    """A wrong unit, a torn mesh or another's pressures: the file, the number, and how far it is off."""
    if fault == "metres":
        made["control_mm"][17] *= 1e-3
    elif fault == "exploded":
        made["control_mm"][17, 3, 3] += 500.0
    else:
        made["pressure_kpa"][17] = made["pressure_kpa"][17, ::-1]
    (said,) = training_set(Simulations(**made), "sims").notes
    assert said.startswith("sims: number 17 (c1 ")
    assert " mm off what the others say" in said


def test_copies_count_once_and_two_shapes_of_one_pressure_are_named(made: dict[str, Any]) -> None:
    """A copy would be learned from and tested on; of two shapes at the same pressures one is wrong."""
    for name in ("pressure_kpa", "control_mm"):
        made[name][40] = made[name][5]
    made["pressure_kpa"][50] = made["pressure_kpa"][20]
    made["control_mm"][50] = made["control_mm"][20] + [0.0, 0.5, 0.0]
    data = training_set(Simulations(**made), "sims")
    assert (len(data), data.source["copies"]) == (59, 1)
    assert data.notes == (
        "sims: copies of other simulations, left out: number 40",
        "sims: number 50 and number 20 are at the same pressures, and 0.5 mm apart: one is wrong",
    )
