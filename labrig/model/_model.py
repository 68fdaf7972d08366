"""A model at work: its base and its effects, predicting a campaign."""

import os
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from labrig._errors import LabrigError
from labrig._paths import path_of, wrong
from labrig.arrays import Floats
from labrig.effects import (
    WEIGHTS,
    Context,
    Effect,
    Rows,
    Term,
    Variant,
    contribution,
    get,
    is_family,
    library,
    only_where,
    take_along,
    weighted,
    without_value,
)
from labrig.model._at_rest import at_rest, begun
from labrig.model._bases import (
    BaseModel,
    PythonModel,
    SimulatorModel,
    StaticModel,
    build_base,
    is_learned,
    jacobian,
    solo_deflection,
)
from labrig.model._beyond import beyond, beyond_base
from labrig.model._file import EffectEntry, ModelFile, PythonBase, Value, read_model_file, write_model_file
from labrig.model._memory import MemoryModel
from labrig.model._units import check_ranges, check_units

_OLDER = "an entry of an older labrig has to be fitted again: remove it, then labrig improve"


@dataclass(frozen=True)
class Model:
    """A base and an ordered list of effects; `folder` is what its relative paths start from, `path` its own file.

    Example:
        >>> model = labrig.Model.load("model.yaml")
        >>> model.file.base.kind
        'simulator'
        >>> model.save("copy.yaml")
    """

    file: ModelFile
    folder: Path = Path()
    path: Path | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.file, ModelFile):
            raise wrong("a ModelFile", self.file, 'labrig.Model.load("model.yaml") reads a model')

    def __repr__(self) -> str:
        """Its base, its effects and its file, in one line; the numbers are in `file.effects`."""
        effects = " + ".join(["", *(entry.name for entry in self.file.effects)]) or ", no effects"
        return f"Model: {self.file.base.kind}{effects}" + (f" ({self.path})" if self.path else "")

    @classmethod
    def load(cls, path: Path | str) -> "Model":
        """Read a model.yaml; raises `LabrigError` when it is not one, or names an unknown effect."""
        path = path_of(path, "a model", "a model.yaml's path")
        model = cls(read_model_file(path), path.parent, path)
        known = library(model.folder)
        for entry in model.file.effects:
            if entry.name not in known:
                get(entry.name, model.folder)
        return model

    @classmethod
    def of(
        cls,
        function: Callable[..., Any],
        *,
        learned: bool = False,
        heldout_error: float | None = None,
        memory: Literal["none", "record", "step"] | None = None,
        state: Sequence[float] | None = None,
        max_step_s: float | None = None,
    ) -> "Model":
        """A model of a function as it is, such as one of a notebook; what it takes and gives: docs/reference/model.md.

        Args:
            function: ``predict(actuation: (F, C)) -> (F, K)``, or one with memory.
            learned: it was fitted or trained, so its error may be any curve.
            heldout_error: but by no more than this, root mean square on set-points that it was not learned from, in
                the commonest unit of the observables.
            memory: what it remembers; left out, the number of its parameters says it.
            state: what a step begins with.
            max_step_s: the longest step of one with memory.

        Raises:
            LabrigError: it is no function, or an argument is none of those that are wanted.
        """
        if not callable(function):
            raise wrong("a function", function, "predict(actuation) -> observables")
        more = {"memory": memory, "state": state, "max_step_s": max_step_s}
        more |= {"learned": learned or None, "heldout_error": heldout_error}
        return cls(ModelFile(base=PythonBase.of(function, **more)), Path())

    def save(self, path: Path | str) -> None:
        """Write a model.yaml; files that it names stay where they are, their paths are made relative to it. Effects of
        your own are found beside a model alone: in another folder they are copied to its `effects`.

        Raises `LabrigError` where its base is a function that exists only in this session.
        """
        path, file = Path(path), self.in_files().file.model_copy(deep=True)
        for name in ("file", "rig"):
            if hasattr(file.base, name):
                target = (self.folder / getattr(file.base, name)).resolve()
                try:
                    relative = os.path.relpath(target, path.parent.resolve())
                except ValueError:  # another drive on Windows
                    relative = str(target)
                setattr(file.base, name, Path(relative).as_posix())
        write_model_file(file, path)
        take_along([entry.name for entry in file.effects], self.folder, path.parent)

    def in_files(self) -> "Model":
        """The same model; raises `LabrigError` where its base is a function that exists only in this session."""
        base = self.file.base
        if isinstance(base, PythonBase) and base.given is not None:
            name = base.function if base.function.isidentifier() else "predict"
            raise LabrigError(
                f"the model's base is the Python function {base.function}, which exists only in this session: a model "
                f"file has to name the file that such a function is in. Write it to {name}.py (in a notebook: "
                f"%%writefile {name}.py), and name that in model.yaml (base: {{kind: python, file: {name}.py, "
                f"function: {name}}})"
            )
        return self

    def with_effect(self, entry: EffectEntry) -> "Model":
        """The same model with one more effect at the end."""
        file = self.file.model_copy(update={"effects": [*self.file.effects, entry]})
        return replace(self, file=file, path=None)

    def library(self) -> dict[str, Effect]:
        """The effects that this model may name: labrig's and those in `effects/` beside its file."""
        return library(self.folder)

    def context(self, rows: Rows) -> Context:
        """Predict the rows by base and effects, with the derivative by the actuation."""
        return self.predictor(rows).context(rows)

    def predictor(self, fitted: Rows) -> "Predictor":
        """The model made ready for rows like `fitted`; a base that is fitted to a run is fitted to them."""
        base = build_base(self.file, self.folder, fitted)
        if isinstance(base, PythonModel):
            base.check_memory(np.unique(fitted.actuation, axis=0))
        if isinstance(base, StaticModel):
            # the effects act through the slopes that they were fitted with: those of the map without them
            alone = _resting(base, fitted)
            if self.file.effects:
                context = begun(base_context(alone, fitted), base.declared_rows(fitted))
                base.fit(fitted, fitted.values - _sum(self._changes(context)[1]))
            return Predictor(self, base, alone)
        if isinstance(base, SimulatorModel):
            base.fit(fitted, fitted.values)
            if self.file.effects:
                base.fit(fitted, fitted.values - _sum(self._changes(base_context(base, fitted))[1]))
        return Predictor(self, base)

    def unsaid(self, context: Context) -> list[str]:
        """Of which sessions the effects have no value of their own, and which pressures they were not fitted to, in
        words.
        """
        out = []
        for entry in self.file.effects:
            effect = get(entry.name, self.folder)
            out += beyond(entry, context.rows)
            own = {n: v.per for n, v in entry.parameters.items() if v.per and n != WEIGHTS.name}
            for name, known in own.items():
                if effect.parameter(name).per != "session":
                    continue
                if new := without_value(context, tuple(known)):
                    out.append(
                        f"{entry.name}: {name} is another in each session, and has no value for "
                        f"{', '.join(new)}: nothing is taken off there"
                    )
        return out

    def _changes(self, context: Context) -> tuple[Context, dict[str, Floats]]:
        """The context as the effects turn it, and what each of them changes in the prediction, (F, K)."""
        changes: dict[str, Floats] = {}
        for entry in self.file.effects:
            effect = get(entry.name, self.folder)
            changes[entry.name] = changes.get(entry.name, 0.0) + evaluate(context, effect, entry)
            values = {n: p.value for n, p in entry.parameters.items() if isinstance(p.value, float | int)}
            context = effect.carried(context, entry.form or "", values)
        return context, changes

    def declared(self, rows: Rows) -> Floats | None:
        """Regressors (F, D) of what the base calls its own, or None."""
        return _declared(build_base(self.file, self.folder, rows), rows)


