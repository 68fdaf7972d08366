"""How well a programme tells explanations apart: what one predicts, and how much of it the others cannot follow.

For each explanation taken as true, its prediction with the values that the run gave it is what would be
measured; each other one is fitted again to the run and to that, in every form that it has, with the base's own
parameters beside it. What it then leaves beyond what it leaves of the run alone, in units of the noise, is the
criterion of T-optimality (Atkinson and Fedorov, Biometrika 62 (1975) 57); half of it is the expected gain of
the logarithm of the Bayes factor. Everything is sums over rows of products of columns, one set for each
programme, so that programmes are put together by adding sums.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.diagnosis import Regression
from labrig.effects import Context, Term
from labrig.experiment._plan import Limits, Planned, Point, planned_rows
from labrig.experiment._rivals import Form, Rival, fields_of_terms, join_contexts
from labrig.model import Predictor

TRUST = 0.25
"""Weight of the run against the programme when a rival is fitted to both: no formula is nature's own, so its
values may be other ones under another programme."""

FORM = 0.03
"""Share of what is measured that no formula is trusted to predict more finely."""

GOAL = 0.04
LEAST = 60.0
"""How far behind a rival is out: a share of what the explanation explains of the run, and at least so many
noise squares."""

_RIDGE = 1e-3
_TRUE_FORMS = 2
_ROWS_AT_ONCE = 400


@dataclass(frozen=True)
class Sums:
    """Products of all columns over the rows of one programme: `G` (Q, Q), and of how many numbers.

    With parameters of the base's own, D regressors for each of K observables: `A` (D, D) and `B` (D, K, Q);
    `share` (K,) sums the weights of each observable, the regressors' own weights being those of the best.
    """

    G: Floats
    A: Floats
    B: Floats
    share: Floats
    numbers: float

    def __add__(self, other: "Sums") -> "Sums":
        return Sums(
            self.G + other.G,
            self.A + other.A,
            self.B + other.B,
            self.share + other.share,
            self.numbers + other.numbers,
        )

    def __mul__(self, factor: float) -> "Sums":
        return Sums(
            factor * self.G, factor * self.A, factor * self.B, factor * self.share, factor * self.numbers
        )


@dataclass(frozen=True)
class Layout:
    """Programmes laid out beside a run: sums of the run and of each programme, and where columns stand.

    `columns[r][f]` are the columns of form f of rival r; the last column of all is what was measured.
    """

    run: Sums
    programmes: list[Sums]
    points: list[list[Sums]]
    columns: list[list[Ints]]


@dataclass
class Problem:
    """A run with its open explanations, ready to be asked what a programme would tell."""

    regression: Regression
    context: Context
    predictor: Predictor
    rivals: list[Rival]
    limits: Limits
    _noise: tuple[Floats, Floats] = field(init=False, repr=False)
    _last: tuple[list[Floats], Sums] | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        floor, s = self.regression.floor, self.regression
        within = s.within_holds
        sizes = [
            float(np.sqrt(np.mean(s.residual[rows] ** 2))) if rows.any() else 0.0
            for rows in (~within, within)
        ]
        mean = np.sqrt(floor.mean**2 + (FORM * sizes[0]) ** 2)
        deviation = np.sqrt(np.where(floor.within > 0, floor.within, np.inf) ** 2 + (FORM * sizes[1]) ** 2)
        self._noise = (mean, deviation)

    @cached_property
    def counted(self) -> Ints:
        """The observables that figures are quoted for."""
        return self.regression.counted

    @cached_property
    def keeps_time(self) -> bool:
        """Whether some explanation depends on the time in session, so that it matters when a probe is done."""
        parts = [part for rival in self.rivals for part in rival.forms[0].parts]
        return any(part.effect.covariate(self.context)[0] == "time in session" for part in parts)

    def joint(self, programmes: Sequence[Sequence[Point]], idle_s: float = 0.0) -> tuple[Context, Planned]:
        """The run and the programmes, each a session of its own, as one campaign."""
        planned = planned_rows(self.context.rows, programmes, self.limits, idle_s)
        return join_contexts(self.context, self.predictor.context(planned.rows)), planned

    def lay_out(
        self, programmes: Sequence[Sequence[Point]], by_point: bool = False, idle_s: float = 0.0
    ) -> Layout:
        """Sums of every programme, each a session of its own; with `by_point` those of each point as well."""
        joint, planned = self.joint(programmes, idle_s)
        columns, terms, at = [], [], 0
        for rival in self.rivals:
            own = []
            for form in rival.forms:
                features = form.features(joint) or _none(joint, form)
                terms += features
                width = sum(_width(t, self.regression) for t in features)
                own.append(np.arange(at, at + width))
                at += width
            columns.append(own)
        run = self._run_sums(joint, terms, at)
        n_run = len(self.context.rows.capture)
        ahead = fields_of_terms(joint, terms, self.regression.patterns, slice(n_run, None)) if terms else None
        declared = self.predictor.declared(planned.rows)
        sums, points = [], []
        for number, programme in enumerate(programmes):
            each = [
                self._planned_sums(ahead, declared, planned, number, place, at)
                for place in range(len(programme))
            ]
            sums.append(sum(each[1:], each[0]))
            points.append(each if by_point else [])
        return Layout(run, sums, points, columns)

    def _run_sums(self, joint: Context, terms: list[Term], width: int) -> Sums:
        """Sums over the run; those of last time where the columns are still the same."""
        s, n_run = self.regression, len(self.context.rows.capture)
        features = [t.feature[:n_run] for t in terms]
        if self._last is not None and _same(self._last[0], features):
            return self._last[1]
        Z = np.zeros((*s.residual.shape, width + 1))
        if terms:
            Z[:, :, :width] = s.lift(fields_of_terms(joint, terms, s.patterns, slice(n_run)))
        Z[:, :, width] = s.residual
        sums = _sums(Z, s.weight, s.declared)
        self._last = ([f.copy() for f in features], sums)
        return sums

    def _planned_sums(
        self,
        fields: Floats | None,
        declared: Floats | None,
        planned: Planned,
        number: int,
        place: int,
        width: int,
    ) -> Sums:
        own = np.flatnonzero((planned.owner == number) & (planned.point == place))
        K = self.regression.residual.shape[1]
        Z = np.zeros((len(own), K, width + 1))
        if fields is not None:
            Z[:, :, :width] = fields[own]
        mean = Z.mean(axis=0, keepdims=True)
        Z = np.concatenate([mean, Z - mean])
        weight = np.concatenate(
            [1 / self._noise[0][None] ** 2, np.repeat(1 / self._noise[1][None] ** 2, len(own), 0)]
        )
        B = None
        if declared is not None:
            B = np.concatenate([declared[own[:1]], np.zeros((len(own), declared.shape[1]))])
        return _sums(Z, weight, B)


def _none(context: Context, form: Form) -> list[Term]:
    """Columns of zeros for a form that can't act there (a drift over several sessions where there is one)."""
    width = sum(part.columns.width for part in form.parts)
    return [Term.field("none", np.zeros((*context.base.shape, width)))]


