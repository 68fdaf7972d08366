"""Observations: what a campaign says about a model's error, as independent numbers of unit noise."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import helmert
from scipy.sparse import csr_matrix

from labrig._gaps import filled
from labrig._linalg import rms, sums_of, svd
from labrig._turns import commonest_unit
from labrig.arrays import Floats, Ints
from labrig.diagnosis._constants import INDEPENDENT, INEXACT, PER_CONDITION
from labrig.diagnosis._floor import Floor
from labrig.effects import Context, capture_means

_CROWD = 12
"""Rows that a hold counts as at most: neighbours of a long record say nearly the same."""
_MOST = 0.9
"""Share of the observables in which noise within holds is no larger than is taken for all."""


def worth_of(numbers: float, conditions: int, inexact: float = 1.0) -> float:
    """The power to which the likelihood of each number is taken, of so many `numbers` of so many `conditions`.

    Errors of a model are alike in neighbours, so that not all numbers are independent. No law is exact, either: by
    `inexact` (1: not at all) the square of the noise is too small.
    """
    return min(1.0, min(INDEPENDENT, PER_CONDITION * conditions) / max(numbers, 1)) / inexact


@dataclass(frozen=True)
class Counted:
    """How many numbers, captures and conditions a campaign has, and by what factor laws that are not exact make the
    square of the noise larger, `inexact`.
    """

    numbers: int
    captures: int
    conditions: int
    inexact: float = 1.0

    @property
    def of_a_capture(self) -> float:
        """How many numbers a capture has, in the mean."""
        return self.numbers / self.captures


@dataclass(frozen=True)
class Observations:
    """S independent observations of K observables: captures' means first, then contrasts within their holds.

    `values` (S, K) in units of their own noise; `unit` (K,) is the noise of a mean; `whiten` (S, F) carries rows, in
    floors, to observations; `capture` (S,) numbers the captures 0..n-1; `index` (F,) that of each row; `still` makes
    the noise as large in what all markers share as in each of them.
    """

    context: Context
    floor: Floor
    unit: Floats
    values: Floats
    whiten: csr_matrix
    capture: Ints
    index: Ints
    left: Floats
    """What is left of the noise's square in each (S,), where the base was fitted to the campaign."""
    whole: NDArray[np.bool_]
    """Which captures (n,) have something of all observables that were ever seen: of the others gaps were filled."""
    still: "Still"

    @property
    def n_captures(self) -> int:
        """How many captures there are; their means are the first observations."""
        return int(self.index.max()) + 1

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Which observables (K,) were ever seen."""
        return np.isfinite(self.context.rows.values).sum(axis=0) > 0

    def unit_size(self, counted: Ints) -> float:
        """How large a floor is in some observables (n,) of one unit, in it: the noise of a mean, root mean square."""
        return rms(self.unit[counted])

    @cached_property
    def slopes(self) -> Floats:
        """How far, in floors, each chamber's whole range would move each capture, (n, K, C), as the base says there."""
        context = self.context
        return (context.jacobian * context.span / self.unit[None, :, None])[self.first]

    def shaking(self, shaken: Floats) -> "Observations":
        """The observations where the frame shakes, by `shaken` (K, m) in the observables' units; see `Floor.shaken`."""
        still = Still.beside(shaken / self.unit[:, None])
        return replace(
            self, floor=replace(self.floor, shaken=shaken), values=still.of(self.values), still=still
        )

    def of_rows(self, values: Floats, whiten: csr_matrix | None = None) -> Floats:
        """Rows (F, q), in floors, as observations (S, q); `whiten` in another precision, if given.

        The first row of each capture is taken off meanwhile: so what is constant in a hold has contrasts of exactly 0.
        """
        start = values[self.first]
        out = np.asarray((self.whiten if whiten is None else whiten) @ (values - start[self.index]))
        out[: len(start)] += start
        return out

    @cached_property
    def to_explain(self) -> float:
        """How much more than noise there is in the rows of what was seen, root mean square, in floors.

        Captures' means and what changes within them are counted each by itself: where the noise within holds was taken
        for too large, that takes nothing off what the means say.
        """
        beyond = (self.values[:, self.seen] ** 2).sum(axis=1) - self.left * self.seen.sum()
        means, within = np.split(self.counts_for * beyond, [self.n_captures])
        return float(np.sqrt(max(means.sum(), 0.0) + max(within.sum(), 0.0)))

    @property
    def within(self) -> float:
        """The noise within holds, as a part of that of a capture's mean."""
        return _within(self.context, self.floor, self.unit)

    @cached_property
    def counts_for(self) -> Floats:
        """The weight (S,) of each observation's square in the mean square over the rows and what was seen."""
        count = np.bincount(self.capture, minlength=self.n_captures).astype(float)
        weight = np.concatenate([count, np.full(len(self.values) - len(count), self.within**2)])
        return weight / (count.sum() * self.seen.sum())

    def size_of(self, values: Floats, noise: float = 0.0) -> float:
        """How large observations (S, K) are over the rows of what was seen, root mean square in floors, without the
        `noise` that each has by variance.
        """
        square = (values[:, self.seen] ** 2).sum(axis=1) - noise * self.seen.sum()
        return float(np.sqrt(max(self.counts_for @ square, 0.0)))

    @cached_property
    def curves(self) -> Floats:
        """Curves of the set-points, orthonormal as observations count, (S, q): polynomials of the pressures up to the
        third degree, and of a programme of levels any function of each chamber's; no more than a third of the captures.
        """
        x = self.context.rows.fraction
        columns = [np.ones(len(x))]
        sets = [[np.prod(x[:, c], axis=1) for c in _products(x.shape[1], degree)] for degree in (1, 2, 3)]
        for more in (sets[0], list(_levels(x)), *sets[1:]):
            if len(columns) + len(more) <= self.n_captures / 3:
                columns += more
        U, size, _ = svd(np.sqrt(self.counts_for)[:, None] * (self.whiten @ np.stack(columns, axis=1)))
        return U[:, size > 1e-9 * size.max(initial=0.0)]

    @cached_property
    def condition(self) -> Ints:
        """The number of each row's condition (F,): its set-point, the one before, and the octave of the time held."""
        context = self.context
        rows, span = context.rows, context.span
        before = (context.previous / span)[rows.event]
        octave = np.floor(np.log2(np.maximum(context.elapsed_s, 0.5)))
        key = np.column_stack([np.round(rows.actuation / span, 2), np.round(before, 2), octave])
        return np.unique(key, axis=0, return_inverse=True)[1].reshape(-1)

    @cached_property
    def conditions(self) -> int:
        """How many different conditions were measured."""
        return int(self.condition.max(initial=-1)) + 1

    @property
    def counted(self) -> "Counted":
        """What the worth of its observations depends on."""
        inexact = 1 + (INEXACT * self.to_explain) ** 2
        return Counted(self.values.size, self.n_captures, self.conditions, inexact)

    @cached_property
    def worth(self) -> float:
        """What each observation counts for in the evidence."""
        counted = self.counted
        return worth_of(counted.numbers, counted.conditions, counted.inexact)

    @cached_property
    def first(self) -> Ints:
        """The first row of each capture."""
        return np.unique(self.index, return_index=True)[1]


