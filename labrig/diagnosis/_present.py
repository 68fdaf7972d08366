"""What a report shows: the fields over the captures, and each effect's signature."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from labrig.diagnosis._candidates import Candidate, Fit, change_of
from labrig.diagnosis._floor import capture_means
from labrig.diagnosis._result import Signature
from labrig.diagnosis._streams import Streams
from labrig.effects import Context
from labrig.effects._rows import Floats

if TYPE_CHECKING:
    from xarray import Dataset


def fields_of(context: Context, chosen: Fit | None) -> "Dataset":
    """Measured, base and model, mean of each capture's hold, as a Dataset (capture, observable)."""
    import xarray as xr

    rows = context.rows
    change = change_of(context, chosen) if chosen else np.zeros_like(context.base)
    if chosen and chosen.columns.streams.declared is not None:
        change = change + _refit(context, chosen, change)
    if chosen and chosen.columns.streams.calibrated is not None:
        change = change + _recalibrated(context, chosen, change)
    seen = np.where(np.isfinite(rows.values), 1.0, np.nan)
    measured, captures = capture_means(rows.values, rows.capture)
    base, _ = capture_means(context.base * seen, rows.capture)
    model, _ = capture_means((context.base + change) * seen, rows.capture)
    first = np.searchsorted(rows.capture, captures)
    data = {
        name: (("capture", "observable"), v)
        for name, v in (("measured", measured), ("base", base), ("model", model))
    }
    everywhere, _ = capture_means(context.base, rows.capture)
    improved, _ = capture_means(context.base + change, rows.capture)
    data["base_everywhere"] = (("capture", "observable"), everywhere)
    data["model_everywhere"] = (("capture", "observable"), improved)
    out = xr.Dataset(
        data,
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
    out["commanded"] = (("capture", "chamber"), rows.actuation[first])
    out = out.assign_coords(chamber=list(rows.chambers))
    out["commanded"].attrs["units"] = rows.actuation_unit
    if rows.rest_mm is not None:
        out["rest_mm"] = (("marker", "axis"), rows.rest_mm)
        out = out.assign_coords(marker=list(rows.markers[: len(rows.rest_mm)]), axis=list("xyz"))
    return out


def _refit(context: Context, chosen: Fit, change: Floats) -> Floats:
    """What the base's own parameters, fitted again beside the effects, change in the prediction, (F, K)."""
    streams = chosen.columns.streams
    assert streams.declared is not None
    left, _ = capture_means(context.residual - change, context.rows.capture)
    columns = streams.declared[: len(left)] if streams.use_means else np.zeros((len(left), 1))
    beta = np.linalg.lstsq(columns, np.nan_to_num(left), rcond=1e-9)[0]
    return (columns @ beta)[streams.index]


def _recalibrated(context: Context, chosen: Fit, change: Floats) -> Floats:
    """What the base's calibrated parameters, fitted again beside the effects, change in the prediction, (F, K)."""
    streams = chosen.columns.streams
    assert streams.calibrated is not None
    if not streams.use_means:
        return np.zeros_like(change)
    seen = replace(streams, declared=None).calibration(None)
    assert seen is not None
    off = seen.fitted(streams.residual - streams.lift(change), np.ones(len(streams.source), dtype=bool))
    return (seen.fields[: int(streams.index.max()) + 1] @ off)[streams.index]


def signatures_of(
    streams: Streams, context: Context, found: Mapping[str, Sequence[Candidate]], names: Sequence[str]
) -> list[Signature]:
    """The residual along its leading direction against the covariate that betrays each effect."""
    rows = context.rows
    weight = 1 / streams.floor.row
    residual = np.where(np.isfinite(context.residual), context.residual, 0.0)
    _, _, Vt = np.linalg.svd(residual * weight, full_matrices=False)
    leading = Vt[0] * weight
    scale = np.sum(np.abs(leading)) or 1.0
    along = residual @ (leading / scale)
    if np.corrcoef(along, rows.fraction.mean(axis=1) + 1e-9 * np.arange(len(along)))[0, 1] < 0:
        along = -along
    turn = np.sign(context.direction[rows.event].sum(axis=1))
    group = [{1.0: "up", -1.0: "down"}.get(float(s), "first") for s in turn]
    shown = list(dict.fromkeys([*names, *sorted(found, key=lambda n: -found[n][0].score.gain)[:3]]))
    out = []
    for name in shown:
        if name in found:
            covariate, unit, x = found[name][0].effect.covariate(context)
            out.append(Signature(name, covariate, unit, x, along, group))
    return out
