"""What each explanation of a campaign expects of captures that were not measured yet, and how surely."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from scipy.linalg import solve_triangular

from labrig.arrays import Bools, Floats, Ints
from labrig.diagnosis._design import DECLARED, Block, Design, design_of
from labrig.diagnosis._diagnose import laid_out
from labrig.diagnosis._evidence import Sums
from labrig.diagnosis._explanation import Explanation, Form, split
from labrig.diagnosis._layout import LEAST_SHARE
from labrig.diagnosis._observations import Counted, Observations, contrasts, observe, worth_of
from labrig.diagnosis._posterior import DECLARED_FLOORS, Search, small_sizes
from labrig.diagnosis._problem import Prepared
from labrig.effects import Context, Effect

_MOST_NUMBERS = 24
"""Combinations of a programme's numbers that are kept: those in which the explanations differ most."""

_LEAST = 1e-8
"""Of the variance of what explanations raise: directions that have less are not looked at; numerical."""


@dataclass(frozen=True)
class Outlook:
    """What M explanations expect of d combinations of numbers of unit noise.

    `mean` (M, d), and `factor` (M, d, q): the covariance is factor factor' besides the noise; `square` is that product
    where it is known. They stand for so many `numbers`, of `conditions` that the `campaign` did not have.
    """

    mean: Floats
    factor: Floats
    numbers: float
    conditions: frozenset[int]
    campaign: Counted
    square: Floats | None = field(default=None, repr=False)

    @cached_property
    def covariance(self) -> Floats:
        """The covariance besides the noise, (M, d, d)."""
        return self.factor @ np.swapaxes(self.factor, 1, 2) if self.square is None else self.square

    @property
    def worth(self) -> float:
        """What each of the numbers counts for, in a diagnosis of the campaign and of them."""
        return worth_of(
            self.campaign.numbers + self.numbers,
            self.campaign.conditions + len(self.conditions),
            self.campaign.inexact,
        )

    def beside(self, other: "Outlook", *, last: bool = False) -> "Outlook":
        """The numbers of both; nothing can be put beside the `last` ones, which take less time."""
        M, d = self.mean.shape
        square = np.empty((M, d + other.mean.shape[1], d + other.mean.shape[1]))
        square[:, :d, :d], square[:, d:, d:] = self.covariance, other.covariance
        np.matmul(self.factor, np.swapaxes(other.factor, 1, 2), out=square[:, :d, d:])
        square[:, d:, :d] = np.swapaxes(square[:, :d, d:], 1, 2)
        return replace(
            self,
            mean=np.concatenate([self.mean, other.mean], axis=1),
            factor=np.zeros((M, 0, 0)) if last else np.concatenate([self.factor, other.factor], axis=1),
            numbers=self.numbers + other.numbers,
            conditions=self.conditions | other.conditions,
            square=square,
        )

    def condensed(self) -> "Outlook":
        """The combinations in which the explanations differ most."""
        apart = (self.mean - self.mean.mean(axis=0)).T
        Q = basis(np.concatenate([apart, *self.factor], axis=1))
        return replace(self, mean=self.mean @ Q, factor=Q.T @ self.factor, square=Q.T @ self.covariance @ Q)


def basis(Z: Floats) -> Floats:
    """Orthonormal combinations (d, e) of the rows of Z (d, q) that hold most of it, all where they are few."""
    if len(Z) <= _MOST_NUMBERS:
        return np.eye(len(Z))
    if len(Z) <= Z.shape[1]:  # of their products, which are fewer: what holds most is well above rounding
        return np.linalg.eigh(Z @ Z.T)[1][:, : -_MOST_NUMBERS - 1 : -1]
    return np.linalg.qr(Z @ np.linalg.eigh(Z.T @ Z)[1][:, : -_MOST_NUMBERS - 1 : -1])[0]