@dataclass(frozen=True)
class Predictor:
    """A model whose base is ready: it predicts any rows with the same chambers and observables.

    The effects act through `alone` where that is another one than `base`: a map as it was fitted without them.
    """

    model: Model
    base: BaseModel
    alone: BaseModel | None = None

    def context(self, rows: Rows) -> Context:
        """Predict the rows by base and effects, with the derivative by the actuation."""
        return self.parts(rows)[0]

    def parts(self, rows: Rows) -> tuple[Context, dict[str, Floats]]:
        """The same, and what each effect changes in the prediction, (F, K), by its name."""
        own = base_context(self.alone or self.base, rows)
        X = _declared(self.base, rows)
        context, changes = self.model._changes(begun(own, np.ones((len(own.base), 1)) if X is None else X))
        rows = context.rows
        predicted = self.base.predict_rows(rows) if isinstance(self.base, StaticModel) else context.base
        rows = replace(
            rows, warnings=(*rows.warnings, *beyond_base(self.base, rows), *self.model.unsaid(context))
        )
        total, moved = predicted + _sum(changes), context.displacement
        learned, error = is_learned(self.model.file), getattr(self.model.file.base, "heldout_error", None)
        own = {"learned": learned, "heldout_error": error}
        return replace(context, rows=rows, base=total, displaced=moved, _memo={}, **own), changes

    def declared(self, rows: Rows) -> Floats | None:
        """Regressors (F, D) of what the base calls its own, or None."""
        return _declared(self.base, rows)

    def calibrated(self, rows: Rows) -> Floats | None:
        """Fields (F, K, D) by which the base's calibrated parameters change the prediction, or None."""
        return self.base.calibrated(rows.actuation) if isinstance(self.base, SimulatorModel) else None