@dataclass(frozen=True)
class Still:
    """Makes what all markers share when they shake as large as the noise of each: along the orthonormal `ways` (K, m)
    changes count for `less` (m,) of what they are.
    """

    ways: Floats
    less: Floats

    @classmethod
    def beside(cls, shaken: Floats) -> "Still":
        """For noise whose covariance is one and `shaken` (K, m) times its transpose."""
        ways, size, _ = svd(shaken)
        return cls(ways, 1 / np.hypot(1.0, size))

    def of(self, values: Floats) -> Floats:
        """Values (..., K) as they count."""
        return values + (values @ self.ways * (self.less - 1)) @ self.ways.T if len(self.less) else values


def _products(chambers: int, degree: int) -> Iterator[list[int]]:
    """Which chambers are multiplied, of so many."""
    return (list(each) for each in combinations_with_replacement(range(chambers), degree))


def _units(context: Context, floor: Floor) -> Floats:
    """The unit of each observable (K,): the noise of a capture's mean, or more where the noise within holds is larger.

    One number says for all observables how much smaller noise is within holds. A sensor of another kind, whose noise
    there is larger than that allows, would show something in every hold; so all of its noise counts as larger.
    """
    unit = np.where(floor.mean > 0, floor.mean, 1.0)
    usual = _within(context, floor, unit)
    return np.maximum(unit, floor.within / usual) if usual > 0 else unit


