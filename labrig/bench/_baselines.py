"""What a user would reach for instead: BIC, F-tests, sparse regression, and a learner that names nothing.

All see the same rows, the same base and (the first two) the same effects. None knows of autocorrelation, of
held-out blocks or of a floor.
"""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.bench._design import PATTERNS, Residuals, columns, residuals
from labrig.bench.records import Answer
from labrig.effects import Context, Effect

MOST_EFFECTS = 3
_ROWS = 300  # rows of the campaign that are used: a plain regression needs no more


def _squares(X: Floats, y: Floats) -> tuple[float, int]:
    """Residual sum of squares of a least squares fit, and the rank."""
    gram = X.T @ X
    value, vector = np.linalg.eigh(gram)
    keep = value > 1e-9 * max(value.max(), 1e-300)
    projected = vector[:, keep].T @ (X.T @ y) / np.sqrt(value[keep])
    return float(y @ y - projected @ projected), int(keep.sum())


def candidates(data: Residuals, library: dict[str, Effect]) -> dict[str, list[Floats]]:
    """Columns of every form of every effect that can act on these rows."""
    found = {}
    for name, effect in library.items():
        forms = [columns(data, variant) for variant in effect.variants(data.context)]
        found[name] = [X for X in forms if 0 < X.shape[1] < data.value.size // 4]
    return {name: forms for name, forms in found.items() if forms}


def _forward(
    y: Floats, forms: dict[str, list[Floats]], better: Callable[[float, int, float, int], float]
) -> list[str]:
    """Take the effect for which `better(old rss, old rank, new rss, new rank)` is highest while it is
    positive.
    """
    chosen: list[str] = []
    taken = np.zeros((y.size, 0))
    squares, rank = float(y @ y), 0
    while len(chosen) < MOST_EFFECTS:
        best: tuple[float, str, Floats, float, int] | None = None
        for name in sorted(forms.keys() - set(chosen)):
            for X in forms[name]:
                joint = np.concatenate([taken, X], axis=1)
                new_squares, new_rank = _squares(joint, y)
                gain = better(squares, rank, new_squares, new_rank)
                if gain > 0 and (best is None or gain > best[0]):
                    best = (gain, name, joint, new_squares, new_rank)
        if best is None:
            break
        _, name, taken, squares, rank = best
        chosen.append(name)
    return sorted(chosen)


def bic(y: Floats, forms: dict[str, list[Floats]]) -> list[str]:
    """Forward selection by the Bayesian information criterion (Schwarz 1978)."""
    n = y.size

    def better(old: float, old_rank: int, new: float, new_rank: int) -> float:
        return n * np.log(old / new) - (new_rank - old_rank) * np.log(n)

    return _forward(y, forms, better)


def f_test(y: Floats, forms: dict[str, list[Floats]], level: float = 0.05) -> list[str]:
    """Forward selection by F-tests that take every entry for independent, Bonferroni over the library."""
    from scipy.stats import f as f_distribution

    n, limit = y.size, level / max(sum(len(x) for x in forms.values()), 1)

    def better(old: float, old_rank: int, new: float, new_rank: int) -> float:
        extra = new_rank - old_rank
        if extra <= 0:
            return -1.0
        ratio = ((old - new) / extra) / (new / (n - new_rank))
        tail = f_distribution.logsf(ratio, extra, n - new_rank)
        if not np.isfinite(tail):  # too small for a float: its leading term
            tail = -0.5 * (n - new_rank) * np.log(old / new)
        return float(np.log(limit) - tail)

    return _forward(y, forms, better)


def answer(names: list[str]) -> Answer:
    """A baseline's names as a verdict: it can only say none, one or several."""
    verdict = ("nothing_missing", "identified", "multiple")[min(len(names), 2)]
    return {"verdict": verdict, "effects": names, "rivals": [], "probability": None}


def run_baselines(
    context: Context, library: dict[str, Effect], random: np.random.Generator
) -> dict[str, Answer]:
    """The answers of all baselines that are installed, by name."""
    data = residuals(context, random, _ROWS)
    forms, y = candidates(data, library), data.value
    out = {"bic": answer(bic(y, forms)), "f-test": answer(f_test(y, forms))}
    sparse = _sparse(context)
    if sparse is not None:
        out["sindy"] = answer(sparse)
    return out


def _sparse(context: Context) -> list[str] | None:
    """Thresholded least squares (Brunton et al. 2016) over everyday terms; None without pysindy."""
    try:
        from pysindy import STLSQ  # pyright: ignore[reportMissingImports]
    except ImportError:
        return None
    terms = _everyday_terms(context)
    X = np.concatenate(list(terms.values()), axis=1)
    X = (X - X.mean(axis=0)) / np.maximum(X.std(axis=0), 1e-12)
    left = context.rows.values - context.base
    filled = np.where(np.isfinite(left), left, 0.0)
    score, size, _ = np.linalg.svd(filled - filled.mean(axis=0), full_matrices=False)
    y = (score * size)[:, :PATTERNS]
    y = y / max(float(y.std()), 1e-12)
    best, kept = y.size * np.log(np.mean(y**2)), np.zeros((1, X.shape[1]))
    for threshold in (0.01, 0.02, 0.05, 0.1, 0.2, 0.4):
        coefficient = np.atleast_2d(_quiet_fit(STLSQ(threshold=threshold, alpha=1.0), X, y))
        error = np.mean((y - X @ coefficient.T) ** 2)
        criterion = y.size * np.log(error) + np.count_nonzero(coefficient) * np.log(y.size)
        if criterion < best:
            best, kept = criterion, coefficient
    strength = np.abs(kept).max(axis=0)
    owner = np.repeat(list(terms), [x.shape[1] for x in terms.values()])
    found = {name: float(strength[owner == name].sum()) for name in terms}
    names = [name for name in sorted(found, key=lambda n: -found[n]) if found[name] > 0]
    return sorted(names[:MOST_EFFECTS])


def _quiet_fit(optimizer: Any, X: Floats, y: Floats) -> Floats:
    """Coefficients of a sparse fit; that a threshold leaves nothing over is no news here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return optimizer.fit(X, y).coef_


def _everyday_terms(context: Context) -> dict[str, Floats]:
    """Terms that a person would put into a sparse regression, under the name of what they would stand for."""
    rows = context.rows
    u = (rows.actuation - rows.low) / (rows.high - rows.low)
    before = np.maximum(rows.event - 1, 0)
    step = u - (rows.event_actuation[before] - rows.low) / (rows.high - rows.low)
    hold = np.nan_to_num(rows.hold_s)[:, None]
    pairs = [u[:, i] * u[:, j] for i in range(u.shape[1]) for j in range(i)]
    terms = {
        "regulator": u,
        "stiffening": u**2,
        "tension": u**3,
        "hysteresis": np.sign(step),
        "friction": np.sign(step) * u,
        "creep": u * np.log1p(hold),
        "leak": u * hold,
        "delay": step * np.exp(-hold),
        "drift": np.nan_to_num(rows.time_s)[:, None],
    }
    if pairs:
        terms["coupling"] = np.stack(pairs, axis=1)
    return terms
