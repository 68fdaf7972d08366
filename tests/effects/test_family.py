"""Families: the function spaces of an effect have the right shapes on every run, and hold the effect's own forms."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from labrig.effects import Context, Effect, Parameter, Term, Variant, rows_of
from labrig.effects._family import Space, motion_scale
from labrig.effects._fields import contribution
from labrig.effects._forms import spaces_of
from labrig.effects._registry import shipped
from labrig.model import base_context, build_base
from tests.terms import term_width

LONG_S = (3.0, 5.0, 10.0, 20.0, 60.0)
FREER = ("wall at", "plane", "pattern", "two steps", "three steps")
"""Forms that the families do not hold: walls where hardly a marker goes, planes between the directions that are looked
at, products with a pattern for each pair; several markers that slipped, each in a space of its own."""


def context_of(lab: Any, values: np.ndarray | None = None, **extra: Any) -> Context:
    """What the effects are given of a lab's campaign."""
    model = lab.model()
    rows = rows_of(lab.dataset(lab.predict(lab.u) + lab.noise() if values is None else values, **extra))
    return base_context(build_base(model.file, model.folder, rows), rows)


def with_all(make_lab) -> Context:
    """Six markers on three chambers over two sessions, with loads, a temperature, long holds and a slip."""
    lab = make_lab(captures=40, sessions=2, long_s=LONG_S)
    values = lab.predict(lab.u) + lab.noise()
    values[25:, :, 3:6] += 2.0
    loads = {
        "temperature": ("degC", np.linspace(20, 25, 40)),
        "payload": ("g", np.tile([0.0, 50.0], 20)),
        "tilt": ("deg", np.linspace(0, 40, 40)),
    }
    return context_of(lab, values, covariates=loads)


def one_force(make_lab) -> Context:
    """One chamber and one force."""
    return context_of(make_lab(chambers=1, force=True, captures=30, long_s=LONG_S))


def single_rows(make_lab) -> Context:
    """One row a capture."""
    return context_of(make_lab(captures=30, rows_s=(3.0,)))


def unmoved(make_lab) -> Context:
    """Nothing is actuated at all."""
    lab = make_lab(captures=12, chambers=1, force=True, repeats=False)
    lab.commanded[:] = 0.0
    return context_of(lab)


def occluded(make_lab) -> Context:
    """A third of the values not seen, a whole capture and a whole marker among them."""
    lab = make_lab(captures=30, long_s=LONG_S)
    values = (lab.predict(lab.u) + lab.noise()).reshape(30, -1, 6, 3)
    values[lab.random.random(values.shape[:3]) < 0.3] = np.nan
    values[7] = values[:, :, 2] = np.nan
    return context_of(lab, values.reshape(30, -1, 18))


def with_a_plate(make_lab) -> Context:
    """The four markers at one end step together: each of them has the others as its nearest."""
    lab = make_lab(markers=10, captures=40)
    values = lab.predict(lab.u) + lab.noise()
    values[20:, :, :12] += 2.0 * np.sin(np.arange(12))
    return context_of(lab, values)


def check(context: Context, space: Space) -> None:
    """Names, shapes and weights of one space are what the diagnosis relies on."""
    (F, K), C = context.base.shape, len(context.rows.chambers)
    shapes = {"pressure": (F, C), "field": (F, K), "pattern": (F,)}
    names = [f.name for f in space.features]
    assert len(set(names)) == len(names), space.key
    assert space.spectrum
    assert 0 <= space.alike <= 1
    for f in space.features:
        assert f.values.shape == shapes[f.kind], (space.key, f.name)
        assert np.isfinite(f.values).all(), (space.key, f.name)
        assert f.weight > 0, (space.key, f.name)


@pytest.mark.parametrize(
    "build", [with_all, one_force, single_rows, unmoved, occluded, with_a_plate], ids=lambda b: b.__name__
)
def test_spaces_have_the_right_shapes(make_lab, build) -> None:
    """On any run every space is finite, shaped as its kind says, and its features have names of their own."""
    context = build(make_lab)
    for name, effect in shipped().items():
        family, forms = list(effect.family(context)), list(spaces_of(effect, context))
        assert all(space.features for space in forms)
        for spaces in (family, forms):
            keys = [s.key for s in spaces]
            assert len(set(keys)) == len(keys), name
            for space in spaces:
                check(context, space)


def test_every_effect_has_a_family_where_it_can_act(make_lab) -> None:
    """On a run that shows everything each effect has a space, by its family and by its forms."""
    context = with_all(make_lab)
    for name, effect in shipped().items():
        assert list(effect.family(context)), name
        assert list(spaces_of(effect, context)), name


