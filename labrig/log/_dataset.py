"""Puts arrays together into the Dataset that docs/reference/dataset.md describes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.log._layout import Layout

if TYPE_CHECKING:
    import xarray as xr


REST_OF = tuple(f"rest_{axis}_mm" for axis in "xyz")
"""Coordinates that say where the marker of an observable is at rest."""


@dataclass
class CampaignArrays:
    """The variables of a campaign; None where it has none. Names of the fields are those of the Dataset.

    Shapes: F captures, T rows of the longest hold, C chambers, M markers, K observables, E events,
    V covariates.
    """

    commanded: Floats
    hold_s: Floats
    time_s: Floats
    settled: NDArray[np.bool_]
    event_time_s: Floats
    event_commanded: Floats
    session: Sequence[str]
    repeat: Sequence[str]
    event_session: Sequence[str]
    event_of: NDArray[np.int64]
    measured: Floats | None = None
    position_mm: Floats | None = None
    observed: Floats | None = None
    covariates: Floats | None = None
    wall_s: Sequence[float] | None = None
    segment: Sequence[str] | None = None
    ruled_out: Sequence[str] | None = None


_DIMS = {
    "commanded": ("capture", "chamber"),
    "measured": ("capture", "time", "chamber"),
    "position_mm": ("capture", "time", "marker", "axis"),
    "observed": ("capture", "time", "observable"),
    "hold_s": ("capture", "time"),
    "time_s": ("capture", "time"),
    "settled": ("capture", "time"),
    "event_time_s": ("event",),
    "event_commanded": ("event", "chamber"),
    "covariates": ("capture", "time", "covariate"),
}
_MEANING = {
    "commanded": "set-points of each capture",
    "measured": "what the pressure sensors read",
    "position_mm": "marker positions in the hold; NaN: not seen",
    "observed": "every other observable",
    "hold_s": "time since the actuation of this capture",
    "time_s": "time from the start of the first session of the run",
    "settled": "recorded after settling",
    "event_time_s": "when each actuation happened",
    "event_commanded": "what was commanded at each actuation",
    "covariates": "anything else that was logged",
}


def to_dataset(arrays: CampaignArrays, layout: Layout, attributes: dict[str, Any]) -> xr.Dataset:
    """The Dataset of a campaign; `attributes` come on top of what the layout says."""
    import xarray as xr

    units = dict.fromkeys(("commanded", "measured", "event_commanded"), layout.unit)
    units |= {"position_mm": "mm", "hold_s": "s", "time_s": "s", "event_time_s": "s"}
    variables = {}
    for name, dims in _DIMS.items():
        if (values := getattr(arrays, name)) is not None:
            attrs = {"long_name": _MEANING[name]}
            if name in units:
                attrs["units"] = units[name]
            variables[name] = (dims, values, attrs)
    if layout.rest_mm is not None and layout.markers:
        rest = np.array(layout.rest_mm, float).reshape(-1, 3)
        variables["rest_mm"] = (("marker", "axis"), rest, {"long_name": "markers at rest", "units": "mm"})
    dataset = xr.Dataset(variables, coords=_coordinates(arrays, layout))
    dataset.attrs = {
        **layout.attributes,
        "source": layout.source,
        "between_sessions": layout.between_sessions,
    }
    if layout.source == "rig":
        dataset.attrs["start_s"] = layout.start_s
    dataset.attrs |= {"units": layout.unit, **attributes}
    return dataset


def rest_coordinates(rest_mm: Sequence[Sequence[float]]) -> dict[str, Any]:
    """Coordinates that say where the marker of each observable is at rest, (K, 3), mm; NaN where nobody knows."""
    said = {"long_name": "where its marker is at rest", "units": "mm"}
    columns = np.array(rest_mm, float).reshape(-1, 3).T
    return {name: ("observable", column, said) for name, column in zip(REST_OF, columns, strict=True)}


def _coordinates(arrays: CampaignArrays, layout: Layout) -> dict[str, Any]:
    coords: dict[str, Any] = {
        "capture": np.arange(len(arrays.commanded)),
        "chamber": _strings(layout.chambers),
        "session": ("capture", _strings(arrays.session)),
        "repeat": ("capture", _strings(arrays.repeat)),
        "event_of": ("capture", np.asarray(arrays.event_of, np.int64)),
        "event_session": ("event", _strings(arrays.event_session)),
        "chamber_min": ("chamber", np.array(layout.chamber_min, float)),
        "chamber_max": ("chamber", np.array(layout.chamber_max, float)),
    }
    if arrays.position_mm is not None or (layout.rest_mm is not None and layout.markers):
        coords["marker"] = _strings(layout.markers)
        coords["axis"] = _strings(("x", "y", "z"))
    if arrays.observed is not None:
        names = ("observable", "unit", "marker_of", "axis_of")
        for index, name in enumerate(names):
            column = _strings([observable[index] for observable in layout.observables])
            coords[name] = column if index == 0 else ("observable", column)
        if layout.observable_rest_mm is not None:
            coords |= rest_coordinates(layout.observable_rest_mm)
    if arrays.covariates is not None:
        coords["covariate"] = _strings([name for name, _ in layout.covariates])
        coords["covariate_unit"] = ("covariate", _strings([unit for _, unit in layout.covariates]))
    if arrays.segment is not None:
        coords["segment"] = ("capture", _strings(arrays.segment))
    if arrays.ruled_out is not None:
        coords["ruled_out"] = ("capture", _strings(arrays.ruled_out))
    if arrays.wall_s is not None and all(arrays.wall_s):
        wall = (np.array(list(arrays.wall_s), float) * 1e9).astype("datetime64[ns]")
        said = {"long_name": "what the clock on the wall said (UTC)"}
        kept = {
            "units": "seconds since 1970-01-01",
            "dtype": "float64",
        }  # NetCDF 3 has no whole numbers of 64 bits
        coords["wall_time"] = ("capture", wall, said, kept)
    return coords


def _strings(values: Sequence[str]) -> NDArray[np.str_]:
    return np.array(list(values), dtype=np.str_) if len(values) else np.array([], dtype="<U1")
