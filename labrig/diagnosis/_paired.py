"""The difference between two errors of the same captures, and its interval: a jackknife over blocks of captures."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from labrig._linalg import sums_of
from labrig.arrays import Floats, Ints

LEVEL = 0.95
"""Probability with which an interval holds the difference."""
FEWEST_BLOCKS = 3
"""Blocks of captures from which on there is an interval."""


@dataclass(frozen=True)
class Difference:
    """Error of the first model minus error of the second, with the ends of its interval; NaN where it has none.

    `sd` is its standard error, `blocks` how many blocks of captures it was worked out from.
    """

    value: float
    low: float
    high: float
    sd: float
    blocks: int

    @property
    def nearer(self) -> int | None:
        """Which model is nearer to the measurements, 0 or 1; None where the interval holds zero, or there is none."""
        if self.low > 0:
            return 1
        return 0 if self.high < 0 else None


@dataclass(frozen=True)
class BlockSums:
    """Squares summed by block: `square` and `count`, each (parts, blocks, columns).

    A mean square is the sum over the parts of square / count, averaged over the columns that were seen.
    """

    square: Floats
    count: Floats

    def rms(self) -> float:
        """Root mean square over all blocks."""
        return float(_rms(self.square.sum(axis=1), self.count.sum(axis=1)))

    def in_pairs(self) -> "BlockSums":
        """The sums of half as many blocks: of each and its neighbour."""
        starts = np.arange(0, self.square.shape[1], 2)
        return BlockSums(
            np.add.reduceat(self.square, starts, axis=1), np.add.reduceat(self.count, starts, axis=1)
        )

    def rms_without(self) -> Floats:
        """Root mean squares without each block in turn, (blocks,)."""
        square = self.square.sum(axis=1, keepdims=True) - self.square
        count = self.count.sum(axis=1, keepdims=True) - self.count
        return _rms(np.moveaxis(square, 1, 0), np.moveaxis(count, 1, 0))


def by_block(parts: list[tuple[Floats, Ints]], blocks: int) -> BlockSums:
    """Sum squares (n, K), NaN where nothing was seen, by the block (n,) of each row; one pair for each part."""
    shape = (len(parts), blocks, parts[0][0].shape[1])
    square, count = np.zeros(shape), np.zeros(shape)
    for p, (values, block) in enumerate(parts):
        seen = np.isfinite(values)
        square[p] = sums_of(block, np.where(seen, values, 0.0), blocks)
        count[p] = sums_of(block, seen.astype(float), blocks)
    return BlockSums(square, count)


def difference(first: BlockSums, second: BlockSums, level: float = LEVEL) -> Difference:
    """The difference of two errors over the same cells, with an interval at `level`.

    The jackknife that leaves out blocks of unequal size (Busing, Meijer and van der Leeden 1999, Statistics and
    Computing 9:3), and Student's t of one degree of freedom less than there are blocks. Captures of one block may
    depend on each other. Where neighbouring blocks may too, which shows as a larger standard error when they are left
    out in pairs, that error counts. With fewer than three blocks there is no interval.
    """
    value = first.rms() - second.rms()
    sd, blocks = _jackknife(first, second)
    if blocks >= 2 * FEWEST_BLOCKS:
        larger, fewer = _jackknife(first.in_pairs(), second.in_pairs())
        if larger > sd:
            sd, blocks = larger, fewer
    half = float(stdtrit(blocks - 1, 0.5 + level / 2)) * sd if blocks >= FEWEST_BLOCKS else np.nan
    return Difference(value, value - half, value + half, sd, blocks)


def _jackknife(first: BlockSums, second: BlockSums) -> tuple[float, int]:
    """Standard error of the difference, NaN with too few blocks, and how many blocks hold anything."""
    weight = first.count.sum(axis=(0, 2))
    used = weight > 0
    blocks = int(used.sum())
    without = (first.rms_without() - second.rms_without())[used]
    if blocks < FEWEST_BLOCKS or not np.isfinite(without).all():
        return np.nan, blocks
    share = weight[used] / weight[used].sum()
    times = 1 / share
    value = first.rms() - second.rms()
    estimate = blocks * value - ((1 - share) * without).sum()
    pseudo = times * value - (times - 1) * without
    return float(np.sqrt((((pseudo - estimate) ** 2) / (times - 1)).mean())), blocks


def _rms(square: Floats, count: Floats) -> Floats:
    """Roots of mean squares from sums (..., parts, columns)."""
    seen = count.sum(axis=-2) > 0
    each = (square / np.maximum(count, 1)).sum(axis=-2)
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where(seen, each, 0.0).sum(axis=-1) / seen.sum(axis=-1))