def fields_in(context: Context, space: Space) -> np.ndarray:
    """What the features of a space change in the observables, one column each, (F K, q)."""
    K = context.base.shape[1]
    J = context.jacobian * context.span
    out = []
    for f in space.features:
        if f.kind == "pressure":
            out += [(J[:, :, c] * f.values[:, c, None]).ravel() for c in range(J.shape[2])]
        elif f.kind == "field":
            out.append(f.values.ravel())
        else:
            out += [np.outer(f.values, e).ravel() for e in np.eye(K)]
    return np.stack(out, axis=1)


def followed(context: Context, space: Space, change: np.ndarray) -> float:
    """Share of a change's mean square that a space holds."""
    A, y = fields_in(context, space), change.ravel()
    A = A / np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    left = y - A @ np.linalg.lstsq(A, y, rcond=1e-9)[0]
    return float(1 - np.sum(left**2) / np.sum(y**2))


@pytest.mark.parametrize("name", sorted(shipped()))
def test_a_family_holds_its_own_forms(make_lab, name: str) -> None:
    """What a form of the library changes lies in one of the effect's spaces, nearly; in that of its forms exactly."""
    context = with_all(make_lab)
    effect = shipped()[name]
    rng = np.random.default_rng(0)
    family, forms = list(effect.family(context)), {s.key: s for s in spaces_of(effect, context)}
    first: dict[str, Variant] = {}
    for variant in effect.variants(context):
        first.setdefault(variant.form, variant)
    for variant in first.values():
        drawn = [np.abs(rng.normal(size=term_width(t, context.base.shape[1]))) for t in variant.terms]
        change = contribution(context, variant, drawn)
        own = forms[variant.key if effect.scans else variant.form]
        assert followed(context, own, change) > 1 - 1e-6, variant.key
        if not variant.form.startswith(FREER):
            assert max(followed(context, s, change) for s in family) > 0.98, variant.key


class Mine(Effect):
    """An effect of a user's: what each chamber lacks, a shift of all, and a shape of its own."""

    name = "mine"
    meaning = "Nothing\nat all."
    acts_on = "pressure"
    parameters = tuple(Parameter(n, "1") for n in ("gain", "bias", "level", "turn", "moved"))
    reference = signature = experiment = "none"

    def variants(self, context: Context) -> Iterator[Variant]:
        u, chambers = context.rows.actuation, context.rows.chambers
        for tau in (3.0, 30.0):
            yield Variant("lag", (Term.common("gain", context.relaxed(tau) - u),), {"tau_s": tau})
        yield Variant(
            "all kinds",
            (
                Term.per_chamber("gain", u, chambers),
                Term.common("bias", 1000.0 * np.ones_like(u)),
                Term.pattern("level", np.arange(len(u), dtype=float)),
                Term("turn", "frame", np.ones(len(u))),
                Term.field("moved", 5.0 * context.displacement),
            ),
        )
        yield Variant("nothing", (Term.common("gain", 0.0 * u),))


def test_the_forms_of_an_effect_are_its_family(make_lab) -> None:
    """An effect that says no family has a space for each form: all values of its grid in one, terms of all kinds."""
    context = with_all(make_lab)
    lag, kinds = Mine().family(context)
    assert (lag.key, lag.spectrum, lag.alike) == ("lag", "mine lag", 1.0)
    assert [(f.name, f.kind) for f in lag.features] == [
        ("gain tau_s=3", "pressure"),
        ("gain tau_s=30", "pressure"),
    ]
    wanted = (context.relaxed(3.0) - context.rows.actuation) / context.span
    assert lag.features[0].values == pytest.approx(wanted / np.sqrt(np.mean(wanted**2)))
    assert (kinds.spectrum, kinds.scanned) == ("mine all kinds", 0)
    assert kinds.alike < 1  # chambers may differ
    assert [f.kind for f in kinds.features] == ["pressure"] * 2 + ["pattern"] + ["field"] * 7
    frame = ("x", "y", "z", "about x", "about y", "about z")
    assert [f.name for f in kinds.features[3:9]] == [f"turn {way}" for way in frame]


def test_units_of_coefficients_say_nothing_of_their_size(make_lab) -> None:
    """Pressures and patterns are of order one, fields of the size of the motion, whatever a term's own unit is."""
    context = with_all(make_lab)
    _, kinds = Mine().family(context)
    for f in kinds.features:
        size = f.values / motion_scale(context) if f.kind == "field" else f.values
        assert np.sqrt(np.mean(size**2)) == pytest.approx(1.0)


def test_what_a_scan_found_are_spaces_of_their_own(make_lab) -> None:
    """Of places that were found by looking at the residuals one holds, and it is one of many."""

    class Found(Mine):
        scans = True

    context = with_all(make_lab)
    spaces = list(Found().family(context))
    assert [s.key for s in spaces] == ["lag tau_s=3", "lag tau_s=30", "all kinds"]
    assert {s.spectrum for s in spaces} == {"mine lag", "mine all kinds"}
    assert all(s.scanned == context.rows.n_captures for s in spaces)
