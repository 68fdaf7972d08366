"""Scores: streams, columns, leave-block-out gains and sign flips do what their slow counterparts do."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepare
from labrig.diagnosis._candidates import Candidate, draw_signs, explore, fit, lay_out, plausible, relative
from labrig.diagnosis._columns import Columns, coefficients, columns_of, join, order_of
from labrig.diagnosis._outliers import clean
from labrig.diagnosis._score import null_gains, score
from labrig.diagnosis._streams import Streams
from labrig.effects import Context, get, join_rows, rows_of
from labrig.effects._fields import contribution
from labrig.effects._registry import shipped

LONG_S = (3.0, 5.0, 10.0, 30.0)


def prepared(lab: Any, values: np.ndarray, model: Any = None) -> tuple[Streams, Context]:
    """Streams and context of what a lab measured."""
    streams, context, _, _ = prepare(rows_of(lab.dataset(values)), model or lab.model())
    return streams, context


@pytest.fixture
def leaking(make_lab) -> tuple[Streams, Context]:
    """Thirty captures of a rig that leaks."""
    lab = make_lab(captures=30, long_s=LONG_S)
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    values = lab.predict(u) + lab.noise()
    values[4, :, 3:6] = np.nan
    return prepared(lab, values)


def dense(columns: Columns) -> np.ndarray:
    """Columns over streams and observables, (S, K, Q), one at a time."""
    return np.stack([columns.field(e) for e in np.eye(columns.width)], axis=2)


def test_lifting_takes_means_and_deviations(leaking) -> None:
    """A feature of rows becomes its mean over each capture, then what differs from it, row by row."""
    streams, context = leaking
    capture = context.rows.capture
    feature = np.random.default_rng(0).normal(size=(len(capture), 2))
    lifted = streams.lift(feature)
    means = np.array([feature[capture == c].mean(axis=0) for c in range(30)])
    assert lifted[:30] == pytest.approx(means)
    assert lifted[30:] == pytest.approx((feature - means[capture])[streams.keep])
    assert streams.source[:30].tolist() == list(range(30))
    assert streams.source[30:].tolist() == capture[streams.keep].tolist()


def test_a_short_follow_up_run_has_blocks_of_its_own(make_lab) -> None:
    """Beside forty captures six more are three of the twelve blocks, none of them shared."""
    long, short = make_lab(captures=40), make_lab(captures=6, seed=1)
    runs = [rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())) for lab in (long, short)]
    streams, context, _, _ = prepare(join_rows(runs), long.model())
    later = context.rows.session[np.searchsorted(context.rows.capture, streams.source)] == 1
    assert streams.n_groups == 12
    assert len(set(streams.group[later])) == 3
    assert not set(streams.group[later]) & set(streams.group[~later])


def test_a_long_hold_is_left_out_in_parts(make_lab) -> None:
    """Where one hold has most of the rows, its rows fill several blocks: else all that it says sits in one."""
    rows_s = tuple(np.linspace(3.0, 300.0, 20))
    lab = make_lab(captures=20, repeats=False, rows_s=(3.0,), long_s=rows_s)
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    keep = [0, *(c for c in range(20) if int(data["hold_s"][c].notnull().sum()) == 1)]
    longest = int(np.argmax(data["hold_s"].notnull().sum("time").values))
    data = data.isel(capture=sorted({longest, *keep}))
    streams, context, _, _ = prepare(rows_of(data), lab.model())
    counts = np.bincount(context.rows.capture)
    assert counts.max() > 0.4 * counts.sum()
    assert len(set(streams.row_group[context.rows.capture == counts.argmax()])) > 3


def test_what_was_not_seen_has_no_weight(leaking) -> None:
    """An occluded marker counts for nothing in its capture, and for something elsewhere."""
    streams, _ = leaking
    hidden = streams.source == 4
    assert (streams.weight[hidden][:, 3:6] == 0).all()
    assert (streams.weight[~hidden] > 0).mean() > 0.97
    assert np.isfinite(streams.residual).all()


@pytest.mark.parametrize("name", sorted(shipped()))
def test_columns_are_the_effect_itself(leaking, name: str) -> None:
    """A form's columns, with any coefficients, change the streams as the form itself changes the rows."""
    streams, context = leaking
    rng = np.random.default_rng(0)
    for variant in list(get(name).variants(context))[:4]:
        columns = columns_of(streams, variant)
        beta = rng.normal(size=columns.width)
        change = contribution(context, variant, coefficients(columns, variant, beta))
        wanted = streams.lift(change)
        # the streams take the base's derivative, and the frame's lever, at the beginning of each capture
        assert columns.field(beta) == pytest.approx(wanted, abs=0.02 * np.abs(wanted).max() + 1e-9)


