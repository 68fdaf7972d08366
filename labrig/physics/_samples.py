"""Which pressures to simulate: the corners of the range, and points spread by how far chambers inflate."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig._executor import Executor
from labrig.arrays import Floats
from labrig.physics._shell import Shell, load_shell

_COARSE = 16
LEVELS = np.array([0.0, 0.08, 0.2, 0.4, 0.7, 1.0])
_MOST_DIGITS = 30
_MOST_CORNERS = 0.6
"""All corners are simulated if they are at most this part of all samples; else half as many, drawn."""


def corners(chambers: int, count: int, seed: int) -> NDArray[np.int8]:
    """Rows of zeros and ones, (n, C), in Gray order: all 2^C, or `count` / 2 of them if that is too many."""
    if 2**chambers <= _MOST_CORNERS * count:
        digits = _digits(np.arange(2**chambers), chambers)
    else:
        random, few = np.random.default_rng(seed), max(count // 2, 1)
        drawn = np.sort(random.choice(2 ** min(chambers, _MOST_DIGITS), few, replace=False))
        # of more chambers the others follow by chance: the corners differ already
        others = random.integers(0, 2, (few, max(chambers - _MOST_DIGITS, 0)))
        digits = np.concatenate([_digits(drawn, min(chambers, _MOST_DIGITS)), others], axis=1)
    digits[:, :-1] ^= digits[:, 1:].copy()
    return digits.astype(np.int8)


def _digits(number: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """The binary digits of numbers (n,), lowest first, (n, count)."""
    return (number[:, None] >> np.arange(count)) & 1


def sample_pressures(shell: Shell, count: int, seed: int, executor: Executor) -> tuple[Floats, list[str]]:
    """Pressures (N, C), kPa, and what each is: `corner` or `halton`.

    A Halton sequence (another stretch of it for another seed) fills the unit cube; each coordinate is taken as the
    part of its full inflation that a chamber should have, so that pressures lie densest where the surface moves most.
    """
    at_corner = corners(len(shell.max_kpa), count, seed) * shell.max_kpa
    spread = _halton(count - len(at_corner), len(shell.max_kpa), seed)
    content = {**shell.content(), "control_points": [_COARSE, _COARSE]}
    tasks = [(content, chamber) for chamber in range(len(shell.max_kpa))]
    pressures = np.empty_like(spread)
    for chamber, inflation in executor.map(inflation_curve, tasks):
        rising = np.maximum.accumulate(inflation / inflation[-1])
        pressures[:, chamber] = np.interp(spread[:, chamber], rising, LEVELS) * shell.max_kpa[chamber]
    return np.concatenate([at_corner, pressures]), ["corner"] * len(at_corner) + ["halton"] * len(spread)


def _halton(count: int, dimensions: int, seed: int) -> Floats:
    """`count` points of the sequence (the first one of all, the origin, left out), (count, dimensions)."""
    from scipy.stats import qmc

    sequence = qmc.Halton(dimensions, scramble=False)
    sequence.fast_forward(1 + seed * count)
    return sequence.random(count)


def inflation_curve(task: tuple[dict[str, Any], int]) -> Floats:
    """How far a chamber alone inflates at `LEVELS` of its range, mm on average over its patch.

    Where it has no equilibrium, or is too small for so coarse a mesh, it is taken to inflate in proportion to the
    pressure.
    """
    content, chamber = task
    try:
        shell = load_shell(content)
    except LabrigError:
        return LEVELS.copy()
    quadrature = shell.quadrature
    weight = shell.patch_area_mm2[:, chamber]
    raised, start = [], None
    for level in LEVELS:
        try:
            start = shell.solve(level * shell.max_kpa * (np.arange(len(shell.max_kpa)) == chamber), start)
        except LabrigError:
            break
        moved = quadrature.at_points(start.control_mm.reshape(-1, 3) - quadrature.control_mm)
        raised.append(float((moved * quadrature.normal).sum(1) @ weight / weight.sum()))
    found = len(raised)
    if found < 2:
        return LEVELS.copy()
    curve = np.array(raised) - raised[0]
    return np.concatenate([curve, curve[-1] * LEVELS[found:] / LEVELS[found - 1]])