def base_context(base: BaseModel, rows: Rows) -> Context:
    """What a base predicts of the rows, without any effect."""
    vented = np.clip(0.0, rows.low, rows.high)[None]
    if isinstance(base, MemoryModel):
        predicted, slope = base.predict_rows(rows), base.slope(rows)
        inside: dict[str, Floats] = {}
    else:
        unique, inverse = np.unique(rows.actuation, axis=0, return_inverse=True)
        by_map = isinstance(base, StaticModel)
        predicted = base.predict_rows(rows) if by_map else base.predict(unique)[inverse.reshape(-1)]
        slope = jacobian(base, rows.actuation, rows.low, rows.high)
        by_unique = base.inside(unique) if isinstance(base, SimulatorModel) else {}
        inside = {name: by[inverse.reshape(-1)] for name, by in by_unique.items()}
    alone = solo_deflection(base, rows.low, rows.high)
    return Context(
        rows=rows,
        base=predicted,
        base_vented=base.predict(vented)[0],
        jacobian=slope,
        deflection=alone.at(rows.actuation),
        event_deflection=alone.at(rows.event_actuation),
        deflection_slope=alone.slope(rows.actuation),
        base_kind=base.kind,
        inside=inside,
        reach=alone.reach,
        alone=partial(solo_deflection, base),
        elsewhere=None if isinstance(base, MemoryModel | StaticModel) else base.predict,
    )


def evaluate(context: Context, effect: Effect, entry: EffectEntry) -> Floats:
    """The change (F, K) that an effect with given values makes; raises `LabrigError` where it can't act."""
    _check_chambers(context, entry)
    context = as_fitted(context, entry)
    variant = find_variant(context, effect, entry)
    coefficients = []
    for term in variant.terms:
        value = _of_this_run(effect, term, entry.parameters[term.parameter])
        width = context.base.shape[1] if term.kind == "pattern" else 1
        shape = (6,) if term.kind == "frame" else (term.feature.shape[-1], width)
        size = int(np.prod(shape))
        if value.size not in (1, size):
            raise LabrigError(
                f"effect {effect.name!r}: {term.parameter!r} has {value.size} values, this run needs {size}"
            )
        value = np.broadcast_to(value.reshape(-1), (size,)).reshape(shape)
        coefficients.append(value if term.kind == "pattern" else value.reshape(-1))
    return contribution(context, variant, coefficients)


def _check_chambers(context: Context, entry: EffectEntry) -> None:
    """Raise `LabrigError` where chambers that an effect was fitted with are none of this run's, by their names."""
    fitted = entry.fitted_on.chambers if entry.fitted_on else []
    if any(name not in context.rows.chambers for name in fitted):
        raise LabrigError(
            f"effect {entry.name!r} was fitted with the chambers {', '.join(fitted)}, and this run has "
            f"{', '.join(context.rows.chambers)}: give them the same names, or fit it again"
        )


