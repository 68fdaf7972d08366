"""What a saved effect means does not depend on the run that it is evaluated on, nor on how far or long that one went.

Each form is taken from a long campaign with large pressures, given coefficients and saved; then it is asked for the
beginning of that campaign, where pressures were small: a run of its own that knows nothing of what came later.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from labrig._errors import LabrigError
from labrig.diagnosis._parameters import fitted_on
from labrig.effects import Context, Effect, Rows, Variant, form_of, labels_of, rows_of, weighable, weighted
from labrig.effects._fields import contribution, frame_modes, overlap
from labrig.effects._registry import shipped
from labrig.model import EffectEntry, FittedOn, Value, base_context, build_base, evaluate
from tests.terms import term_width

SESSIONS, EACH = 4, 8
SMALL, FEW = 2 * EACH, 9
LONG_S = (3.0, 5.0, 10.0, 30.0)
EDGE = 3
"""Rows at the end of a run whose speed of motion is not yet known as well as later."""


@pytest.fixture(params=[(3, False), (1, True)], ids=["markers", "one force"])
def lab(request: pytest.FixtureRequest, make_lab) -> Any:
    """A rig whose campaign begins with half of its pressures, in its first two sessions."""
    chambers, force = request.param
    made = make_lab(
        chambers=chambers, force=force, captures=SESSIONS * EACH, sessions=SESSIONS, long_s=LONG_S, bent=1.2
    )
    made.commanded[:SMALL] *= 0.5
    made.commanded[3, 0] = made.commanded[7] = 0.0
    return made


def campaign(lab: Any, *, logged: bool, limits: bool) -> xr.Dataset:
    """What the rig measures: marker 1 slips in the first session; with more logged beside it, or without limits."""
    values = lab.predict(lab.u) + lab.noise()
    values[5:, :, 3:6] += 4.0
    rng = np.random.default_rng(1)
    n = lab.captures
    covariates = {
        "temperature": ("degF", np.linspace(68, 80, n) + rng.normal(0, 0.5, n)),
        "payload": ("g", np.where(np.arange(n) < SMALL, 50.0, 250.0) * rng.integers(0, 2, n)),
        "tilt": ("deg", np.linspace(0, 40, n)),
        "rod": ("mm", 30 * np.sin(0.6 * np.arange(n)) * np.linspace(0.5, 2, n)),
    }
    data = lab.dataset(values, covariates if logged else None)
    data["measured"] = (("capture", "time", "chamber"), 1.02 * lab.u - 0.1 * lab.hold_s[:, :, None])
    if not limits:
        data["chamber_min"] = ("chamber", np.full(lab.chambers, np.nan))
        data["chamber_max"] = ("chamber", np.full(lab.chambers, np.nan))
    return data


def families(effect: Effect, context: Context) -> Iterator[Variant]:
    """The forms in which the effect's own functions are weighted, as they are read from a model file."""
    for space in weighable(effect, context):
        labels = labels_of(space, context.rows.chambers)
        yield weighted(effect, context, form_of(space), labels)


def context_of(lab: Any, rows: Rows) -> Context:
    """What the effects are given of these rows."""
    model = lab.model()
    return base_context(build_base(model.file, model.folder, rows), rows)


def saved(context: Context, effect: Effect, variant: Variant) -> tuple[EffectEntry, list[np.ndarray]]:
    """A form with coefficients of its own as an entry of a model file, and these."""
    rng = np.random.default_rng(len(variant.key))
    K = context.base.shape[1]
    drawn = [rng.normal(0.2, 0.1, term_width(term, K)) for term in variant.terms]
    values = {
        t.parameter: Value(value=c.tolist(), per=list(t.labels) or None)
        for t, c in zip(variant.terms, drawn, strict=True)
    }
    values |= {name: Value(value=value) for name, value in variant.shape.items()}
    on = fitted_on(context, effect, variant)
    entry = EffectEntry(name=effect.name, form=variant.form, fitted_on=on, parameters=values)
    return EffectEntry.model_validate(entry.model_dump()), drawn