@pytest.mark.parametrize("name", ["leak", "contact", "frame", "coupling"])
def test_scores_are_those_of_refits(leaking, name: str) -> None:
    """The gain of each left-out block is what a weighted ridge fit of all other blocks explains of it."""
    streams, context = leaking
    columns = columns_of(streams, next(iter(get(name).variants(context))))
    fast = score(columns)
    X, w = dense(columns), streams.weight
    gram = np.einsum("skq,sk,skr->qr", X, w, X)
    for g in range(streams.n_groups):
        train, test = streams.group != g, streams.group == g
        G = np.einsum("skq,sk,skr->qr", X[train], w[train], X[train])
        c = np.einsum("skq,sk,sk->q", X[train], w[train], streams.residual[train])
        beta = np.linalg.solve(G + fast.ridge * np.diag(np.diag(G)), c)
        assert fast.fold_beta[g] == pytest.approx(beta, rel=1e-6, abs=1e-12)
        left = streams.residual[test] - X[test] @ beta
        gain = (w[test] * (streams.residual[test] ** 2 - left**2)).sum()
        assert fast.gains[g] == pytest.approx(gain, rel=1e-6, abs=1e-6 * np.abs(fast.gains).max())
    assert columns.sums[0].sum(axis=0) == pytest.approx(gram)


@pytest.mark.parametrize("degree", [1, 2])
def test_the_base_is_refitted_beside_the_effect(make_lab, degree: int) -> None:
    """With a static map as base, the gain is what the effect explains beyond a map fitted to the same blocks."""
    from labrig.model import Model

    lab = make_lab(captures=40, chambers=2, bent=0.0, long_s=LONG_S)
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    (lab.folder / "static.yaml").write_text(f"base: {{kind: static, degree: {degree}}}\n")
    streams, context = prepared(lab, lab.predict(u) + lab.noise(), Model.load(lab.folder / "static.yaml"))
    assert streams.declared is not None
    variant = next(iter(get("leak").variants(context)))
    fast = score(columns_of(streams, variant))
    feature = streams.lift(variant.terms[0].feature)
    raw = np.einsum("scq,sck->skq", feature, streams.modes[streams.source][:, :2])
    D, w = streams.declared, streams.weight

    def without(block: int, target: np.ndarray) -> np.ndarray:
        """What a map fitted to the other blocks leaves of the target, rows weighted by their best observable."""
        own = np.sqrt(w.max(axis=1)) * (streams.group != block)
        beta = np.linalg.lstsq(D * own[:, None], target * own[:, None], rcond=None)[0]
        return target - D @ beta

    for g in range(streams.n_groups):
        train, test = streams.group != g, streams.group == g
        r, x = without(g, streams.residual), without(g, raw[:, :, 0])
        G, c = (w * x**2)[train].sum(), (w * x * r)[train].sum()
        beta = c / (G * (1 + fast.ridge))
        gain = (w * (r**2 - (r - beta * x) ** 2))[test].sum()
        assert fast.gains[g] == pytest.approx(gain, rel=1e-4)