class Explained:
    """A campaign beside all explanations by some effects, ready to be asked what they expect.

    What is planned counts for as much as it would in the diagnosis: see `Observations.worth`.
    """

    def __init__(self, ready: Prepared, effects: Mapping[str, Effect]) -> None:
        self.effects = dict(effects)
        self.ready, self.observations, design = laid_out(ready, self.effects)
        self.design = design or design_of(
            self.observations, self.effects, self.ready.nuisance, self.ready.calibrated
        )
        self.search = Search(self.design).run()

    def forms(self, names: Sequence[str], most: int) -> list[Explanation]:
        """The likeliest forms of exactly these effects, likeliest first; an empty list where one of them can't act.

        A form is what is raised, whatever its sizes: the likeliest of them stand for all.
        """
        own = frozenset(names)
        alike: dict[frozenset[int], list[Form]] = {}  # but for the sizes
        for form in self._found(own) or self._built(names):
            alike.setdefault(frozenset(number for _, number, _ in form.raised), []).append(form)
        scored = sorted(
            (float(np.logaddexp.reduce([form.score for form in forms])), max(forms)[1:])
            for forms in alike.values()
        )
        return [Explanation(own, raised, score, slow) for score, (raised, slow) in scored[: -most - 1 : -1]]

    def _found(self, names: frozenset[str]) -> list[Form]:
        """The forms of exactly these effects that the search looked at, without free patterns."""
        self.search.settle(names)
        return [form for form in self.search.found.get(names, ()) if not split(form.raised)[0]]

    def _built(self, names: Sequence[str]) -> list[Form]:
        """The forms that are looked at when each effect in turn takes its best one beside those before; none where one
        of them cannot act.
        """
        search, raised = self.search, ()
        slow = search.best().slow
        for name in names:
            more = [
                (score, form)
                for score, form in search.extend((), slow, raised)
                if any(owner == name and size not in search.traces for owner, _, size in form)
            ]
            if not more:
                return []
            raised = max(more)[1]
        return self._found(frozenset(names))

    def outlooks(
        self,
        joint: Context,
        declared: Floats | None,
        calibrated: Floats | None,
        programme: Ints,
        forms: Sequence[Explanation],
    ) -> list[Outlook]:
        """What forms expect of each programme, of numbers of unit noise.

        Args:
            joint: the rows of the campaign, and after them those that are planned.
            declared: what the base calls its own, of all these rows, (F, D).
            calibrated: likewise, (F, K, D).
            programme: the programme (F - n,) to which each planned row belongs, 0, 1, ...
            forms: the explanations that are asked, M.
        """
        design = self._design_of(joint, declared, calibrated)
        means, factors, directions = self._expected(design, forms)
        observations = design.observations
        of_row = np.concatenate([np.full(len(joint.base) - len(programme), -1), programme])
        of_capture = of_row[observations.first]
        measured = np.unique(observations.condition[of_row < 0])
        chosen: list[Floats] = []
        seen: list[tuple[float, frozenset[int]]] = []
        for number in range(int(programme.max(initial=-1)) + 1):
            own = np.flatnonzero(of_capture[observations.capture] == number)
            chosen.append(self._numbers(design, own, directions))
            numbers = int((of_capture == number).sum()) * self.observations.counted.of_a_capture
            new = np.setdiff1d(observations.condition[of_row == number], measured)
            seen.append((numbers, frozenset(new.tolist())))
        every = np.concatenate(chosen) if chosen else np.zeros((0, means.shape[1]))
        mean = means @ every.T  # of all programmes at once: much faster
        factor = np.matmul(every, factors)
        ends = np.cumsum([0, *map(len, chosen)])
        return [
            Outlook(mean[:, a:b], factor[:, a:b], numbers, new, self.observations.counted)
            for a, b, (numbers, new) in zip(ends[:-1], ends[1:], seen, strict=True)
        ]

    def _design_of(self, joint: Context, declared: Floats | None, calibrated: Floats | None) -> Design:
        """The design of the campaign's rows and those that are planned; see `outlooks`."""
        planned = len(joint.base) - len(self.ready.residual)
        residual = np.concatenate([self.ready.residual, np.zeros((planned, joint.base.shape[1]))])
        observations = self._beside(observe(joint, residual, self.ready.floor))
        if (began := self.ready.began) is not None:  # nothing of it is left in what is planned
            began = np.concatenate([began, np.zeros((planned, began.shape[1]))])
            declared = began if declared is None else np.concatenate([declared, began], axis=1)
        return design_of(observations, self.effects, declared, calibrated)

    def _expected(
        self, design: Design, forms: Sequence[Explanation]
    ) -> tuple[Floats, Floats, tuple[Ints, Floats]]:
        """The means (M, Q) and the factors (M, Q, Q) of all coefficients by each form; and in which of them the forms
        differ, see `_differences`.
        """
        known = design.observations.capture < self.observations.n_captures
        sums = Sums.of(design, self.observations.worth, keep=known)
        raised = {number for form in forms for _, number, _ in form.raised}
        bases: dict[int, Floats] = {}
        again = {number: self._again(design, self.design.blocks[number], known, bases) for number in raised}
        posteriors = [self._posterior(design, sums, form, again) for form in forms]
        means, factors = np.stack([p.mean for p in posteriors]), np.stack([p.factor for p in posteriors])
        return means, factors, _differences(posteriors)

    def _numbers(self, design: Design, own: Ints, directions: tuple[Ints, Floats]) -> Floats:
        """Combinations (d, Q) of the numbers of some observations, in which the forms differ most, by the coefficients
        of what makes them.
        """
        columns_that_differ, differ = directions
        r, weight = design.V.shape[1], self._as_recorded(design.observations)[own]
        declared = [f.G for f in design.free if f.owner == DECLARED]
        G = np.concatenate([np.zeros((len(own), 0)), *(each[own] for each in declared)], axis=1)
        columns = (np.repeat(weight, r)[:, None] * design.W.some(own).whole).astype(float)
        Q = basis(columns[:, columns_that_differ] @ differ)  # chosen by what is raised; all else is added
        return np.concatenate([Q.T @ columns, Q.T @ np.kron(weight[:, None] * G, np.eye(r))], axis=1)

    def _beside(self, joint: Observations) -> "_Joint":
        """Observations of the campaign, as they are, and of what is planned, without values."""
        values = np.zeros_like(joint.values)
        values[joint.capture < self.observations.n_captures] = self.observations.values
        own: dict[str, Any] = {f.name: getattr(joint, f.name) for f in fields(joint)} | {"values": values}
        return _Joint(**own, campaign=self.observations)

    def _as_recorded(self, joint: Observations) -> Floats:
        """The weight of each observation: a planned hold says as much as one that the rig recorded, of more rows."""
        rows = np.bincount(joint.index).astype(float)
        recorded = np.median(contrasts(rows[: self.observations.n_captures]))
        within = np.sqrt(recorded / np.maximum(contrasts(rows), 1e-9))
        means = np.arange(len(joint.values)) < joint.n_captures
        return np.where(means, 1.0, within[joint.capture])

    def _posterior(self, design: Design, sums: Sums, form: Explanation, again: "_Again") -> "_Posterior":
        """The coefficients of all columns as the campaign gives them, where what one form raises acts and nothing else
        does by more than a little.
        """
        r, declared = design.V.shape[1], [f.owner == DECLARED for f in design.free for _ in f.G.T]
        free = np.array(declared, dtype=bool)
        more = int(free.sum()) * r
        sd, raised = self._sizes(design, form, again)
        sd = np.concatenate([sd, np.full(more, DECLARED_FLOORS)])
        cross = sums.GW[free].astype(float).reshape(more, design.W.width)
        apart = np.kron(sums.GG[np.ix_(free, free)], np.eye(r))
        M = sd[:, None] * np.block([[sums.A, cross.T], [cross, apart]]) * sd
        # columns may be of single precision: their products are off by as much
        M[np.diag_indices_from(M)] += 1 + 10 * np.finfo(design.W.dtype).eps * np.diag(M)
        L = np.linalg.cholesky(M)
        factor = solve_triangular(L, np.diag(sd), lower=True).T
        z = solve_triangular(L, sd * np.concatenate([sums.b, sums.GY[free].reshape(-1)]), lower=True)
        return _Posterior(raised, factor @ z, factor)

    def _sizes(self, design: Design, form: Explanation, again: "_Again") -> tuple[Floats, Ints]:
        """The prior sd (P,) of each column in one form, and which columns it raises."""
        sd = small_sizes(design, self.search.spike, form.slow)
        square = np.zeros_like(sd)
        raised = [np.zeros(0, dtype=np.int64)]
        for _, number, size in form.raised:
            if found := again[number]:
                block, ratio = found
                square[block.at] += (size * ratio) ** 2  # owners of the same space have the same columns
                raised.append(np.arange(block.at.start, block.at.stop))
        return np.where(square > 0, np.sqrt(square), sd), np.concatenate(raised)

    def _again(
        self, design: Design, was: Block, known: Bools, bases: dict[int, Floats]
    ) -> tuple[Block, float] | None:
        """The block of a design that holds most of one of the campaign's, among those of its owner, and how much
        smaller its columns are on the campaign. `bases` keeps what blocks span there, by their first column.

        A space may be a part of the range that was measured (a limit at 85 % of the travel): beside what is planned it
        has another name.
        """
        own = [b for b in design.blocks if b.owner == was.owner]
        if not own:
            return None
        r = self.design.V.shape[1]
        columns = self.design.W.of(was.at).reshape(-1, r, was.at.stop - was.at.start)
        target = np.einsum("srq,rp->spq", columns, self.design.V.T @ design.V).reshape(-1, columns.shape[2])

        def held(block: Block) -> float:
            if block.at.start not in bases:
                W = design.W.of(block.at).reshape(len(known), -1)[known].reshape(len(target), -1)
                bases[block.at.start] = np.linalg.qr(W)[0]
            return _square(bases[block.at.start].T @ target)

        block = own[0] if len(own) == 1 else max(own, key=held)
        return block, self._ratio(design, block, was, known)

    def _ratio(self, design: Design, block: Block, of_run: Block, known: Bools) -> float:
        """By how much columns of unit size over all rows are smaller than those of unit size over the campaign.

        Where next to nothing of them falls on the campaign, as if the least did that a design keeps.
        """
        W = design.W.of(block.at).reshape(len(known), -1)
        before, all_of_it, now = (_square(each) for each in (self.design.W.of(of_run.at), W, W[known]))
        return float(np.sqrt(before / max(now, LEAST_SHARE * all_of_it)))


