"""Every effect of the library, on every kind of run: it says what it is, and its forms have the right shapes."""

from itertools import pairwise

import numpy as np
import pytest

from labrig.effects import Context, Effect, library, rows_of
from labrig.effects._fields import contribution, frame_modes
from labrig.effects._registry import shipped
from labrig.model import base_context, build_base
from tests.terms import term_width

SHIPPED = {
    "hysteresis",
    "creep",
    "regulator",
    "leak",
    "coupling",
    "stiffening",
    "gravity",
    "drift",
    "contact",
    "marker_slip",
    "frame",
    "delay",
    "friction",
    "rest_shape",
    "tension",
}
LONG_S = (3.0, 5.0, 10.0, 20.0, 60.0)
NEEDS_MARKERS = {"marker_slip", "frame"}
NEEDS_HOLDS = {"leak"}
NEEDS_PAIRS = {"coupling"}


def nine(make_lab) -> tuple:
    """Nine chambers, 34 markers, long holds."""
    lab = make_lab(chambers=9, markers=34, captures=40, long_s=LONG_S)
    return lab, lab.dataset(lab.predict(lab.u) + lab.noise())


def one_force(make_lab) -> tuple:
    """One chamber and one force."""
    lab = make_lab(chambers=1, force=True, captures=40, long_s=LONG_S)
    return lab, lab.dataset(lab.predict(lab.u) + lab.noise())


def single_rows(make_lab) -> tuple:
    """One row a capture, and no time in the hold."""
    lab = make_lab(captures=40, rows_s=(3.0,))
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    data["hold_s"] = data["hold_s"] * np.nan
    data["time_s"] = (("capture", "time"), lab.event_s[:, None])
    return lab, data


def without_times(make_lab) -> tuple:
    """One row a capture, of which nobody knows when it was taken."""
    lab, data = single_rows(make_lab)
    data["hold_s"] = data["hold_s"].fillna(3.0)
    return lab, data.assign(time_s=data["time_s"] * np.nan, event_time_s=data["event_time_s"] * np.nan)


def four_sessions(make_lab) -> tuple:
    """Sessions with a night between them, and two covariates."""
    lab = make_lab(captures=40, sessions=4, long_s=LONG_S)
    data = lab.dataset(
        lab.predict(lab.u) + lab.noise(),
        {"temperature": ("degC", lab.random.uniform(20, 25, 40)), "payload": ("g", np.tile([0.0, 50.0], 20))},
    )
    return lab, data


def occluded(make_lab) -> tuple:
    """A third of the markers not seen, a whole capture and a whole marker among them."""
    lab = make_lab(captures=40, long_s=LONG_S)
    values = (lab.predict(lab.u) + lab.noise()).reshape(40, -1, 6, 3)
    values[lab.random.random(values.shape[:3]) < 0.3] = np.nan
    values[7] = np.nan
    values[:, :, 2] = np.nan
    return lab, lab.dataset(values.reshape(40, -1, 18))


def unmoved(make_lab) -> tuple:
    """Nothing is actuated at all."""
    lab = make_lab(captures=12, chambers=1, force=True, repeats=False)
    lab.commanded[:] = 0.0
    return lab, lab.dataset(lab.predict(lab.u) + lab.noise())


RUNS = [nine, one_force, single_rows, four_sessions, occluded, unmoved]


def context_of(lab, data) -> Context:
    """What the effects are given."""
    model = lab.model()
    rows = rows_of(data)
    return base_context(build_base(model.file, model.folder, rows), rows)


def test_the_whole_list_is_there() -> None:
    """The library has the effects that the design promises, each under its own name."""
    assert set(shipped()) == SHIPPED
    for name, effect in library().items():
        assert effect.name == name


@pytest.mark.parametrize("effect", shipped().values(), ids=lambda e: e.name)
def test_an_effect_says_what_it_is(effect: Effect) -> None:
    """Meaning in two lines, where it acts, parameters with units and bounds, a reference, a signature, a test."""
    assert len(effect.meaning.splitlines()) == 2
    assert effect.acts_on in {"pressure", "mechanics", "observation"}
    assert 1 <= len(effect.parameters) <= 12
    for p in effect.parameters:
        assert p.unit
        assert p.meaning
        assert p.low < p.high
        assert effect.parameter(p.name) is p
    for text in (effect.reference, effect.signature, effect.experiment):
        assert len(text) > 15


