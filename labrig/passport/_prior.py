"""What other models say of an effect, in the form that it takes on these runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.effects import Context, Effect, Term, Variant, get, is_family, library
from labrig.model import EffectEntry, Model, find_variant
from labrig.passport._pool import Pool, pooled


@dataclass(frozen=True)
class Prior:
    """An effect from elsewhere: its `effect`, the `variant` that it is here, and what its Q values are expected to be.

    `entry` is what a model file of here begins from; `sources` are the files that it came from.
    """

    effect: Effect
    variant: Variant
    entry: EffectEntry
    pool: Pool
    sources: tuple[str, ...]


def entries_of(name: str, models: Sequence[Model]) -> list[tuple[str, EffectEntry]]:
    """The entries of an effect in other models, with their files; raises `LabrigError` where none has it."""
    effect = library(*(model.folder for model in models)).get(name)
    if effect is not None and (why := effect.of_one_rig):
        raise LabrigError(f"{name} can't be carried over: {why}; fit it without --prior")
    found = [
        (_called(model), entry) for model in models for entry in model.file.effects if entry.name == name
    ]
    if not found:
        files = ", ".join(_called(model) for model in models)
        raise LabrigError(f"{files}: has no {name}; add it in a command of its own, without --prior")
    forms = {entry.form for _, entry in found}
    if len(forms) > 1:
        each = "; ".join(f"{file}: {entry.form}" for file, entry in found)
        raise LabrigError(
            f"{name} has another form in each prior, so that their values don't compare ({each})"
        )
    return found


def prior_of(context: Context, name: str, models: Sequence[Model], spread: float) -> Prior:
    """What models from elsewhere say of an effect on these runs, pooled; raises `LabrigError` where they can't.

    Values of a chamber (a marker's coordinate) that exists here are those of its name; of others the mean of all, as
    uncertain as these differ. What is not linear (time constants) is the geometric mean.
    """
    found = entries_of(name, models)
    effect = get(name, models[0].folder)
    first = found[0][1].model_copy(deep=True)
    if is_family(first.form):
        raise LabrigError(
            f"{found[0][0]}: {name} is there as the weights of a family, which mean nothing one by one; only a formula "
            "can be carried over: fit it without --prior"
        )
    for shape in _shapes(context, effect, first):
        values = [_number(entry, shape) for _, entry in found]
        if min(values) > 0:
            first.parameters[shape].value = float(f"{np.exp(np.mean(np.log(values))):.5g}")
    variant = find_variant(context, effect, first)
    each = [
        np.concatenate([_aligned(file, entry, term, context) for term in variant.terms], axis=1)
        for file, entry in found
    ]
    value, sd = np.stack(each, axis=1)
    return Prior(effect, variant, first, pooled(value, sd, spread), tuple(file for file, _ in found))


def size_of(term: Term, context: Context) -> int:
    """How many values a term has here."""
    if term.kind == "frame":
        return 6
    return term.feature.shape[-1] * (context.base.shape[1] if term.kind == "pattern" else 1)


def labels_of(term: Term, context: Context) -> list[str]:
    """What a term's values belong to, one each; empty where it has only one."""
    if term.kind == "pattern":
        return list(context.rows.observables)
    if term.kind == "frame":
        return ["x", "y", "z", "about x", "about y", "about z"]
    return list(term.labels or ())


def _aligned(file: str, entry: EffectEntry, term: Term, context: Context) -> Floats:
    """Values and standard deviations (2, q) of a term from an entry, in the order of here."""
    there = entry.parameters[term.parameter]
    if there.sd is None:
        raise LabrigError(
            f"{file}: {entry.name}: {term.parameter} has no sd, so it says nothing elsewhere; fit it anew"
        )
    # the shape is carried over as it is
    off = there.sd if there.sd_given_shape is None else there.sd_given_shape
    value, sd = np.atleast_1d(np.array(there.value, float)), np.atleast_1d(np.array(off, float))
    if value.ndim != 1 or value.shape != sd.shape:
        raise LabrigError(f"{file}: {entry.name}: {term.parameter} has too many values to be carried over")
    size, here = size_of(term, context), labels_of(term, context)
    if value.size == 1:
        return np.array([np.full(size, value[0]), np.full(size, sd[0])])
    if there.per is None or len(here) != size:
        raise LabrigError(
            f"{file}: {entry.name}: {term.parameter} has {value.size} values, and here it needs {size}"
        )
    by_label = {label: (v, s) for label, v, s in zip(there.per, value, sd, strict=True)}
    if term.kind == "pattern" and set(here) - set(by_label):
        raise LabrigError(f"{file}: {entry.name}: its pattern is of other observables than these runs have")
    usual = (float(value.mean()), float(np.hypot(value.std(ddof=1), sd.mean())))
    return np.array([by_label.get(label, usual) for label in here]).T


def _shapes(context: Context, effect: Effect, entry: EffectEntry) -> list[str]:
    variant = find_variant(context, effect, entry)
    return [name for name in variant.shape if not effect.parameter(name).given]


def _number(entry: EffectEntry, name: str) -> float:
    return float(np.asarray(entry.parameters[name].value, dtype=float).reshape(-1)[0])


def _called(model: Model) -> str:
    return "the prior" if model.path is None else model.path.name
