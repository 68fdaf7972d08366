"""Observations: what a campaign says about a model's error, as independent numbers of unit noise."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import helmert
from scipy.sparse import csr_matrix

from labrig._gaps import filled
from labrig._linalg import sums_of, svd
from labrig.arrays import Floats, Ints
from labrig.diagnosis._constants import INDEPENDENT, INEXACT, PER_CONDITION
from labrig.diagnosis._floor import Floor
from labrig.effects import Context, capture_means

_CROWD = 12
"""Rows that a hold counts as at most: neighbours of a long record say nearly the same."""
_MOST = 0.9
"""Share of the observables in which noise within holds is no larger than is taken for all."""


def worth_of(numbers: float, conditions: int, inexact: float = 1.0) -> float:
    """What each of so many numbers of so many conditions counts for in the evidence.

    Models of neighbours are never exact, nor is any law: by `inexact` (1: not at all) the noise's square is too small.
    """
    return min(1.0, min(INDEPENDENT, PER_CONDITION * conditions) / max(numbers, 1)) / inexact


@dataclass(frozen=True)
class Counted:
    """How many numbers, captures and conditions a campaign has; by what any law is off the noise's square is `inexact`
    times as large.
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
        return float(np.sqrt(np.mean(self.unit[counted] ** 2)))

    @cached_property
    def slopes(self) -> Floats:
        """How far, in floors, each chamber's whole range would move each capture, (n, K, C), as the base says there."""
        context = self.context
        return (context.jacobian * context.span / self.unit[None, :, None])[self.first]

    def shaking(self, shaken: Floats) -> "Observations":
        """The same where the frame shakes, too, by so much in the observables' units (K, m); see `Floor.shaken`."""
        still = Still.beside(shaken / self.unit[:, None])
        return replace(
            self, floor=replace(self.floor, shaken=shaken), values=still.of(self.values), still=still
        )

    def of_rows(self, values: Floats, whiten: csr_matrix | None = None) -> Floats:
        """Rows (F, q) of floors as observations (S, q); `whiten` in another precision, if given.

        Rows are counted from the first of their capture meanwhile: so what stays as it is in a hold is nothing within
        it, not even by rounding.
        """
        start = values[self.first]
        out = np.asarray((self.whiten if whiten is None else whiten) @ (values - start[self.index]))
        out[: len(start)] += start
        return out

    @cached_property
    def to_explain(self) -> float:
        """How much more than noise there is in the rows of what was seen, root mean square, in floors.

        Of captures' means and of what changes within them, each by itself: noise that is less than was taken for it
        within holds says nothing of the means.
        """
        beyond = (self.values[:, self.seen] ** 2).sum(axis=1) - self.left * self.seen.sum()
        parts = np.split(self.counts_for * beyond, [self.n_captures])
        return float(np.sqrt(sum(max(part.sum(), 0.0) for part in parts)))

    @property
    def within(self) -> float:
        """The noise within holds, as a part of that of a capture's mean."""
        return _within(self.context, self.floor, self.unit)

    @cached_property
    def counts_for(self) -> Floats:
        """What the square (S,) of each observation counts for in the mean square of the rows and what was seen."""
        count = np.bincount(self.capture, minlength=self.n_captures).astype(float)
        each = np.concatenate([count, np.full(len(self.values) - len(count), self.within**2)])
        return each / (count.sum() * self.seen.sum())

    def size_of(self, values: Floats, noise: Floats | float = 0.0) -> float:
        """How large such observations (S, K), less the square (S,) of their `noise`, are in the rows of what was seen,
        in floors.
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
        """A number for the condition of each row (F,): set-point, the one before, and octave of the time held."""
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
    """In what observables (K,) are counted: the noise of a capture's mean, or more where within holds it is larger.

    One number says of all observables how much smaller noise is within holds. A sensor of another kind, whose noise is
    larger there than that allows, would say something in every hold; so all of its noise counts as larger.
    """
    unit = np.where(floor.mean > 0, floor.mean, 1.0)
    usual = _within(context, floor, unit)
    return np.maximum(unit, floor.within / usual) if usual > 0 else unit


def _within(context: Context, floor: Floor, unit: Floats) -> float:
    """The noise within holds as a part of that of a mean: of most observables of the commonest unit it is no larger."""
    ((commonest, _),) = Counter(context.rows.unit).most_common(1)
    own = np.array([each == commonest for each in context.rows.unit])
    return float(np.quantile((floor.within / unit)[own], _MOST, method="higher"))


def contrasts(rows: Floats) -> Floats:
    """As how many independent contrasts those of holds of so many rows (n,) count."""
    return (rows - 1) * np.minimum(1.0, _CROWD / np.maximum(rows, 1.0))


def observe(context: Context, residual: Floats, floor: Floor, fitted: Floats | None = None) -> Observations:
    """Turn the base's residual (F, K) into observations; what was not seen is filled by what is like it. `fitted`
    (F, D) are the regressors that the base was fitted with to each observable.

    Within a hold of k rows the k - 1 orthonormal (Helmert) contrasts are free of the capture's own noise; of long
    records a hold counts as `_CROWD` rows at most, since neighbouring rows say nearly the same.
    """
    rows = context.rows
    unit = _units(context, floor)
    within = _within(context, floor, unit)
    captures, index = np.unique(rows.capture, return_inverse=True)
    values = fill_gaps(residual / unit, index)
    order = np.argsort(index, kind="stable")
    count = np.bincount(index)
    start = np.concatenate([[0], np.cumsum(count)])
    to: list[Ints] = []
    at: list[Ints] = []
    weight: list[Floats] = []
    owner = list(range(len(captures)))
    row = len(captures)
    for i, k in enumerate(count):
        own = order[start[i] : start[i + 1]]
        at.append(own)
        to.append(np.full(k, i))
        weight.append(np.full(k, 1.0 / k))
        if k > 1 and within > 0:
            contrasts = helmert(k) / within * min(1.0, np.sqrt(_CROWD / k))
            at.append(np.tile(own, k - 1))
            to.append(np.repeat(np.arange(row, row + k - 1), k))
            weight.append(contrasts.ravel())
            owner += [i] * (k - 1)
            row += k - 1
    whiten = csr_matrix(
        (np.concatenate(weight), (np.concatenate(to), np.concatenate(at))), shape=(row, len(index))
    )
    left = np.ones(row) if fitted is None else _left(np.asarray(whiten @ fitted))
    still = Still.beside(floor.shaken / unit[:, None])
    seen = still.of(whiten @ values)
    whole = _whole(residual, index)
    return Observations(context, floor, unit, seen, whiten, np.array(owner), index, left, whole, still)


def _levels(fraction: Floats) -> Iterator[Floats]:
    """For each chamber at which of its levels each row is, (F,) of 0 and 1, but for the first two."""
    for x in np.round(fraction, 3).T:
        yield from ((x == level).astype(float) for level in np.unique(x)[2:])


def _whole(residual: Floats, index: Ints) -> NDArray[np.bool_]:
    """Which captures (n,) have a value of each observable that has one anywhere, of rows (F, K)."""
    count = sums_of(index, np.isfinite(residual).astype(float), int(index.max()) + 1)
    return np.asarray((count[:, count.any(axis=0)] > 0).all(axis=1), dtype=bool)


def _left(fitted: Floats) -> Floats:
    """What of the square of noise (S,) a least-squares fit of such regressors (S, D) leaves: one less its leverage
    (D. C. Hoaglin and R. E. Welsch, The American Statistician 32, 1978).
    """
    U, size, _ = svd(fitted)
    return 1.0 - np.square(U[:, size > 1e-9 * size.max(initial=0.0)]).sum(axis=1)


def fill_gaps(values: Floats, index: Ints) -> Floats:
    """Fill NaN of rows (F, K): by the capture's mean where some of its rows were seen, else by what is like it; and by
    what changes along the hold. So a row that was not seen keeps the noise of its capture.
    """
    seen = np.isfinite(values)
    if seen.all():
        return values
    means, _ = capture_means(values, index)
    return np.where(seen, values, filled(means)[index] + filled(values - means[index]))