@pytest.mark.parametrize(
    ("logged", "limits"), [(True, True), (False, False)], ids=["logged", "bare, no limits"]
)
def test_a_saved_effect_means_the_same_on_a_smaller_run(lab: Any, logged: bool, limits: bool) -> None:
    """Every form of every effect changes the rows of a run by as much, whether larger and later ones follow or not."""
    data = campaign(lab, logged=logged, limits=limits)
    whole = context_of(lab, rows_of(data))
    parts = [data.isel(capture=slice(n), event=slice(n)) for n in (SMALL, FEW)]
    smaller = [context_of(lab, rows_of(part)) for part in parts]
    for small in smaller:
        assert small.rows.actuation.max() < 0.6 * whole.rows.actuation.max()
        assert (small.rows.hold_s == whole.rows.hold_s[: len(small.base)]).all()
    # the slopes' finite differences have steps of the run's own range
    exact = 1e-9 if limits else 1e-5
    seen = set()
    for name, effect in shipped().items():
        for variant in (*effect.variants(whole), *families(effect, whole)):
            entry, drawn = saved(whole, effect, variant)
            there = evaluate(whole, effect, entry)
            scale = np.abs(there).max()
            before = contribution(whole, variant, drawn)
            np.testing.assert_allclose(there, before, rtol=1e-6, atol=1e-9 * scale, err_msg=str(variant.key))
            for small in smaller:
                kept = len(small.base) - (EDGE if "full_speed" in variant.shape else 0)
                here = evaluate(small, effect, entry)[:kept]
                what = f"{name} {variant.key}"
                np.testing.assert_allclose(here, there[:kept], rtol=1e-6, atol=exact * scale, err_msg=what)
            seen.add(name)
    needs_more = {"marker_slip", "frame"} | ({"coupling"} if lab.chambers == 1 else set())
    assert seen >= set(shipped()) - (needs_more | {"gravity"} if lab.force else set())


def test_a_limit_that_is_never_reached_changes_nothing(make_lab) -> None:
    """A wall 15 mm away is no error, and no effect, on a run that goes 5 mm."""
    lab = make_lab(captures=20)
    lab.commanded *= 0.1
    context = context_of(lab, rows_of(lab.dataset(lab.predict(lab.u))))
    values = {"stopped": Value(value=1.0), "distance": Value(value=15.0, unit="mm")}
    for form in ("travel", "wall at +z", "wall at -x"):
        entry = EffectEntry(name="contact", form=form, parameters=values)
        assert not evaluate(context, shipped()["contact"], entry).any()


def test_units_are_converted(make_lab) -> None:
    """A payload in newtons and a temperature in kelvin are those in kilograms and degrees Celsius."""
    lab = make_lab(captures=20)
    mass, warm = lab.random.uniform(0, 2, 20), lab.random.uniform(18, 30, 20)

    def change(name: str, logged: str, unit: str, x: np.ndarray, **values: float) -> np.ndarray:
        context = context_of(lab, rows_of(lab.dataset(lab.predict(lab.u), {logged: (unit, x)})))
        form = {"gravity": "payload or tilt", "drift": f"{logged}, gain"}[name]
        own = {k: Value(value=v) for k, v in values.items()}
        return evaluate(context, shipped()[name], EffectEntry(name=name, form=form, parameters=own))

    one = change("gravity", "payload", "kg", mass, payload=-2.0)
    assert one[::3, 0] == pytest.approx(-2 * mass)
    assert change("gravity", "payload", "N", 9.80665 * mass, payload=-2.0) == pytest.approx(one)
    one = change("drift", "temperature", "degC", warm, gain_per_k=0.01, reference=20.0)
    other = change("drift", "temperature", "K", warm + 273.15, gain_per_k=0.01, reference=20.0)
    assert other == pytest.approx(one)


def test_turns_are_about_the_markers_at_rest(make_lab) -> None:
    """Where pressures push the markers does not move the point that a frame turns about; a saved one stays."""
    lab = make_lab(captures=20)
    context = context_of(lab, rows_of(lab.dataset(lab.predict(lab.u))))
    modes = frame_modes(context)
    pushed = replace(context, base=context.base + 30.0)
    assert (frame_modes(pushed) - modes)[:, 0, 4] == pytest.approx(30.0)
    moved = replace(context, centre=np.array([0.0, 0.0, 5.0]))
    rest = lab.rest_mm.mean(axis=0)
    assert (frame_modes(moved) - modes)[:, 0, 4] == pytest.approx(rest[2] - 5.0)


