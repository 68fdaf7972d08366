"""Fitted values with their uncertainty, as they go into a model file."""

import re

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._candidates import Candidate, Fit, fit
from labrig.diagnosis._design_matrix import coefficients, columns_of
from labrig.diagnosis._moved import is_moved, with_shape
from labrig.diagnosis._regression import Regression
from labrig.diagnosis._score import score
from labrig.diagnosis._standard_errors import StandardErrors, standard_errors
from labrig.effects import (
    Context,
    Effect,
    Term,
    Variant,
    centre_of,
    is_family,
    unit_on,
    yardsticks_of,
)
from labrig.model import EffectEntry, FittedOn, Value

_ROUNDS = 9
"""How often an interval is narrowed: from a factor of nine to one of three per cent."""
_GOLDEN = (np.sqrt(5) - 1) / 2
"""The golden section, by which an interval is narrowed."""


def entries_of(context: Context, chosen: Fit) -> list[EffectEntry]:
    """The effects of a fit as entries of a model file."""
    errors = standard_errors(context, chosen)
    return [
        EffectEntry(
            name=part.effect.name,
            form=part.variant.form,
            fitted_on=fitted_on(context, part.effect, part.variant),
            parameters=_parameters_of(context, chosen, i, errors),
        )
        for i, part in enumerate(chosen.parts)
    ]


def parameters_of(context: Context, chosen: Fit, i: int) -> dict[str, Value]:
    """The fitted values of the i-th effect of a fit, with their uncertainty."""
    return _parameters_of(context, chosen, i, standard_errors(context, chosen))


def _parameters_of(context: Context, chosen: Fit, i: int, errors: StandardErrors) -> dict[str, Value]:
    part = chosen.parts[i]
    each = coefficients(part.columns, part.variant, chosen.own(i))
    order = chosen.order(i)
    with_shapes, without = (
        [coefficients(part.columns, part.variant, beta[order]) for beta in some]
        for some in (errors.coefficients, chosen.score.fold_beta)
    )
    parameters: dict[str, Value] = {}
    for t, term in enumerate(part.variant.terms):
        apart, alone = (np.array([one[t] for one in some]) for some in (with_shapes, without))
        value = each[t]
        if term.basis is not None:
            value, apart, alone = term.basis @ value, apart @ term.basis.T, alone @ term.basis.T
        unit = _unit(context, part, term.parameter)
        sds = errors.of(apart), errors.given_shape(alone) if part.variant.shape else None
        parameters[term.parameter] = _value(context, unit, term, value, *sds)
    for name, value in part.variant.shape.items():
        own = part.effect.parameter(name)
        if (relative := errors.shapes.get((i, name))) is not None:
            unit = _unit(context, part, name)
            parameters[name] = Value(value=_round(value), sd=_round(value * relative), unit=unit)
            continue
        value = value if own.given or own.per != "one" else _round(value)
        numbered = {"chamber": context.rows.chambers, "marker": context.rows.markers}
        called = numbered.get("marker" if re.fullmatch(r"marker_\d", name) else name)
        which = [called[int(value)]] if called else None
        parameters[name] = Value(value=value, unit=_unit(context, part, name), per=which)
    return parameters


def _unit(context: Context, part: Candidate, parameter: str) -> str:
    return part.variant.units.get(parameter) or unit_on(context, part.effect.parameter(parameter).unit)


def fitted_on(context: Context, effect: Effect, variant: Variant) -> FittedOn:
    """What the values of a form refer to on this run."""
    rows = context.rows
    centred = variant.centred or any(term.kind == "frame" for term in variant.terms)
    dated = "since_s" in variant.shape and np.isfinite(rows.start_s)
    weights = is_family(variant.form)
    measures = yardsticks_of(effect, context, variant.form) if weights else {}
    return FittedOn(
        chambers=list(rows.chambers),
        low=rows.low.tolist(),
        high=rows.high.tolist(),
        unit=rows.actuation_unit,
        centre_mm=centre_of(context).tolist() if centred else None,
        start_s=rows.start_s if dated else None,
        yardsticks={name: value.tolist() for name, value in measures.items()} or None,
        lowest=rows.actuation.min(axis=0).tolist() if weights else None,
        highest=rows.actuation.max(axis=0).tolist() if weights else None,
    )


def refined(regression: Regression, context: Context, chosen: Fit, i: int) -> Fit:
    """Move what is not linear in the i-th effect (time constants, widths) to where the joint fit is best."""
    for name in chosen.parts[i].variant.shape:
        if not is_moved(chosen.parts[i], name):
            continue
        start, parameter = chosen.parts[i].variant.shape[name], chosen.parts[i].effect.parameter(name)
        low = max(start / 3, parameter.low, 1e-9)
        high = min(start * 3, parameter.high)
        a, b = np.log(low), np.log(high)
        inner, outer = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
        tried = [_with_shape(regression, context, chosen, i, name, float(np.exp(v))) for v in (inner, outer)]
        best = max([chosen, *tried], key=_gain)
        for _ in range(_ROUNDS):  # of the two inside, one stays inside
            lower = _gain(tried[0]) > _gain(tried[1])
            if lower:
                b, inner, outer = outer, outer - _GOLDEN * (outer - a), inner
            else:
                a, inner, outer = inner, outer, inner + _GOLDEN * (b - inner)
            value = float(np.exp(inner if lower else outer))
            new = _with_shape(regression, context, chosen, i, name, value)
            tried = [new, tried[0]] if lower else [tried[1], new]
            best = max([best, new], key=_gain)
        chosen = best or chosen
    return chosen


def off_grid(one: Candidate) -> Candidate:
    """A form by itself, moved to where it fits best."""
    return refined(one.columns.regression, one.columns.regression.context, one.alone, 0).parts[0]


def _gain(one: Fit | None) -> float:
    return -np.inf if one is None else one.score.gain


def _with_shape(
    regression: Regression, context: Context, chosen: Fit, i: int, name: str, value: float
) -> Fit | None:
    part = chosen.parts[i]
    variant = with_shape(context, part, name, value)
    if variant is None:
        return None
    columns = columns_of(regression, variant)
    moved = Candidate(part.effect, variant, columns, score(columns))
    return fit([*chosen.parts[:i], moved, *chosen.parts[i + 1 :]])


def _value(
    context: Context, unit: str, term: Term, value: Floats, sd: Floats, given_shape: Floats | None
) -> Value:
    """A term's fitted value with its uncertainty: a number, or a list with what each of its numbers is of."""
    if value.size == 1:
        given = None if given_shape is None else _round(given_shape.item())
        return Value(value=_round(value.item()), sd=_round(sd.item()), sd_given_shape=given, unit=unit)
    if value.ndim == 2 and len(value) == 1:
        value, sd = value[0], sd[0]
        given_shape = None if given_shape is None else given_shape[0]
    per = list(term.labels) or None
    if term.kind == "pattern":
        per = list(term.labels or context.rows.observables)
    elif term.kind == "frame":
        per = ["x", "y", "z", "about x", "about y", "about z"]
    given = None if given_shape is None else _rounded(given_shape)
    return Value(value=_rounded(value), sd=_rounded(sd), sd_given_shape=given, unit=unit, per=per)


def _rounded(values: Floats) -> list[float] | list[list[float]]:
    if values.ndim == 2:
        return [[_round(v) for v in row] for row in values]
    return [_round(v) for v in values]


def _round(value: float) -> float:
    return float(f"{value:.5g}")
