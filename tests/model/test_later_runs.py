"""An effect that was fitted on one run can be evaluated on any later run of the rig, however little that one shows."""

from itertools import product
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.diagnosis._parameters import fitted_on
from labrig.effects import Context, Effect, Variant, rows_of
from labrig.effects._registry import shipped
from labrig.model import EffectEntry, Value, base_context, build_base, evaluate
from tests.terms import term_width

LONG_S = (3.0, 5.0, 10.0, 30.0)
LOGGED = {
    ("drift", "temperature"): "temperature",
    ("friction", "Coulomb along rod"): "rod",
    ("gravity", "payload or tilt"): "the payload and the tilt",
    ("gravity", "own weight too"): "the payload and the tilt",
    ("leak", "as measured"): "measured pressures",
    ("regulator", "as measured"): "measured pressures",
}
"""What a form needs that the poor run does not have, by effect and by how the form's name begins."""


def context_of(lab: Any, data: Any) -> Context:
    """What the effects are given of a run."""
    model, rows = lab.model(), rows_of(data)
    return base_context(build_base(model.file, model.folder, rows), rows)


def rich(make_lab: Any, logged: bool = True, **rig: Any) -> Context:
    """Four sessions, long and short holds, all that can be logged or nothing of it, and a marker that slips."""
    lab = make_lab(captures=48, sessions=4, long_s=LONG_S, bent=1.2, **rig)
    lab.commanded[3, 0] = lab.commanded[7] = 0.0
    values = lab.predict(lab.u) + lab.noise()
    values[20:, :, 3:6] += 4.0
    n = lab.captures
    covariates = {
        "temperature": ("degC", np.linspace(20, 28, n)),
        "payload": ("g", 50.0 * (np.arange(n) % 3)),
        "tilt": ("deg", np.linspace(0, 40, n)),
        "rod": ("mm", 30 * np.sin(0.6 * np.arange(n))),
    }
    data = lab.dataset(values, covariates if logged else None)
    data["measured"] = (("capture", "time", "chamber"), 1.02 * lab.u - 0.1 * lab.hold_s[:, :, None])
    return context_of(lab, data)


def poor(make_lab: Any, captures: int = 1, timed: bool = True, **rig: Any) -> Context:
    """One session at one level, one row a hold, nothing logged beside it."""
    lab = make_lab(captures=captures, rows_s=(3.0,), repeats=False, bent=1.2, **rig)
    lab.commanded[:] = 30.0
    data = lab.dataset(lab.predict(lab.u))
    if not timed:
        data["time_s"], data["event_time_s"] = data["time_s"] * np.nan, data["event_time_s"] * np.nan
    return context_of(lab, data)


def entry_of(context: Context, effect: Effect, variant: Variant) -> EffectEntry:
    """A form as `improve` would save it, with values of 0.1."""
    K = context.base.shape[1]
    values = {
        t.parameter: Value(value=[0.1] * term_width(t, K), per=list(t.labels) or None) for t in variant.terms
    }
    values |= {name: Value(value=value) for name, value in variant.shape.items()}
    on = fitted_on(context, effect, variant)
    return EffectEntry(name=effect.name, form=variant.form, fitted_on=on, parameters=values)


def needed(effect: Effect, form: str) -> str:
    """What a form needs that nobody logged on the poor run."""
    return next(
        (what for (n, start), what in LOGGED.items() if n == effect.name and form.startswith(start)), ""
    )


@pytest.mark.parametrize(
    "rig", [{"chambers": 3}, {"chambers": 1, "force": True}], ids=["markers", "one force"]
)
def test_every_form_acts_on_a_run_that_shows_nothing_of_it(make_lab, rig: dict[str, Any]) -> None:
    """Each form of each effect predicts a run of one hold or one level, or the error names what was not logged."""
    whole = [rich(make_lab, logged, **rig) for logged in (True, False)]
    later = [poor(make_lab, **rig), poor(make_lab, captures=2, **rig)]
    seen = set()
    for fitted, effect in product(whole, shipped().values()):
        for variant in effect.variants(fitted):
            entry = entry_of(fitted, effect, variant)
            missing = needed(effect, variant.form)
            for context in later:
                if not missing:
                    assert np.isfinite(evaluate(context, effect, entry)).all(), (effect.name, variant.key)
                    continue
                with pytest.raises(LabrigError) as caught:
                    evaluate(context, effect, entry)
                assert str(caught.value) == (
                    f"effect {effect.name!r} needs {missing}, which this run did not log (or not everywhere)"
                )
            seen.add((effect.name, bool(missing)))
    only_markers = {("frame", False), ("marker_slip", False), ("coupling", False), ("gravity", False)}
    assert seen >= {(name, False) for name in shipped()} - only_markers
    assert seen >= {(name, True) for name, _ in LOGGED}


def test_without_moments_what_lives_in_time_says_so(make_lab) -> None:
    """On a run without times creep, delay, drift, a slip and a frame that was moved at one moment name the moments that
    they need; all else acts.
    """
    fitted, later = rich(make_lab), poor(make_lab, timed=False)
    for effect in shipped().values():
        for variant in effect.variants(fitted):
            if needed(effect, variant.form):
                continue
            entry = entry_of(fitted, effect, variant)
            timed = (
                effect.name in {"creep", "delay", "drift", "marker_slip"} or "since a moment" in variant.form
            )
            if not timed:
                assert np.isfinite(evaluate(later, effect, entry)).all(), (effect.name, variant.key)
                continue
            with pytest.raises(LabrigError, match=r"needs the moments of its (rows|actuations), which"):
                evaluate(later, effect, entry)


def test_a_slip_that_was_found_without_times_acts_on_a_run_that_has_them(make_lab) -> None:
    """Counted in captures on one run, it is counted in captures on the next."""
    effect = shipped()["marker_slip"]
    lab = make_lab(captures=20)
    values = lab.predict(lab.u) + lab.noise()
    values[12:, :, 3:6] += 5.0
    data = lab.dataset(values)
    timed = context_of(lab, data)
    data["time_s"], data["event_time_s"] = data["time_s"] * np.nan, data["event_time_s"] * np.nan
    entry = entry_of(timed, effect, next(iter(effect.variants(context_of(lab, data)))))
    assert entry.form == "step at a capture"
    slipped = evaluate(timed, effect, entry).any(axis=1)
    assert (slipped == (timed.rows.capture >= 12)).all()


def test_a_frame_that_was_moved_for_a_while_is_where_it_was_before_and_after(make_lab) -> None:
    """On a later run it stands elsewhere between the same two moments, and nowhere else."""
    effect, lab = shipped()["frame"], make_lab(captures=30)
    values = lab.predict(lab.u) + lab.noise()
    values[9:21, :, 2::3] += 4.0
    fitted = context_of(lab, lab.dataset(values))
    (variant,) = (v for v in effect.variants(fitted) if v.form == "rigid, between two moments")
    later = context_of(lab, lab.dataset(lab.predict(lab.u) + lab.noise()))
    moved = evaluate(later, effect, entry_of(fitted, effect, variant)).any(axis=1)
    capture = later.rows.capture
    assert (moved == ((capture >= 9) & (capture < 21))).all()
