"""An effect's forms as spaces of functions: the family of an effect that does not say one of its own."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Feature, Space, acting, field, motion_scale, pattern, pressure
from labrig.effects._fields import frame_modes

if TYPE_CHECKING:
    from labrig.effects._effect import Effect, Term, Variant

_FRAME = ("x", "y", "z", "about x", "about y", "about z")


def spaces_of(effect: "Effect", context: Context) -> Iterator[Space]:
    """One space for each form of an effect, with all values of its grid side by side; `spectrum` is its name and form.

    What a scan found are places of which one holds: each is a space of its own.
    """
    forms: dict[str, list[Variant]] = {}
    for variant in effect.variants(context):
        forms.setdefault(variant.key if effect.scans else variant.form, []).append(variant)
    for key, variants in forms.items():
        features = [f for v in variants for term in v.terms for f in _features(context, v, term)]
        alike = 0.7 if any(_own(term) for v in variants for term in v.terms) else 1.0
        places = context.rows.n_captures if effect.scans else 0
        if features := acting(features):
            name = f"{effect.name} {variants[0].form}"
            yield Space(key, name, features, alike, places, absolute=False)


def plain_forms(effect: "Effect", context: Context) -> Iterator[Space]:
    """Each form through the pressures that has nothing to choose but a coefficient for all chambers or one for each, as
    a space of its own, beside those of the effect's family.

    These are the laws that are written down first: a wide space, which holds many others, makes them improbable. What
    chambers have in common is as likely as what each has for itself.
    """
    from labrig.effects._effect import Effect

    if type(effect).family is Effect.family:
        return  # its forms are its family
    for variant in effect.variants(context):
        if not variant.shape and all(_few(term) for term in variant.terms):
            features = acting([f for term in variant.terms for f in _features(context, variant, term)])
            if features:
                alike = 0.5 if any(_own(term) for term in variant.terms) else 1.0
                name = f"{effect.name} as {variant.form}"
                yield Space(variant.form, name, features, alike, absolute=False, plain=True)


def _few(term: "Term") -> bool:
    """Whether a term acts through the pressures with one coefficient for all chambers or one for each."""
    return term.kind == "pressure" and (term.feature.shape[2] == 1 or _own(term))


def _own(term: "Term") -> bool:
    """Whether a term has a coefficient for each chamber."""
    F = term.feature
    return term.kind == "pressure" and F.shape[1] > 1 and F.shape[1] == F.shape[2] and not _mixed(F)


def _mixed(feature: Floats) -> bool:
    return bool((feature * (1 - np.eye(feature.shape[1]))).any())


def _features(context: Context, variant: "Variant", term: "Term") -> Iterator[Feature]:
    """The columns of a term, each as large as the others: the units of its coefficients say nothing of their size."""
    name = " ".join([term.parameter, *(f"{k}={v:g}" for k, v in variant.shape.items())])
    if _own(term):
        yield pressure(name, _even(term.feature.sum(axis=2) / context.span))
        return
    if term.kind == "frame":
        columns = [term.feature[:, None] * mode for mode in np.moveaxis(frame_modes(context), 2, 0)]
        labels = _FRAME
    else:
        columns = list(np.moveaxis(term.feature, -1, 0))
        labels = term.labels or tuple(str(i) for i in range(len(columns)))
    for label, values in zip(labels, columns, strict=True):
        own = f"{name} {label}" if len(columns) > 1 else name
        if term.kind == "pressure":
            yield pressure(own, _even(values / context.span))
        elif term.kind == "pattern":
            yield pattern(own, _even(values))
        else:
            yield field(own, _even(values / motion_scale(context)) * motion_scale(context))


def _even(values: Floats) -> Floats:
    """The same values with a root mean square of one; zeros stay."""
    size = float(np.sqrt(np.mean(np.square(values))))
    return values / size if size > 0 else values