def _same(before: list[Floats], now: list[Floats]) -> bool:
    """Whether columns of the run are those of last time, to rounding."""
    pairs = zip(before, now, strict=True) if len(before) == len(now) else ()
    return len(before) == len(now) and all(
        a.shape == b.shape and np.allclose(a, b, rtol=1e-3, atol=1e-6) for a, b in pairs
    )


def _width(term: Term, regression: Regression) -> int:
    if term.kind == "frame":
        return 6
    q = term.feature.shape[-1]
    return q * regression.n_patterns if term.kind == "pattern" else q


def _sums(Z: Floats, weight: Floats, declared: Floats | None) -> Sums:
    """Weighted products of columns (S, K, Q)."""
    S, K, Q = Z.shape
    G = np.zeros((Q, Q))
    D = 0 if declared is None else declared.shape[1]
    A, B, share = np.zeros((D, D)), np.zeros((D, K, Q)), np.zeros(K)
    for start in range(0, S, _ROWS_AT_ONCE):
        rows = slice(start, start + _ROWS_AT_ONCE)
        weighted = (Z[rows] * weight[rows][:, :, None]).reshape(-1, Q)
        G += Z[rows].reshape(-1, Q).T @ weighted
        if declared is not None:
            w = weight[rows].max(axis=1)
            A += (declared[rows] * w[:, None]).T @ declared[rows]
            B += np.einsum("sd,skq->dkq", declared[rows], weighted.reshape(-1, K, Q), optimize=True)
            share += weight[rows][np.abs(declared[rows]).sum(axis=1) > 0].sum(axis=0)
    return Sums(G, A, B, share, float((weight > 0).sum()))