def test_neighbours_are_the_rigs_own(make_lab) -> None:
    """Which chambers overlap does not depend on which of them a run inflates."""
    lab = make_lab(captures=20)
    whole = overlap(context_of(lab, rows_of(lab.dataset(lab.predict(lab.u)))))
    lab.commanded[:, 1] = 0.0
    assert overlap(context_of(lab, rows_of(lab.dataset(lab.predict(lab.u))))) == pytest.approx(whole)


def test_a_slip_stays_at_its_moment(make_lab) -> None:
    """On a run that began an hour later the marker has slipped from the first row; on one before, not at all."""
    lab = make_lab(captures=20)
    values = lab.predict(lab.u) + lab.noise()
    values[12:, :, 3:6] += 5.0
    context = context_of(lab, replace(rows_of(lab.dataset(values)), start_s=1.7e9))
    effect = shipped()["marker_slip"]
    entry, _ = saved(context, effect, next(iter(effect.variants(context))))
    slipped = evaluate(context, effect, entry).any(axis=1)
    assert (slipped == (context.rows.capture >= 12)).all()
    for late, share in ((3600.0, 1.0), (-3600.0, 0.0)):
        other = replace(context, rows=replace(context.rows, start_s=1.7e9 + late), _memo={})
        assert evaluate(other, effect, entry).any(axis=1).mean() == share


def test_a_frame_stays_moved_from_its_moment(make_lab) -> None:
    """On a run that began an hour later the frame was moved from the first row on; on one before, not yet."""
    lab = make_lab(captures=20)
    values = lab.predict(lab.u) + lab.noise()
    values[12:] += np.tile([3.0, -2.0, 4.0], lab.markers)
    context = context_of(lab, replace(rows_of(lab.dataset(values)), start_s=1.7e9))
    effect = shipped()["frame"]
    entry, _ = saved(context, effect, next(v for v in effect.variants(context) if "since" in v.form))
    moved = evaluate(context, effect, entry).any(axis=1)
    assert (moved == (context.rows.capture >= 12)).all()
    for late, share in ((3600.0, 1.0), (-3600.0, 0.0)):
        other = replace(context, rows=replace(context.rows, start_s=1.7e9 + late), _memo={})
        assert evaluate(other, effect, entry).any(axis=1).mean() == share


def test_what_an_entry_refers_to_must_be_whole() -> None:
    """A range without its chamber, or upside down, is refused."""
    with pytest.raises(ValueError, match="as many values"):
        FittedOn(chambers=["c1"], low=[0.0], high=[])
    with pytest.raises(ValueError, match="below"):
        FittedOn(chambers=["c1"], low=[3.0], high=[3.0])


def test_an_effect_of_chambers_with_other_names_is_refused(make_lab) -> None:
    """Values of chambers that the run does not have would act on some of them, or on none, without a word."""
    lab = make_lab(captures=20, chambers=2)
    context = context_of(lab, rows_of(lab.dataset(lab.predict(lab.u))))
    effect = shipped()["regulator"]
    entry, _ = saved(context, effect, next(iter(effect.variants(context))))
    evaluate(context, effect, entry)
    renamed = replace(context, rows=replace(context.rows, chambers=("q1", "q2")), _memo={})
    with pytest.raises(LabrigError) as caught:
        evaluate(renamed, effect, entry)
    assert str(caught.value) == (
        "effect 'regulator' was fitted with the chambers c1, c2, and this run has q1, q2: give them the same names, or "
        "fit it again"
    )


def test_another_range_needs_the_base(make_lab) -> None:
    """A context that was made without its base says so, rather than take this run's range for the saved one."""
    lab = make_lab(captures=20)
    context = replace(context_of(lab, rows_of(lab.dataset(lab.predict(lab.u)))), alone=None)
    assert context.within(context.rows.low, context.rows.high) is context
    with pytest.raises(LabrigError, match="another range"):
        context.within(context.rows.low, 2 * context.rows.high)
