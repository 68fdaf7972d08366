"""Formulas as regressions: regression, columns and leave-block-out gains do what their slow counterparts do."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import change_of, prepared, whole_change
from labrig.diagnosis._candidates import Candidate, fit, plausible
from labrig.diagnosis._design_matrix import DesignMatrix, coefficients, columns_of, join, order_of
from labrig.diagnosis._formula import forms_of
from labrig.diagnosis._regression import Regression
from labrig.diagnosis._score import score
from labrig.effects import Context, capture_means, get, join_rows, rows_of
from labrig.effects._fields import contribution
from labrig.effects._registry import shipped

LONG_S = (3.0, 5.0, 10.0, 30.0)


def problem_of(lab: Any, values: np.ndarray, model: Any = None) -> tuple[Regression, Context]:
    """The regression and the context of what a lab measured."""
    ready = prepared(rows_of(lab.dataset(values)), model or lab.model())
    regression, context = ready.regression, ready.context
    return regression, context


@pytest.fixture
def leaking(make_lab) -> tuple[Regression, Context]:
    """Thirty captures of a rig that leaks."""
    lab = make_lab(captures=30, long_s=LONG_S)
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    values = lab.predict(u) + lab.noise()
    values[4, :, 3:6] = np.nan
    return problem_of(lab, values)


def dense(columns: DesignMatrix) -> np.ndarray:
    """Columns over the regression's rows and observables, (S, K, Q), one at a time."""
    return np.stack([columns.field(e) for e in np.eye(columns.width)], axis=2)


def test_lifting_takes_means_and_deviations(leaking) -> None:
    """A feature of rows becomes its mean over each capture, then what differs from it, row by row."""
    regression, context = leaking
    capture = context.rows.capture
    feature = np.random.default_rng(0).normal(size=(len(capture), 2))
    lifted = regression.lift(feature)
    means = np.array([feature[capture == c].mean(axis=0) for c in range(30)])
    assert lifted[:30] == pytest.approx(means)
    assert lifted[30:] == pytest.approx((feature - means[capture])[regression.keep])
    assert regression.source[:30].tolist() == list(range(30))
    assert regression.source[30:].tolist() == capture[regression.keep].tolist()


def test_a_short_follow_up_run_has_blocks_of_its_own(make_lab) -> None:
    """Beside forty captures six more are three of the twelve blocks, none of them shared."""
    long, short = make_lab(captures=40), make_lab(captures=6, seed=1)
    runs = [rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())) for lab in (long, short)]
    ready = prepared(join_rows(runs), long.model())
    regression, context = ready.regression, ready.context
    later = context.rows.session[np.searchsorted(context.rows.capture, regression.source)] == 1
    assert regression.n_groups == 12
    assert len(set(regression.group[later])) == 3
    assert not set(regression.group[later]) & set(regression.group[~later])


def test_a_long_hold_is_left_out_in_parts(make_lab) -> None:
    """Where one hold has most of the rows, its rows fill several blocks: else all that it says sits in one."""
    rows_s = tuple(np.linspace(3.0, 300.0, 20))
    lab = make_lab(captures=20, repeats=False, rows_s=(3.0,), long_s=rows_s)
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    keep = [0, *(c for c in range(20) if int(data["hold_s"][c].notnull().sum()) == 1)]
    longest = int(np.argmax(data["hold_s"].notnull().sum("time").values))
    data = data.isel(capture=sorted({longest, *keep}))
    ready = prepared(rows_of(data), lab.model())
    regression, context = ready.regression, ready.context
    counts = np.bincount(context.rows.capture)
    assert counts.max() > 0.4 * counts.sum()
    assert len(set(regression.row_group[context.rows.capture == counts.argmax()])) > 3


def test_what_was_not_seen_has_no_weight(leaking) -> None:
    """An occluded marker counts for nothing in its capture, and for something elsewhere."""
    regression, _ = leaking
    hidden = regression.source == 4
    assert (regression.weight[hidden][:, 3:6] == 0).all()
    assert (regression.weight[~hidden] > 0).mean() > 0.97
    assert np.isfinite(regression.residual).all()


