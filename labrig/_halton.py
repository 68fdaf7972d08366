"""Halton's sequence, by itself: SciPy's comes with all of its statistics, for which every campaign would wait."""

from collections.abc import Iterator
from itertools import count, islice

import numpy as np

from labrig.arrays import Floats

_DIGITS = 54
"""Binary digits of a share, and one more: what is smaller changes nothing."""


def halton(points: int, dimensions: int, *, first: int = 0, rng: np.random.Generator | None = None) -> Floats:
    """`points` of the sequence from the one numbered `first` on, (points, dimensions), each 0 to 1 (without 1).

    With `rng` digits are permuted (Owen, A randomized Halton algorithm in R, 2017), another time for each call. The
    numbers are those of `scipy.stats.qmc.Halton`, to the last digit.
    """
    own = rng.spawn(1)[0] if rng is not None else None
    columns = [_column(points, base, first, own) for base in islice(_primes(), dimensions)]
    return np.array(columns).T.reshape(points, dimensions)


def _column(points: int, base: int, first: int, rng: np.random.Generator | None) -> Floats:
    """Numbers whose digits to a base are mirrored at the point: van der Corput's sequence."""
    digits = int(np.ceil(_DIGITS / np.log2(base))) - 1
    digit = np.repeat(np.arange(base)[None], digits, axis=0)
    if rng is not None:
        for each in digit:
            rng.shuffle(each)
    left, share, out = np.arange(first, first + points), 1.0 / base, np.zeros(points)
    for each in digit:
        out += each[left % base] * share
        share /= base
        left //= base
    return out


def _primes() -> Iterator[int]:
    found: list[int] = []
    for number in count(2):
        if all(number % prime for prime in found):
            found.append(number)
            yield number