def _within(context: Context, floor: Floor, unit: Floats) -> float:
    """The noise within holds as a part of that of a mean: of most observables of the commonest unit it is no larger."""
    own = commonest_unit(context.rows.unit, context.rows.values, context.base)
    return float(np.quantile((floor.within / unit)[own], _MOST, method="higher"))


def contrasts(rows: Floats) -> Floats:
    """How many independent contrasts holds of so many rows (n,) count for."""
    return (rows - 1) * np.minimum(1.0, _CROWD / np.maximum(rows, 1.0))


def observe(context: Context, residual: Floats, floor: Floor, fitted: Floats | None = None) -> Observations:
    """Turn the base's residual (F, K) into observations; gaps are filled as in `fill_gaps`. `fitted` (F, D) are the
    regressors that the base was fitted with to each observable.

    Within a hold of k rows the k - 1 orthonormal (Helmert) contrasts are free of the capture's own noise; of long
    records a hold counts as `_CROWD` rows at most, since neighbouring rows say nearly the same.
    """
    unit = _units(context, floor)
    index = np.unique(context.rows.capture, return_inverse=True)[1]
    whiten, capture = _whitening(index, _within(context, floor, unit))
    still = Still.beside(floor.shaken / unit[:, None])
    return Observations(
        context=context,
        floor=floor,
        unit=unit,
        values=still.of(whiten @ fill_gaps(residual / unit, index)),
        whiten=whiten,
        capture=capture,
        index=index,
        left=np.ones(len(capture)) if fitted is None else _left(np.asarray(whiten @ fitted)),
        whole=_whole(residual, index),
        still=still,
    )


def _whitening(index: Ints, within: float) -> tuple[csr_matrix, Ints]:
    """The matrix (S, F) that carries rows to captures' means, and to contrasts whose noise `within` holds it makes one;
    and the capture (S,) of each of these. `index` (F,) numbers the captures of the rows.
    """
    count = np.bincount(index)
    members = np.split(np.argsort(index, kind="stable"), np.cumsum(count)[:-1])
    column, row = [np.concatenate(members)], [np.repeat(np.arange(len(count)), count)]
    weight, capture = [np.repeat(1.0 / count, count)], [np.arange(len(count))]
    made = len(count)
    for i, own in enumerate(members):
        k = len(own)
        if k > 1 and within > 0:
            column.append(np.tile(own, k - 1))
            row.append(np.repeat(np.arange(made, made + k - 1), k))
            weight.append((helmert(k) / within * min(1.0, np.sqrt(_CROWD / k))).ravel())
            capture.append(np.full(k - 1, i))
            made += k - 1
    entries = np.concatenate(weight), (np.concatenate(row), np.concatenate(column))
    return csr_matrix(entries, shape=(made, len(index))), np.concatenate(capture)


def _levels(fraction: Floats) -> Iterator[Floats]:
    """Whether each row (F,) is at a level of a chamber, 0 or 1: for each chamber's levels but the first two."""
    for x in np.round(fraction, 3).T:
        yield from ((x == level).astype(float) for level in np.unique(x)[2:])


def _whole(residual: Floats, index: Ints) -> NDArray[np.bool_]:
    """Which captures (n,) have a value of each observable that has one anywhere, of rows (F, K)."""
    count = sums_of(index, np.isfinite(residual).astype(float), int(index.max()) + 1)
    return np.asarray((count[:, count.any(axis=0)] > 0).all(axis=1), dtype=bool)


def _left(fitted: Floats) -> Floats:
    """The share of the square of noise (S,) that a least-squares fit of regressors (S, D) leaves: one less the leverage
    (D. C. Hoaglin and R. E. Welsch, The American Statistician 32, 1978).
    """
    U, size, _ = svd(fitted)
    return 1.0 - np.square(U[:, size > 1e-9 * size.max(initial=0.0)]).sum(axis=1)


def fill_gaps(values: Floats, index: Ints) -> Floats:
    """Fill NaN of rows (F, K) by the mean of their capture, and that where it is NaN, and what changes along the hold,
    each by what is like it (`filled`). So a row that was not seen has the noise of its capture.
    """
    seen = np.isfinite(values)
    if seen.all():
        return values
    means, _ = capture_means(values, index)
    return np.where(seen, values, filled(means)[index] + filled(values - means[index]))