@pytest.mark.parametrize("name", sorted(shipped()))
def test_columns_are_the_effect_itself(leaking, name: str) -> None:
    """A form's columns, with any coefficients, change the regression as the form itself changes the rows."""
    regression, context = leaking
    rng = np.random.default_rng(0)
    for variant in list(get(name).variants(context))[:4]:
        columns = columns_of(regression, variant)
        beta = rng.normal(size=columns.width)
        change = contribution(context, variant, coefficients(columns, variant, beta))
        wanted = regression.lift(change)
        # its rows take the base's derivative, and the frame's lever, at the beginning of each capture
        assert columns.field(beta) == pytest.approx(wanted, abs=0.02 * np.abs(wanted).max() + 1e-9)


@pytest.mark.parametrize("name", ["leak", "contact", "frame", "coupling"])
def test_scores_are_those_of_refits(leaking, name: str) -> None:
    """The gain of each left-out block is what a weighted ridge fit of all other blocks explains of it."""
    regression, context = leaking
    columns = columns_of(regression, next(iter(get(name).variants(context))))
    fast = score(columns)
    X, w = dense(columns), regression.weight
    gram = np.einsum("skq,sk,skr->qr", X, w, X)
    for g in range(regression.n_groups):
        train, test = regression.group != g, regression.group == g
        G = np.einsum("skq,sk,skr->qr", X[train], w[train], X[train])
        c = np.einsum("skq,sk,sk->q", X[train], w[train], regression.residual[train])
        beta = np.linalg.solve(G + fast.ridge * np.diag(np.diag(G)), c)
        assert fast.fold_beta[g] == pytest.approx(beta, rel=1e-6, abs=1e-12)
        left = regression.residual[test] - X[test] @ beta
        gain = (w[test] * (regression.residual[test] ** 2 - left**2)).sum()
        assert fast.gains[g] == pytest.approx(gain, rel=1e-6, abs=1e-6 * np.abs(fast.gains).max())
    assert columns.sums[0].sum(axis=0) == pytest.approx(gram)


def test_the_base_gives_way_to_an_effect_where_nothing_was_seen_too(make_lab) -> None:
    """What a fitted base gives back beside an effect is what a map fitted to the effect's change has of it, whichever
    markers were seen."""
    from labrig.model import Model

    lab = make_lab(captures=30, chambers=2, bent=0.0, rows_s=(3.0, 10.0, 30.0))
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    values = lab.predict(u)
    values[::3, :, :9] = np.nan
    (lab.folder / "static.yaml").write_text("base: {kind: static, degree: 1}\n")
    regression, context = problem_of(
        lab, values + lab.noise(0.01, 0.01), Model.load(lab.folder / "static.yaml")
    )
    assert regression.declared is not None
    leak = get("leak")
    variant = next(iter(leak.variants(context)))
    columns = columns_of(regression, variant)
    one = Candidate(leak, variant, columns, score(columns)).alone
    change, captures = change_of(context, one), context.rows.capture
    gives = capture_means(whole_change(context, one) - change, captures)[0]
    D, own = regression.declared[: len(gives)], capture_means(change, captures)[0]
    wanted = -D @ np.linalg.lstsq(D, own, rcond=None)[0]
    assert np.abs(wanted).max() > 0.5
    assert gives == pytest.approx(wanted, abs=0.05)


