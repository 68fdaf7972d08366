"""Effects in files of people's own: what they yield is checked, and their faults are said with their place."""

from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np

from labrig._errors import LabrigError
from labrig._own_code import FAULTS, failed
from labrig.effects._context import Context
from labrig.effects._effect import WEIGHTS, Effect, Kind, Term, Variant
from labrig.effects._family import Feature, FeatureKind, Space

_Answer = TypeVar("_Answer")
_AXES = {
    "pressure": "rows, chambers, columns",
    "pattern": "rows, columns",
    "frame": "rows",
    "field": "rows, observables, columns",
}


class EffectError(LabrigError):
    """An own effect failed, or yielded what no effect may; `effect` is its name.

    Made of its message alone, as an error is that comes from another process, it gets its name with its other state.
    """

    def __init__(self, message: str, effect: str = "") -> None:
        super().__init__(message)
        self.effect = effect


class Unreadable(Effect):
    """What stands for a file that can't be read as an effect: it fails when it is asked for its forms."""

    acts_on = "observation"
    parameters = ()
    reference = experiment = "none: its file can't be read"

    def variants(self, context: Context) -> Iterator[Variant]:
        """Raises `EffectError` that says what is wrong with the file."""
        raise EffectError(self.meaning, self.name)


def unreadable(file: Path, why: str) -> Effect:
    """The stand-in of a file, by the file's own name; `why` says where it is wrong."""
    told = {"name": file.name, "meaning": why, "signature": why}
    return type("Unreadable", (Unreadable,), told)()


def checked(kind: type[Effect], file: Path) -> type[Effect]:
    """The same effect, whose methods check what they give and raise `EffectError` naming the file, line and method."""
    own: dict[str, Any] = {"variants": _each(kind, file, "variants", _variant), "__module__": kind.__module__}
    if kind.family is not Effect.family:
        own["family"] = _each(kind, file, "family", _space)
    for method in ("covariate", "sign", "follows", "turned_round", "carried", "lacks", "in_words"):
        if getattr(kind, method) is not getattr(Effect, method):
            own[method] = _called(kind, file, method)
    return type(kind.__name__, (kind,), own)


def without_failing(
    attempt: Callable[[Collection[str]], _Answer], needed: Collection[str]
) -> tuple[_Answer, list[str]]:
    """What an attempt gives without the own effects that fail in it, and a line on each of these.

    The attempt is given the names of those to leave out. One that is `needed`, as the model has it, is not left out:
    its `EffectError` is raised.
    """
    left_out: dict[str, str] = {}
    while True:
        try:
            return attempt(left_out.keys()), [f"{line}; it is left out" for line in left_out.values()]
        except EffectError as error:
            if error.effect in left_out or error.effect in needed:
                raise
            left_out[error.effect] = str(error)


def _each(kind: type[Effect], file: Path, method: str, check: Callable[..., str]) -> Callable[..., Any]:
    def each(self: Effect, context: Context) -> Iterator[Any]:
        try:
            for given in getattr(kind, method)(self, context) or ():
                if wrong := check(self, context, given):
                    said = f"{file.name}: {kind.__name__}.{method}: {wrong}"
                    raise EffectError(f"effect {kind.name!r}: {said}", kind.name)
                yield given
        except LabrigError:
            raise
        except FAULTS as error:
            raise _fault(error, kind, file, method) from error

    return each


def _called(kind: type[Effect], file: Path, method: str) -> Callable[..., Any]:
    def called(self: Effect, *arguments: Any) -> Any:
        try:
            return getattr(kind, method)(self, *arguments)
        except LabrigError:
            raise
        except FAULTS as error:
            raise _fault(error, kind, file, method) from error

    return called


def _fault(error: BaseException, kind: type[Effect], file: Path, method: str) -> EffectError:
    said = failed(error, file, f"{kind.__name__}.{method}")
    return EffectError(f"effect {kind.name!r}: {said}", kind.name)


def _variant(effect: Effect, context: Context, given: Any) -> str:
    """What is wrong with a form; empty where nothing is."""
    if not isinstance(given, Variant):
        return f"yields a {type(given).__name__}, where a Variant is needed"
    known = [parameter.name for parameter in effect.parameters]
    for term in given.terms:
        if not isinstance(term, Term):
            return f"form {given.form!r}: a term is a {type(term).__name__}, where a Term is needed"
        if wrong := _term(context, term, [*known, WEIGHTS.name]):
            return f"form {given.form!r}: the term of {term.parameter!r} {wrong}"
    if strange := [name for name in given.shape if name not in known]:
        return f"form {given.form!r}: {strange[0]!r} is none of its parameters ({', '.join(known)})"
    return ""


def _term(context: Context, term: Term, known: Collection[str]) -> str:
    if term.parameter not in known:
        return f"has a coefficient that is none of its parameters ({', '.join(list(known)[:-1])})"
    if term.kind not in get_args(Kind):
        return f"is of kind {term.kind!r}; there are {', '.join(get_args(Kind))}"
    F, K = context.base.shape
    feature, C = np.asarray(term.feature), len(context.rows.chambers)
    shape = {"pressure": (F, C), "pattern": (F,), "frame": (F,), "field": (F, K)}[term.kind]
    columns = 0 if term.kind == "frame" else 1
    if feature.shape[: len(shape)] != shape or feature.ndim != len(shape) + columns:
        sizes = f"{', '.join(map(str, shape))}{', q' if columns else ','}"
        return f"has shape {feature.shape}, where ({sizes}) is needed: {_AXES[term.kind]}"
    return _finite(feature)


def _space(_effect: Effect, context: Context, given: Any) -> str:
    """What is wrong with a space; empty where nothing is."""
    if not isinstance(given, Space):
        return f"yields a {type(given).__name__}, where a Space is needed"
    F, K = context.base.shape
    shapes = {"pressure": (F, len(context.rows.chambers)), "field": (F, K), "pattern": (F,)}
    for feature in given.features:
        where = f"space {given.key!r}: "
        if not isinstance(feature, Feature):
            return f"{where}a feature is a {type(feature).__name__}, where a Feature is needed"
        if feature.kind not in shapes:
            return (
                f"{where}{feature.name!r} is of kind {feature.kind!r}; "
                f"there are {', '.join(get_args(FeatureKind))}"
            )
        values = np.asarray(feature.values)
        if values.shape != shapes[feature.kind]:
            return f"{where}{feature.name!r} has shape {values.shape}, where {shapes[feature.kind]} is needed"
        if wrong := _finite(values):
            return f"{where}{feature.name!r} {wrong}"
    return ""


def _finite(values: Any) -> str:
    try:
        bad = ~np.isfinite(values).reshape(len(values), -1).all(axis=1)
    except TypeError:
        return "is no array of numbers"
    if not bad.any():
        return ""
    return f"is not finite in {int(bad.sum())} of {len(bad)} rows; yield no form where it cannot be computed"
