"""Points that fill a cube: scipy.stats has them too, and takes half a second of every run's start to be imported."""

import itertools
import math
from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats

_BITS = 54
"""Digits that are smaller than 2^-54 are nothing beside 1."""


def halton(count: int, dimensions: int, rng: np.random.Generator) -> Floats:
    """`count` points (count, dimensions) of a Halton sequence whose digits are permuted by chance.

    A. B. Owen, A randomized Halton algorithm in R, arXiv:1706.02808, 2017. They are those of `scipy.stats.qmc.Halton`.
    """
    own = rng.spawn(1)[0]
    points = np.zeros((count, dimensions))
    for values, base in zip(points.T, _primes(), strict=False):
        left, worth = np.arange(count), 1.0 / base
        for _ in range(math.ceil(_BITS / math.log2(base)) - 1):
            permuted = np.arange(base)
            own.shuffle(permuted)
            values += permuted[left % base] * worth
            left //= base
            worth /= base
    return points


def _primes() -> Iterator[int]:
    found: list[int] = []
    for n in itertools.count(2):
        if all(n % prime for prime in found):
            found.append(n)
            yield n
