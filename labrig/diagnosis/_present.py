"""What a report shows: the fields over the captures, and each effect's signature."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._candidates import Fit, change_of
from labrig.diagnosis._design_matrix import coefficients
from labrig.diagnosis._result import Signature
from labrig.effects import Context, Part, Variant, capture_means, contribution

if TYPE_CHECKING:
    from xarray import Dataset


def fields_of(context: Context, residual: Floats, chosen: Fit | None) -> "Dataset":
    """Measured, base and model, mean of each capture's hold, as a Dataset.

    By (capture, observable); what the chambers were commanded and reached by (capture, chamber). Of markers also the
    error of each, from the `residual` (F, K) without mistaken values as `where` has it, and how far each chamber alone
    moves them.
    """
    import xarray as xr

    rows, first = context.rows, context.rows.first
    captures = rows.capture[first]
    change = whole_change(context, chosen) if chosen else np.zeros_like(context.base)
    seen = np.where(np.isfinite(rows.values), 1.0, np.nan)
    by_row = {
        "measured": rows.values,
        "base": context.base * seen,
        "model": (context.base + change) * seen,
        "base_everywhere": context.base,
        "model_everywhere": context.base + change,
    }
    out = xr.Dataset(
        {
            name: (("capture", "observable"), capture_means(values, rows.capture)[0])
            for name, values in by_row.items()
        },
        coords={
            "capture": captures,
            "observable": list(rows.observables),
            "unit": ("observable", list(rows.unit)),
            "marker_of": ("observable", [rows.markers[m] if m >= 0 else "" for m in rows.marker]),
            "axis_of": ("observable", ["xyz"[a] if a >= 0 else "" for a in rows.axis]),
            "session": ("capture", [rows.sessions[s] for s in rows.session[first]]),
            "repeat": ("capture", [rows.repeat[c] for c in captures]),
        },
    )
    out.attrs["longest_hold_s"] = float(np.max(context.elapsed_s, initial=0.0))
    out["commanded"] = (("capture", "chamber"), rows.actuation[first])
    out = out.assign_coords(chamber=list(rows.chambers))
    out["commanded"].attrs["units"] = rows.actuation_unit
    if np.isfinite(rows.measured).any():
        out["reached"] = (("capture", "chamber"), capture_means(rows.measured, rows.capture)[0])
    return out if rows.rest_mm is None else _with_markers(out, context, residual, change)


def _with_markers(out: "Dataset", context: Context, residual: Floats, change: Floats) -> "Dataset":
    """A Dataset with the places at rest, the errors of each marker, and how far each chamber alone moves it."""
    rest_mm = context.rows.rest_mm
    assert rest_mm is not None
    out["rest_mm"] = (("marker", "axis"), rest_mm)
    out = out.assign_coords(marker=list(context.rows.markers[: len(rest_mm)]), axis=list("xyz"))
    out["error_before"] = ("marker", _of_markers(context, residual**2))
    out["error_after"] = ("marker", _of_markers(context, (residual - change) ** 2))
    reach = np.abs(context.jacobian).mean(axis=0) if context.reach is None else context.reach
    by_chamber = [_of_markers(context, column[None] ** 2) for column in reach.T]
    out["reach"] = (("marker", "chamber"), np.stack(by_chamber, axis=1))
    return out


def _of_markers(context: Context, square: Floats) -> Floats:
    """Root means of squares (n, K) over what was seen of each marker that has a place, (M,)."""
    out = np.full(len(context.rows.rest_mm), np.nan)  # type: ignore[arg-type]
    for m in range(len(out)):
        own = square[:, context.rows.marker == m]
        if np.isfinite(own).any():
            out[m] = np.sqrt(np.nanmean(own))
    return out


def whole_change(context: Context, chosen: Fit) -> Floats:
    """What the effects, and the base's own parameters fitted again beside them, change in the prediction, (F, K)."""
    change = change_of(context, chosen)
    if chosen.columns.regression.declared is not None:
        change = change + _refit(chosen, change)
    if chosen.columns.regression.calibrated is not None:
        change = change + _recalibrated(chosen, change)
    return change


def _refit(chosen: Fit, change: Floats) -> Floats:
    """What the base's own parameters, fitted again beside the effects, change in the prediction, (F, K)."""
    regression = chosen.columns.regression
    assert regression.declared is not None
    if not regression.use_means:
        return np.zeros_like(change)
    left = regression.residual - regression.lift(change)  # what was not seen gives way as what was
    refitted = (left - regression.partial(left))[: int(regression.index.max()) + 1]
    return refitted[regression.index]


def _recalibrated(chosen: Fit, change: Floats) -> Floats:
    """What the base's calibrated parameters, fitted again beside the effects, change in the prediction, (F, K)."""
    regression = chosen.columns.regression
    assert regression.calibrated is not None
    if not regression.use_means:
        return np.zeros_like(change)
    seen = replace(regression, declared=None).calibration(None)
    assert seen is not None
    off = seen.fitted(
        regression.residual - regression.lift(change), np.ones(len(regression.source), dtype=bool)
    )
    return (seen.fields[: int(regression.index.max()) + 1] @ off)[regression.index]


def signatures_of(
    context: Context, residual: Floats, noise: Floats, fits: Mapping[str, Fit]
) -> list[Signature]:
    """What gives each effect away, by name, in the fit that has it: with all other effects of that fit removed."""
    out = []
    for name, chosen in fits.items():
        i = chosen.names.index(name)
        part = chosen.parts[i]
        each = coefficients(part.columns, part.variant, chosen.own(i))
        shown = Part(
            part.variant.form,
            contribution(context, part.variant, each),
            residual - whole_change(context, chosen),
            noise,
            _pressures(part.variant, each),
            part.variant.shape,
        )
        sign = part.effect.sign(context, shown)
        points = {f.name: getattr(sign, f.name) for f in fields(sign)}
        out.append(Signature(name, part.effect.signature, **points, chambers=_by_chamber(context, shown)))
    return out


def _by_chamber(context: Context, part: Part) -> dict[str, tuple[float, float]]:
    """How an effect changes the pressure of each chamber: as a share of it, and root mean square."""
    if part.own is None:
        return {}
    u = context.rows.actuation
    share = (part.own * u).sum(axis=0) / np.maximum((u**2).sum(axis=0), 1e-12)
    size = np.sqrt((part.own**2).mean(axis=0))
    names = context.rows.chambers
    return {name: (float(share[c]), float(size[c])) for c, name in enumerate(names)}


def _pressures(variant: Variant, each: Sequence[Floats]) -> Floats | None:
    """The change of the pressures (F, C) that a form is, where all of its terms act on them."""
    if any(term.kind != "pressure" for term in variant.terms):
        return None
    return np.sum([term.feature @ beta for term, beta in zip(variant.terms, each, strict=True)], axis=0)