@pytest.mark.parametrize("build", RUNS, ids=lambda b: b.__name__)
def test_forms_have_the_right_shapes(make_lab, build) -> None:
    """On any run, every form is finite, shaped as its kind says, named once, and within its own parameters."""
    lab, data = build(make_lab)
    context = context_of(lab, data)
    F, K, C = *context.base.shape, lab.chambers
    for name, effect in shipped().items():
        variants = list(effect.variants(context))
        keys = [v.key for v in variants]
        assert len(set(keys)) == len(keys), name
        own = {p.name for p in effect.parameters}
        for variant in variants:
            assert set(variant.shape) <= own, variant.key
            for term in variant.terms:
                assert term.parameter in own, variant.key
                assert np.isfinite(term.feature).all(), (name, variant.key)
                q = term.feature.shape[-1]
                wanted = {"pressure": (F, C, q), "pattern": (F, q), "frame": (F,), "field": (F, K, q)}
                assert term.feature.shape == wanted[term.kind], (name, variant.key)
                assert not term.labels or len(term.labels) == q
        covariate, unit, x = effect.covariate(context)
        assert covariate
        assert unit
        assert x.shape == (F,)
        assert np.isfinite(x).all()


@pytest.mark.parametrize("build", [*RUNS, without_times], ids=lambda b: b.__name__)
def test_families_have_the_right_shapes(make_lab, build) -> None:
    """On any run, without moments too, every function of every family is finite, and shaped as its kind says."""
    lab, data = build(make_lab)
    context = context_of(lab, data)
    F, K, C = *context.base.shape, lab.chambers
    wanted = {"pressure": (F, C), "pattern": (F,), "field": (F, K)}
    for name, effect in shipped().items():
        for space in effect.family(context):
            for feature in space.features:
                assert np.isfinite(feature.values).all(), (name, space.key, feature.name)
                assert feature.values.shape == wanted[feature.kind], (name, space.key, feature.name)


@pytest.mark.parametrize(
    ("build", "absent"),
    [
        (nine, set()),
        (one_force, NEEDS_MARKERS | NEEDS_PAIRS | {"gravity"}),
        (single_rows, NEEDS_HOLDS),
        (four_sessions, set()),
        (occluded, set()),
        (unmoved, SHIPPED - {"creep", "drift", "rest_shape", "leak"}),
    ],
    ids=lambda b: getattr(b, "__name__", ""),
)
def test_an_effect_acts_where_it_can_be_seen(make_lab, build, absent: set[str]) -> None:
    """Everything has a form on markers with holds; what needs markers, holds, pairs or motion has none without."""
    context = context_of(*build(make_lab))
    assert {n for n, e in shipped().items() if not list(e.variants(context))} == absent


def test_a_chain_of_terms_adds_up(make_lab) -> None:
    """What a form changes is linear in its coefficients, for every kind of term."""
    context = context_of(*four_sessions(make_lab))
    rng = np.random.default_rng(0)
    K = context.base.shape[1]
    kinds = set()
    for effect in shipped().values():
        for variant in list(effect.variants(context))[:3]:
            kinds |= {t.kind for t in variant.terms}

            def draw(variant=variant) -> list[np.ndarray]:
                sizes = [term_width(t, K) for t in variant.terms]
                return [rng.normal(size=n) for n in sizes]

            a, b = draw(), draw()
            both = [2 * x + y for x, y in zip(a, b, strict=True)]
            one, two, three = (contribution(context, variant, c) for c in (a, b, both))
            assert three == pytest.approx(2 * one + two, abs=1e-9 * np.abs(three).max() + 1e-12)
    assert kinds == {"pressure", "pattern", "frame", "field"}


def test_the_modes_of_the_frame_move_it_rigidly(make_lab) -> None:
    """Distances between markers do not change to first order, under any of the six motions."""
    context = context_of(*nine(make_lab))
    modes = frame_modes(context).reshape(-1, 34, 3, 6)
    q = context.base.reshape(-1, 34, 3)
    rng = np.random.default_rng(0)
    for _ in range(20):
        f, (i, j) = rng.integers(len(q)), rng.choice(34, 2, replace=False)
        between = q[f, i] - q[f, j]
        assert (between @ (modes[f, i] - modes[f, j])) == pytest.approx(np.zeros(6), abs=1e-9)
    assert modes[:, :, :, :3] == pytest.approx(np.broadcast_to(np.eye(3), (len(q), 34, 3, 3)))


def test_pinned_forms_stay_on_their_values(make_lab) -> None:
    """A form asked for with its fitted values is the only one of its name, and carries just these."""
    context = context_of(*nine(make_lab))
    for name, effect in shipped().items():
        for variant in effect.variants(context):
            if variant.shape:
                again = [v for v in effect.variants(context.pin(variant.shape)) if v.form == variant.form]
                assert [v.shape for v in again] == [variant.shape], (name, variant.key)
                for one, other in zip(again[0].terms, variant.terms, strict=True):
                    assert one.feature == pytest.approx(other.feature)
                break


def test_the_grids_are_in_order(make_lab) -> None:
    """The simplest form comes first, with the values of its grid rising."""
    context = context_of(*nine(make_lab))
    for effect in (shipped()["hysteresis"], shipped()["leak"], shipped()["delay"]):
        first = next(iter(effect.variants(context)))
        values = [next(iter(v.shape.values())) for v in effect.variants(context) if v.form == first.form]
        assert all(a < b for a, b in pairwise(values))
