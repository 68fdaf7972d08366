"""An effect that was fitted elsewhere, carried over to these runs: a prior, what the runs say, and both together."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.contents import CarriedOver, Summary
from labrig.diagnosis import Opened, Result, drop_of, prepared, rows_from, square_of
from labrig.effects import Context
from labrig.model import EffectEntry, FittedOn, Model, Value, as_fitted
from labrig.passport._combine import Carried, combined, fall, held_out
from labrig.passport._data import evidence_of
from labrig.passport._pool import Pool
from labrig.passport._prior import Prior, labels_of, prior_of, size_of

if TYPE_CHECKING:
    from xarray import Dataset

SPREAD = 0.3
"""How much an effect is taken to differ from place to place, as a share of it, where too few places are known."""
MOST_Z = 3.0
"""So many standard deviations may runs and prior be apart; beyond, the prior is refused."""


def carry(
    runs: "Sequence[Dataset]",
    model: Model,
    names: Sequence[str],
    priors: Sequence[Model],
    *,
    spread: float = SPREAD,
    force: bool = False,
) -> Result:
    """Add effects to a model, from what other models have of them and what these runs say of them.

    Values x with a normal prior (mean m, covariance P: the pooled values of the other models, as uncertain as one more
    place is) and runs that say y with covariance D have the mean (1/P + 1/D)^-1 (m/P + y/D) and the covariance
    (1/P + 1/D)^-1 (A. Gelman et al., Bayesian Data Analysis, 3rd ed., 3.5). Several runs are pooled first, each as
    uncertain as it differs from the others (`pooled`). Where y and m are further apart than `MOST_Z`, by the
    chi-squared of their difference, the prior is refused.

    Raises `LabrigError` where a prior can't be carried over, the runs contradict it, or, unless `force`, the effects do
    not lower the error of captures that they were not fitted to by more than its standard error.
    """
    names = list(dict.fromkeys(names))
    for name in names:
        if any(entry.name == name for entry in model.file.effects):
            raise LabrigError(f"the model has {name!r} already; remove its entry to fit it again")
    readied = [prepared(rows_from(run), model) for run in runs]
    here = readied[0].context
    known = [prior_of(here, name, priors, spread) for name in names]
    evidence = []
    for ready in readied:
        own = [prior_of(ready.context, prior.effect.name, priors, spread) for prior in known]
        forms = [(as_fitted(ready.context, prior.entry), prior.variant) for prior in own]
        evidence.append(evidence_of(ready, forms))
    mean = Pool(
        *(np.concatenate([getattr(p.pool, f) for p in known]) for f in ("mean", "sd", "between", "count"))
    )
    carried = combined(evidence, mean)
    if carried.z > MOST_Z:
        raise LabrigError(_contradiction(known, carried, here))
    entries, at = [], 0
    for prior in known:
        size = len(prior.pool.mean)
        own = slice(at, at + size)
        entries.append(_entry(here, prior, carried.value[own], carried.sd[own]))
        at += size
    values = held_out(evidence, mean)
    gain, error = fall(evidence, values)
    if not force and not gain > error:
        raise LabrigError(
            f"{' and '.join(names)} does not lower the held-out error, with the prior either; "
            "the model is left as it is; --force (force=True) adds it all the same"
        )
    changes = [
        np.einsum("qfk,fq->fk", e.fields, each[np.unique(ready.context.rows.capture, return_inverse=True)[1]])
        for e, each, ready in zip(evidence, values, readied, strict=True)
    ]
    return _result(runs, model, entries, np.concatenate(changes), _told(known, carried))


def _contradiction(known: Sequence[Prior], carried: Carried, context: Context) -> str:
    """The one line that refuses a prior: the value that is farthest off, here and there."""
    off = np.abs(carried.data - carried.prior.mean) / np.hypot(carried.data_sd, carried.prior.predicted_sd)
    worst, at = int(np.argmax(off)), 0
    for prior in known:
        for term in prior.variant.terms:
            size = size_of(term, context)
            if at <= worst < at + size:
                label = (labels_of(term, context) or [""])[min(worst - at, len(labels_of(term, context)) - 1)]
                what = f"{prior.effect.name}: {term.parameter}{f' of {label}' if label else ''}"
                break
            at += size
        else:
            continue
        break
    here = f"{carried.data[worst]:.3g} ± {carried.data_sd[worst]:.2g}"
    there = f"{carried.prior.mean[worst]:.3g} ± {carried.prior.predicted_sd[worst]:.2g}"
    files = ", ".join(dict.fromkeys(file for prior in known for file in prior.sources))
    return (
        f"these runs contradict the prior (z = {carried.z:.1f}, at most {MOST_Z:g}): {what} is {here} here and {there} "
        f"by {files}; fit it without --prior, or name another"
    )


def _entry(context: Context, prior: Prior, value: Floats, sd: Floats) -> EffectEntry:
    """The entry of the new model: the prior's form, with the values of here."""
    fitted = as_fitted(context, prior.entry)
    centre = prior.entry.fitted_on.centre_mm if prior.entry.fitted_on else None
    parameters = {name: prior.entry.parameters[name] for name in prior.variant.shape}
    at = 0
    for term in prior.variant.terms:
        size = size_of(term, context)
        own = [[float(f"{v:.5g}") for v in each[at : at + size]] for each in (value, sd)]
        unit = prior.entry.parameters[term.parameter].unit
        labels = labels_of(term, context) or None
        numbers = {"value": own[0], "sd": own[1]} if size > 1 else {"value": own[0][0], "sd": own[1][0]}
        parameters[term.parameter] = Value(unit=unit, per=labels if size > 1 else None, **numbers)
        at += size
    rows = fitted.rows
    on = FittedOn(
        chambers=list(rows.chambers),
        low=rows.low.tolist(),
        high=rows.high.tolist(),
        unit=rows.actuation_unit,
        centre_mm=centre,
    )
    return EffectEntry(name=prior.effect.name, form=prior.variant.form, fitted_on=on, parameters=parameters)


