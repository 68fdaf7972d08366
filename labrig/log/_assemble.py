"""Captures and actuations put together into the Dataset of a campaign."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from labrig.log._mapping import Mapping, Observable
from labrig.log._units import is_length

if TYPE_CHECKING:
    from xarray import Dataset

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Capture:
    """One hold: T rows of K observables under C chambers; `event` is the actuation that it is held at."""

    event: int
    session: str
    repeat: str
    time_s: Floats
    hold_s: Floats
    values: Floats
    measured: Floats
    covariates: Floats


def build_dataset(
    mapping: Mapping,
    observables: Sequence[Observable],
    captures: Sequence[Capture],
    events: Sequence[tuple[float, Floats, str]],
) -> "Dataset":
    """Lay captures and events (time s, actuation (C,), session) out as docs/reference/dataset.md says."""
    import xarray as xr

    n, T = len(captures), max(len(c.time_s) for c in captures)
    names = [a.name for a in mapping.actuation]

    def padded(parts: Sequence[Floats]) -> Floats:
        out = np.full((n, T, *parts[0].shape[1:]), np.nan)
        for i, part in enumerate(parts):
            out[i, : len(part)] = part
        return out

    values = padded([c.values for c in captures])
    hold = padded([c.hold_s for c in captures])
    event_of = np.array([c.event for c in captures])
    commanded = np.array([events[e][1] for e in event_of])
    data: dict[str, object] = {
        "commanded": (("capture", "chamber"), commanded, {"units": mapping.actuation[0].unit}),
        "measured": (("capture", "time", "chamber"), padded([c.measured for c in captures])),
        "hold_s": (("capture", "time"), hold),
        "time_s": (("capture", "time"), padded([c.time_s for c in captures])),
        "settled": (("capture", "time"), np.isfinite(hold)),
        "event_time_s": (("event",), np.array([e[0] for e in events])),
        "event_commanded": (("event", "chamber"), np.array([e[1] for e in events])),
    }
    limit = {"min": np.minimum(0.0, commanded.min(axis=0)), "max": commanded.max(axis=0)}
    coords: dict[str, object] = {
        "capture": np.arange(n),
        "chamber": names,
        "session": ("capture", [c.session for c in captures]),
        "repeat": ("capture", [c.repeat for c in captures]),
        "event_of": ("capture", event_of),
        "event_session": ("event", [e[2] for e in events]),
    }
    for side in ("min", "max"):
        given = [getattr(a, side) for a in mapping.actuation]
        coords[f"chamber_{side}"] = (
            "chamber",
            np.array([limit[side][c] if v is None else v for c, v in enumerate(given)], dtype=float),
        )
    _observables(mapping, observables, values, data, coords)
    if mapping.covariates:
        data["covariates"] = (("capture", "time", "covariate"), padded([c.covariates for c in captures]))
        coords["covariate"] = [e.name for e in mapping.covariates]
        coords["covariate_unit"] = ("covariate", [e.unit for e in mapping.covariates])
    attrs = {"source": "table", "between_sessions": mapping.between_sessions}
    return xr.Dataset(data, coords=coords, attrs=attrs)  # type: ignore[arg-type]


def _observables(
    mapping: Mapping,
    observables: Sequence[Observable],
    values: Floats,
    data: dict[str, object],
    coords: dict[str, object],
) -> None:
    """Markers with all three axes become `position_mm`; everything else stays an observable."""
    place = {
        (o.marker, o.axis): k for k, o in enumerate(observables) if o.marker and o.axis and is_length(o.unit)
    }
    owners = list(dict.fromkeys(o.marker for o in observables if o.marker))
    whole = [m for m in owners if all((m, a) in place for a in "xyz")]
    taken = {place[m, a] for m in whole for a in "xyz"}
    rest = mapping.marker_table()
    if whole:
        index = [[place[m, a] for a in "xyz"] for m in whole]
        data["position_mm"] = (("capture", "time", "marker", "axis"), values[:, :, index], {"units": "mm"})
        coords["marker"] = whole
        coords["axis"] = list("xyz")
        known = [rest[m].rest if m in rest else None for m in whole]
        if any(r is not None for r in known):
            data["rest_mm"] = (
                ("marker", "axis"),
                np.array([r if r is not None else (np.nan,) * 3 for r in known], dtype=float),
                {"units": "mm"},
            )
    others = [k for k in range(len(observables)) if k not in taken]
    if others:
        chosen = [observables[k] for k in others]
        data["observed"] = (("capture", "time", "observable"), values[:, :, others])
        coords["observable"] = [o.name for o in chosen]
        coords["unit"] = ("observable", ["mm" if o.marker and is_length(o.unit) else o.unit for o in chosen])
        coords["marker_of"] = ("observable", [o.marker or "" for o in chosen])
        coords["axis_of"] = ("observable", [o.axis or "" for o in chosen])
