"""Simulations that do not belong to the others: copies, two shapes at one set of pressures, and one that is far off."""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Bools, Floats, Ints

_SAME = 1e-6
"""Pressures, shares of the range, and shapes, shares of their size, that differ by less are the same."""
_FAR = 3.0
"""A simulation is odd where the others miss it by so many times what they miss the worst of themselves by."""
_MOST = 10
_PER_NUMBER = 2
"""A polynomial needs so many simulations for each of its numbers."""


def copies(fraction: Floats, flat: Floats) -> tuple[Bools, list[tuple[int, int, float]]]:
    """Which of n simulations are copies of an earlier one, (n,); and pairs at the same pressures with other shapes.

    `fraction` (n, C), `flat` (n, D) mm. A pair is the later one, the earlier one, and how far they are apart, mm.
    """
    _, first, which = np.unique(np.round(fraction / _SAME), axis=0, return_index=True, return_inverse=True)
    earlier = first[which.reshape(-1)]
    size = float(np.ptp(flat, axis=0).max(initial=0.0)) + float(np.abs(flat).max(initial=0.0))
    copied, other = np.zeros(len(flat), bool), []
    for k in np.flatnonzero(earlier != np.arange(len(flat))):
        off = float(np.abs(flat[k] - flat[earlier[k]]).max())
        copied[k] = off <= _SAME * size
        if not copied[k]:
            other.append((int(k), int(earlier[k]), off))
    return copied, other


def odd_ones(fraction: Floats, flat: Floats) -> list[tuple[int, float, float]]:
    """Simulations of n that the others miss by far, the worst first; a few among many are found, not half of them.

    Each: its place, and by how much, mm, root mean square, a polynomial of the pressures misses it that was fitted to
    the others, and the worst of these when it is left out in turn.
    """
    features = _features(fraction)
    if len(flat) < _PER_NUMBER * features.shape[1]:
        return []
    kept, left, found = np.ones(len(flat), bool), [], []
    missed = _missed(features, flat, kept)
    for _ in range(min(_MOST, len(flat) // 10)):
        worst = int(np.argmax(np.where(kept, missed, -1.0)))
        kept[worst] = False
        left.append(worst)
        missed = _missed(features, flat, kept)
        usual = float(missed[kept].max())
        if missed[left].min() > _FAR * usual:
            found = sorted(((k, float(missed[k]), usual) for k in left), key=lambda each: -each[1])
    return found


def said_of(
    number: Ints,
    names: Sequence[str],
    pressure_kpa: Floats,
    copied: Bools,
    other: Sequence[tuple[int, int, float]],
    odd: Sequence[tuple[int, float, float]],
) -> tuple[str, ...]:
    """All of that in lines for people; `number` (n,) are the simulations' numbers in their file."""
    said = []
    if copied.any():
        which = ", ".join(str(number[k]) for k in np.flatnonzero(copied)[:_MOST])
        more = f" and {copied.sum() - _MOST} more" if copied.sum() > _MOST else ""
        said.append(f"copies of other simulations, left out: number {which}{more}")
    said += [
        f"number {number[k]} and number {number[j]} are at the same pressures, and {off:.3g} mm apart: one is wrong"
        for k, j, off in other[:_MOST]
    ]
    for k, missed, usual in odd:
        kpa = ", ".join(f"{name} {value:.4g}" for name, value in zip(names, pressure_kpa[k], strict=True))
        said.append(
            f"number {number[k]} ({kpa} kPa) is {missed:.3g} mm off what the others say, none of which is more than "
            f"{usual:.3g} mm off: look at its unit, its pressures and its mesh, and take it out of `converged`"
        )
    return tuple(said)


def _features(x: Floats) -> Floats:
    """A constant, the fractions (n, C), and their products where there are simulations enough for them."""
    line = np.concatenate([np.ones((len(x), 1)), x], axis=1)
    a, b = np.triu_indices(x.shape[1])
    curved = np.concatenate([line, x[:, a] * x[:, b]], axis=1)
    return curved if len(x) >= _PER_NUMBER * curved.shape[1] else line


def _missed(features: Floats, flat: Floats, kept: Bools) -> Floats:
    """How far each shape (n, D) is from what those that are `kept` say, itself left out, mm, (n,)."""
    left, right = np.linalg.qr(features[kept])
    coefficients = np.linalg.lstsq(right, left.T @ flat[kept], rcond=None)[0]
    square = ((flat - features @ coefficients) ** 2).mean(axis=1)
    square[kept] /= np.maximum(1.0 - (left**2).sum(axis=1), 1e-6) ** 2
    return np.sqrt(3.0 * square)