def _result(
    runs: "Sequence[Dataset]",
    model: Model,
    entries: Sequence[EffectEntry],
    change: Floats,
    told: CarriedOver,
) -> Result:
    improved = model
    for entry in entries:
        improved = improved.with_effect(entry)
    opened = Opened(list(runs), model)
    before, now = opened.compare(), Opened(list(runs), improved).compare()
    base, floor = before.summary["error"]["model"], before.summary["error"]["floor"]
    after = now.summary["error"]["model"]
    regression = opened.ready.regression
    fitted = regression.declared is not None or regression.calibrated is not None
    if len(change) == len(opened.ready.residual) and not fitted:  # else all captures had a part in the values
        after = float(np.sqrt(square_of(regression, regression.residual - regression.lift(change))))
    kept = ("base", "base_everywhere", "error_before")
    fields = now.fields.assign({name: before.fields[name] for name in kept if name in before.fields})
    summary: Summary = {
        "units": before.summary["units"],
        "where": before.summary["where"],
        "runs": before.summary["runs"],
        "model": before.summary["model"],
        "floor": before.summary["floor"],
        "warnings": before.summary["warnings"],
        "effects": [entry.name for entry in entries],
        "error": {"base": base, "model": after, "floor": floor},
        "drop": drop_of(base, after, floor),
        "added": [entry.model_dump(exclude_none=True) for entry in entries],
        "prior": told,
    }
    steps = [("base", base), (f"+ {' + '.join(e.name for e in entries)}", after), ("floor", floor)]
    return Result(summary, fields, steps, [], before.where, improved)


def _told(known: Sequence[Prior], carried: Carried) -> CarriedOver:
    """What the summary says of the prior: from where, how far off, and every value of prior, runs and both."""
    return {
        "sources": list(dict.fromkeys(file for prior in known for file in prior.sources)),
        "z": carried.z,
        "prior": carried.prior.mean.tolist(),
        "prior_sd": carried.prior.predicted_sd.tolist(),
        "data": carried.data.tolist(),
        "data_sd": carried.data_sd.tolist(),
        "value": carried.value.tolist(),
        "sd": carried.sd.tolist(),
        "runs": carried.runs.tolist(),
        "shrunk": carried.shrunk.tolist(),
        "between_runs": carried.between_runs.tolist(),
    }