def _of_this_run(effect: Effect, term: Term, saved: Value) -> Floats:
    """The values of a term; of what is another in each session nothing where the session has none."""
    value = np.asarray(saved.value, dtype=float)
    if effect.parameter(term.parameter).per != "session" or not saved.per:
        return value
    at = {label: i for i, label in enumerate(saved.per)}
    value = value.reshape(len(saved.per), -1)
    return np.stack([value[at[n]] if n in at else np.zeros(value.shape[1]) for n in term.labels])


def as_fitted(context: Context, entry: EffectEntry) -> Context:
    """The context in which an entry's values mean what they did on the run that they were fitted to."""
    context = replace(context, saved=True)
    on = entry.fitted_on
    if on is None:
        return context
    check_ranges(entry, context.rows.actuation_unit)
    if on.centre_mm is not None:
        context = replace(context, centre=np.array(on.centre_mm, dtype=float))
    if on.start_s is not None:
        context = replace(context, began_s=on.start_s)
    measures = {name: np.array(value, dtype=float) for name, value in (on.yardsticks or {}).items()}
    context = replace(context, yardsticks=measures)
    low, high = context.rows.low.copy(), context.rows.high.copy()
    for chamber, below, above in zip(on.chambers, on.low, on.high, strict=True):
        if chamber in context.rows.chambers:
            c = context.rows.chambers.index(chamber)
            low[c], high[c] = below, above
    return context.within(low, high)


def find_variant(context: Context, effect: Effect, entry: EffectEntry) -> Variant:
    """The form of an effect that a model's entry names: by `form`, else the first that its parameters fit; it changes
    nothing where the effect was ruled out.
    """
    return next(only_where(context.rows, effect.name, [_named(as_fitted(context, entry), effect, entry)]))


def _named(context: Context, effect: Effect, entry: EffectEntry) -> Variant:
    linear = set(entry.parameters)
    if is_family(entry.form) and WEIGHTS.name in entry.parameters:
        labels = entry.parameters[WEIGHTS.name].per or ()
        if lacking := effect.lacks(context, entry.form or "", labels):
            raise LabrigError(_lacking(effect, lacking))
        return weighted(effect, context, entry.form or "", labels)
    if strange := sorted(linear - {p.name for p in effect.parameters}):
        raise LabrigError(f"effect {effect.name!r}: has no parameter {strange[0]!r}; {_OLDER}")
    check_units(effect, entry, context)
    unvalued: list[str] = []
    pinned = {
        name: float(np.asarray(p.value, dtype=float).reshape(-1)[0])
        for name, p in entry.parameters.items()
        if np.asarray(p.value).size == 1
    }
    for variant in effect.variants(context.pin(pinned)):
        names = {t.parameter for t in variant.terms} | set(variant.shape)
        if entry.form == variant.form or (entry.form is None and names == linear):
            if names <= linear:
                return variant
            unvalued = unvalued or sorted(names - linear)
    if unvalued:
        raise LabrigError(f"effect {effect.name!r}: the model gives no value for {unvalued[0]!r}; {_OLDER}")
    if lacking := effect.lacks(context, entry.form or "", entry.parameters):
        raise LabrigError(_lacking(effect, lacking))
    form = f"form {entry.form!r}" if entry.form else f"parameters {', '.join(sorted(linear)) or 'none'}"
    raise LabrigError(
        f"effect {effect.name!r} can't act on this run in {form}; see: labrig effects show {effect.name}"
    )


def _lacking(effect: Effect, what: str) -> str:
    return f"effect {effect.name!r} needs {what}, which this run did not log (or not everywhere)"


def _resting(base: StaticModel, rows: Rows) -> StaticModel:
    """The map as it is at rest; where set-points are held, as it was fitted."""
    context = base_context(base, rows)
    if not context.sample_s:
        return copy(base)
    return base.with_coefficients(at_rest(context, base.declared(rows.actuation)))


def _declared(base: BaseModel, rows: Rows) -> Floats | None:
    return base.declared_rows(rows) if isinstance(base, StaticModel) else base.declared(rows.actuation)


def _sum(changes: dict[str, Floats]) -> Floats | float:
    return np.sum(list(changes.values()), axis=0) if changes else 0.0