@pytest.mark.parametrize("degree", [1, 2])
def test_the_base_is_refitted_beside_the_effect(make_lab, degree: int) -> None:
    """With a static map as base, the gain is what the effect explains beyond a map fitted to the same blocks."""
    from labrig.model import Model

    lab = make_lab(captures=40, chambers=2, bent=0.0, long_s=LONG_S)
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    (lab.folder / "static.yaml").write_text(f"base: {{kind: static, degree: {degree}}}\n")
    regression, context = problem_of(
        lab, lab.predict(u) + lab.noise(), Model.load(lab.folder / "static.yaml")
    )
    assert regression.declared is not None
    variant = next(iter(get("leak").variants(context)))
    fast = score(columns_of(regression, variant))
    feature = regression.lift(variant.terms[0].feature)
    raw = np.einsum("scq,sck->skq", feature, regression.modes[regression.source][:, :2])
    D, w = regression.declared, regression.weight

    def without(block: int, target: np.ndarray) -> np.ndarray:
        """What a map fitted to the other blocks leaves of the target, rows weighted by their best observable."""
        own = np.sqrt(w.max(axis=1)) * (regression.group != block)
        beta = np.linalg.lstsq(D * own[:, None], target * own[:, None], rcond=None)[0]
        return target - D @ beta

    for g in range(regression.n_groups):
        train, test = regression.group != g, regression.group == g
        r, x = without(g, regression.residual), without(g, raw[:, :, 0])
        G, c = (w * x**2)[train].sum(), (w * x * r)[train].sum()
        beta = c / (G * (1 + fast.ridge))
        gain = (w * (r**2 - (r - beta * x) ** 2))[test].sum()
        assert fast.gains[g] == pytest.approx(gain, rel=1e-4)


def test_effects_side_by_side_keep_their_own_columns(leaking) -> None:
    """Joined columns give the sum of the parts, and `order_of` finds each part's own."""
    regression, context = leaking
    variants = [next(iter(get(n).variants(context))) for n in ("regulator", "frame", "tension")]
    parts = [columns_of(regression, v) for v in variants]
    whole, order = join(parts), order_of(parts)
    assert sorted(np.concatenate(order).tolist()) == list(range(whole.width))
    rng = np.random.default_rng(0)
    beta = rng.normal(size=whole.width)
    each = sum(p.field(beta[o]) for p, o in zip(parts, order, strict=True))
    assert whole.field(beta) == pytest.approx(each)
    both = fit([Candidate(get("leak"), v, p, score(p)) for v, p in zip(variants, parts, strict=True)])
    assert both.heldout.shape == regression.residual.shape


@pytest.mark.parametrize(("stopped", "is_one"), [(0.6, True), (0.03, False)])
def test_a_contact_stops_a_good_part_of_the_motion(make_lab, stopped: float, is_one: bool) -> None:
    """A kink that takes a few hundredths of the motion, however clear, is another law's misfit and no limit."""
    lab = make_lab(captures=60, markers=6)
    u = lab.u
    u[:, :, 0] -= stopped * np.maximum(u[:, :, 0] - 40.0, 0.0) ** 1.2
    ready = prepared(rows_of(lab.dataset(lab.predict(u) + 0.01 * lab.noise())), lab.model())
    regression, context = ready.regression, ready.context
    contact = get("contact")
    forms = {c.variant.key: c for c in forms_of(regression, context, contact)}
    best = forms["one chamber limit=0.7 chamber=0"]
    assert plausible(contact, best.variant, best.columns, best.score) is is_one


def test_blocks_are_sessions_or_stretches(make_lab) -> None:
    """Twelve sessions are left out one by one; six by a stretch of each; one is cut into stretches of neighbours."""
    many = make_lab(captures=36, sessions=12)
    regression, context = problem_of(many, many.predict(many.u) + many.noise())
    assert regression.n_groups == 12
    for g in range(12):
        assert len(np.unique(context.rows.session[regression.row_group == g])) == 1
    some = make_lab(captures=72, sessions=6)
    regression, context = problem_of(some, some.predict(some.u) + some.noise())
    assert regression.n_groups == 6
    for g in range(6):
        own = np.unique(context.rows.capture[regression.row_group == g])
        assert own.tolist() == [12 * s + 2 * g + k for s in range(6) for k in (0, 1)]
    one = make_lab(captures=36)
    regression, context = problem_of(one, one.predict(one.u) + one.noise())
    assert regression.n_groups == 12
    assert (np.diff(regression.row_group) >= 0).all()
    for capture in range(36):
        assert len(np.unique(regression.row_group[context.rows.capture == capture])) == 1