@dataclass(frozen=True)
class Judge:
    """Says how far apart programmes put the rivals; `pairs` are (true, other) as indices of rivals."""

    layout: Layout
    rivals: list[Rival]

    @cached_property
    def pairs(self) -> list[tuple[int, int]]:
        """Every ordered pair of rivals in which the other one can fall behind: it has not all names of the true one."""
        names = [set(r.names) for r in self.rivals]
        each = range(len(names))
        return [(m, n) for m in each for n in each if not names[m] <= names[n]]

    @cached_property
    def matters(self) -> Floats:
        """How much each pair matters, 1 on average: by the probability of the one and of the other."""
        p = np.array([self.rivals[m].probability * self.rivals[n].probability for m, n in self.pairs])
        return p / p.mean()

    @cached_property
    def _run(self) -> Floats:
        """Products over the run, weighed less, (Q, Q)."""
        return _projected(self.layout.run, TRUST)

    @cached_property
    def _variance(self) -> list[list[Floats]]:
        """For each form the covariance of its values as the run alone leaves it."""
        return [
            [_pseudo_inverse(self._run[np.ix_(own, own)]) for own in forms] for forms in self.layout.columns
        ]

    @cached_property
    def _alone(self) -> list[list[tuple[Floats, float]]]:
        """For each form its values as the run alone gives them, and what it leaves of the run (weighed less)."""
        G = self._run
        return [[_fitted(G, own, G[:, -1], G[-1, -1]) for own in forms] for forms in self.layout.columns]

    def goal(self, true: int) -> float:
        """What a rival must fall behind by to be out: a share of what the run says for this explanation."""
        return max(LEAST, GOAL * self._worth(true) / TRUST)

    def _worth(self, true: int) -> float:
        return float(self._run[-1, -1]) - min(left for _, left in self._alone[true])

    def apart(self, planned: Sums) -> Floats:
        """What each other explanation leaves of what each one predicts, noise squares, one for each pair."""
        both = self.layout.run * TRUST + planned
        out = np.zeros(len(self.pairs))
        for i, (m, n) in enumerate(self.pairs):
            total = weight = 0.0
            likely = self.rivals[m].weight
            for f in np.argsort(-likely)[:_TRUE_FORMS]:
                total += likely[f] * self._behind(both, planned, m, int(f), n)
                weight += likely[f]
            out[i] = total / weight if weight > 0 else 0.0
        return out

    def _behind(self, both: Sums, planned: Sums, m: int, f: int, n: int) -> float:
        own = self.layout.columns[m][f]
        b, _ = self._alone[m][f]
        predicted = _with_prediction(both, planned, own, b)
        G = _projected(predicted, 1.0)
        least = min(_fitted(G, columns, G[:, -1], G[-1, -1])[1] for columns in self.layout.columns[n])
        before = min(left for _, left in self._alone[n])
        behind = max(least - before, 0.0)
        return behind + min(behind, self._spread(G, planned, m, f, n))

    def _spread(self, G: Floats, planned: Sums, m: int, f: int, n: int) -> float:
        """What the uncertainty of the true explanation's values adds to what the other can't follow."""
        own, other = self.layout.columns[m][f], self.layout.columns[n][0]
        cross = planned.G[np.ix_(other, own)]
        followed = cross.T @ _pseudo_inverse(G[np.ix_(other, other)]) @ cross
        left = planned.G[np.ix_(own, own)] - followed
        return max(float((self._variance[m][f] * left).sum()), 0.0)


def _with_prediction(both: Sums, planned: Sums, own: Ints, b: Floats) -> Sums:
    """The sums when the last column is what was measured on the run and, on the programme, a prediction."""
    G, B = both.G.copy(), both.B.copy()
    G[:, -1] += planned.G[:, own] @ b
    G[-1, :-1] = G[:-1, -1]
    G[-1, -1] = both.G[-1, -1] + b @ planned.G[np.ix_(own, own)] @ b
    if B.size:
        B[:, :, -1] += planned.B[:, :, own] @ b
    return replace(both, G=G, B=B)


def _projected(sums: Sums, factor: float) -> Floats:
    """Products of the columns with what the base's own parameters can follow taken out, (Q, Q)."""
    if not sums.A.size:
        return factor * sums.G
    ridge = 1e-9 * max(float(np.trace(sums.A)), 1e-300) * np.eye(len(sums.A))
    D, K, Q = sums.B.shape
    solved = np.linalg.solve(sums.A + ridge, sums.B.reshape(D, -1)).reshape(D, K, Q)
    scale = sums.share.max() / np.maximum(sums.share, 1e-3 * sums.share.max())
    return factor * (sums.G - np.einsum("dkq,dkp->qp", sums.B * scale[:, None], solved, optimize=True))


def _pseudo_inverse(G: Floats) -> Floats:
    """Inverse of a Gram matrix with a small ridge in units of its own diagonal; columns of zeros stay out."""
    d = np.sqrt(np.maximum(np.diag(G), 0.0))
    live = d > 1e-9 * max(float(d.max(initial=0.0)), 1e-300)
    scale = np.where(live, 1 / np.where(live, d, 1.0), 0.0)
    scaled = G * scale[:, None] * scale + np.diag(np.where(live, _RIDGE, 1.0))
    return np.asarray(np.linalg.inv(scaled) * scale[:, None] * scale, dtype=float)


def _fitted(G: Floats, own: Ints, target: Floats, square: float) -> tuple[Floats, float]:
    """Least squares of the target on some columns, with a small ridge: coefficients, and what is left."""
    H, c = G[np.ix_(own, own)], target[own]
    b = _pseudo_inverse(H) @ c
    return b, float(square - 2 * b @ c + b @ H @ b)