def test_effects_side_by_side_keep_their_own_columns(leaking) -> None:
    """Joined columns give the sum of the parts, and `order_of` finds each part's own."""
    streams, context = leaking
    variants = [next(iter(get(n).variants(context))) for n in ("regulator", "frame", "tension")]
    parts = [columns_of(streams, v) for v in variants]
    whole, order = join(parts), order_of(parts)
    assert sorted(np.concatenate(order).tolist()) == list(range(whole.width))
    rng = np.random.default_rng(0)
    beta = rng.normal(size=whole.width)
    each = sum(p.field(beta[o]) for p, o in zip(parts, order, strict=True))
    assert whole.field(beta) == pytest.approx(each)
    both = fit([Candidate(get("leak"), v, p, score(p)) for v, p in zip(variants, parts, strict=True)])
    assert both.heldout.shape == streams.residual.shape


def test_flipped_signs_are_a_fair_null(make_lab) -> None:
    """On noise alone, the p-value of the whole search is nearly uniform: it says 'rare' as rarely as it should."""
    ranks = []
    effects = {n: get(n) for n in ("regulator", "leak", "hysteresis", "coupling", "drift")}
    for seed in range(24):
        lab = make_lab(captures=24, markers=4, chambers=2, seed=seed, long_s=(3.0, 8.0, 20.0))
        streams, context = prepared(lab, lab.predict(lab.u) + lab.noise())
        found, largest = explore(streams, context, effects, draw_signs(streams.n_groups, draws=99))
        gains = [relative(c.score.gains, streams.base_squares) for forms in found.values() for c in forms]
        ranks.append((1 + (largest >= max(gains, default=0.0)).sum()) / 100)
    p = np.sort(ranks)
    assert (p <= 0.05).mean() <= 0.125
    assert 0.3 < p.mean() < 0.85


def test_a_flip_of_all_signs_changes_nothing(leaking) -> None:
    """The null's gain for no flip, and for a flip of all, is the observed one."""
    streams, context = leaking
    columns = columns_of(streams, next(iter(get("leak").variants(context))))
    scored = score(columns)
    n = streams.n_groups
    both = null_gains(columns, np.array([np.ones(n), -np.ones(n)]), scored.ridge, streams.base_squares)
    assert both == pytest.approx(np.full(2, relative(scored.gains, streams.base_squares)))


def test_outliers_go_and_a_slip_stays(make_lab) -> None:
    """A marker mistaken for a capture or a frame is dropped; one that moves and stays off is not."""
    lab = make_lab(captures=40, markers=12)
    values = lab.predict(lab.u) + lab.noise()
    bad = [(5, 0, 7), (11, 1, 3), (23, 2, 30)]
    for capture, row, k in bad:
        values[capture, row, k] += 25.0
    values[17, :, 12:15] += 30.0
    values[25:, :, 21:24] += 4.0
    data, model = lab.dataset(values), lab.model()
    rows = rows_of(data)
    cleaned, dropped = clean(model.context(rows))
    gone = np.isnan(cleaned).reshape(40, 3, 36)
    assert all(gone[entry] for entry in bad)
    assert gone[17, :, 12:15].all()
    assert gone[25:, :, 21:24].mean() < 0.5
    elsewhere = np.delete(gone, [21, 22, 23], axis=2).sum()
    assert elsewhere <= 3 + 9 + 0.01 * gone.size
    assert dropped == gone.sum()
    assert diagnose(data, model).summary["effects"] == ["marker_slip"]


def test_a_large_effect_is_no_outlier(make_lab) -> None:
    """A sharp kink of one chamber, and a jump between sessions, are left as they are."""
    lab = make_lab(captures=40, markers=12, sessions=2)
    u = lab.u
    u[:, :, 0] -= 0.7 * np.maximum(u[:, :, 0] - 45, 0)
    values = lab.predict(u) + lab.noise()
    values[20:] += 3.0
    rows = rows_of(lab.dataset(values))
    _, dropped = clean(lab.model().context(rows))
    assert dropped <= 0.005 * values.size