def _square(columns: Floats) -> float:
    return float(np.einsum("ij,ij->", columns, columns, dtype=np.float64))


@dataclass(frozen=True)
class _Joint(Observations):
    """A campaign's observations and those that are planned: what there is to explain is the campaign's."""

    campaign: Observations

    @property
    def to_explain(self) -> float:  # type: ignore[override]
        """As in the campaign."""
        return self.campaign.to_explain

    @property
    def worth(self) -> float:  # type: ignore[override]
        """As in the campaign."""
        return self.campaign.worth


_Again: TypeAlias = Mapping[int, tuple[Block, float] | None]
"""For each block of the campaign that some form raises: what it is beside the programmes, see `Explained._again`."""


@dataclass(frozen=True)
class _Posterior:
    """The coefficients' mean (Q,) and the factor (Q, Q) of their covariance: first of all columns, of which some are
    `raised`, then of what the base calls its own, along each direction.
    """

    raised: Ints
    mean: Floats
    factor: Floats


def _differences(posteriors: Sequence[_Posterior]) -> tuple[Ints, Floats]:
    """The columns (u,) that any explanation raises, and combinations of them (u, q) in which explanations differ."""
    named = np.unique(np.concatenate([p.raised for p in posteriors]))
    means = np.zeros((len(named), len(posteriors)))
    spread = np.zeros((len(named), len(named)))
    for m, p in enumerate(posteriors):
        at = np.searchsorted(named, p.raised)
        means[at, m] = p.mean[p.raised]
        spread[np.ix_(at, at)] += p.factor[p.raised] @ p.factor[p.raised].T
    power, U = np.linalg.eigh(spread)
    some = power > _LEAST * power.max(initial=0.0)
    wide = U[:, some] * np.sqrt(power[some])
    return named, np.concatenate([means - means.mean(axis=1, keepdims=True), wide], axis=1)