def test_two_mistakes_in_a_row_of_a_few_observables_go(make_lab) -> None:
    """Neighbours that are mistaken themselves do not make a mistake believed, be they rows or whole captures."""
    lab = make_lab(captures=40, markers=1)
    values = lab.predict(lab.u) + lab.noise()
    values[5, 1, 0] += 25.0
    values[6, 0, 0] += 30.0
    values[20:22, :, 1] -= 28.0
    cleaned, dropped = clean(lab.model().context(rows_of(lab.dataset(values))))
    gone = np.isnan(cleaned).reshape(40, 3, 3)
    assert gone[5, 1, 0]
    assert gone[6, 0, 0]
    assert gone[20:22, :, 1].all()
    assert dropped <= 8 + 0.01 * gone.size


def test_what_others_at_the_same_pressures_say_is_believed(make_lab) -> None:
    """A limit that a few captures meet, one here and one there, is no mistake of those captures."""
    lab = make_lab(captures=60, markers=1)
    seldom = np.arange(60) % 12 == 5
    lab.commanded[:, 0] = np.where(seldom, 58.0, np.minimum(lab.commanded[:, 0], 40.0))
    values = lab.predict(lab.u) + lab.noise()
    values[seldom] -= 9.0
    cleaned, _ = clean(lab.model().context(rows_of(lab.dataset(values))))
    assert not np.isnan(cleaned).reshape(60, 3, 3)[seldom].any()
    values[30] -= 9.0
    cleaned, _ = clean(lab.model().context(rows_of(lab.dataset(values))))
    assert np.isnan(cleaned).reshape(60, 3, 3)[30].all()


def test_what_other_long_holds_say_is_believed(make_lab) -> None:
    """What is far off late in every long hold, and nowhere else, is no mistake of those rows."""
    lab = make_lab(captures=60, markers=1, long_s=LONG_S)
    values = lab.predict(lab.u) + lab.noise()
    late = np.isfinite(lab.hold_s) & (lab.hold_s >= 30.0)
    values[late] -= 9.0
    rows = rows_of(lab.dataset(values))
    cleaned, _ = clean(lab.model().context(rows))
    assert not np.isnan(cleaned)[rows.hold_s >= 30.0].any()


@pytest.mark.parametrize(("stopped", "is_one"), [(0.6, True), (0.03, False)])
def test_a_contact_stops_a_good_part_of_the_motion(make_lab, stopped: float, is_one: bool) -> None:
    """A kink that takes a few hundredths of the motion, however clear, is another law's misfit and no limit."""
    lab = make_lab(captures=60, markers=6)
    u = lab.u
    u[:, :, 0] -= stopped * np.maximum(u[:, :, 0] - 40.0, 0.0) ** 1.2
    streams, context, _, _ = prepare(rows_of(lab.dataset(lab.predict(u) + 0.01 * lab.noise())), lab.model())
    contact = get("contact")
    forms = {c.variant.key: c for c in lay_out(streams, contact, list(contact.variants(context)))}
    best = forms["one chamber limit=0.7 chamber=0"]
    assert plausible(contact, best.variant, best.columns, best.score) is is_one


def test_blocks_are_sessions_or_stretches(make_lab) -> None:
    """Six sessions are left out one by one; fewer are cut into stretches of neighbouring captures."""
    many = make_lab(captures=36, sessions=6)
    streams, context = prepared(many, many.predict(many.u) + many.noise())
    assert streams.n_groups == 6
    for g in range(6):
        assert len(np.unique(context.rows.session[streams.row_group == g])) == 1
    one = make_lab(captures=36)
    streams, context = prepared(one, one.predict(one.u) + one.noise())
    assert streams.n_groups == 12
    assert (np.diff(streams.row_group) >= 0).all()
    for capture in range(36):
        assert len(np.unique(streams.row_group[context.rows.capture == capture])) == 1
