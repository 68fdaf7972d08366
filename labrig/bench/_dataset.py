"""A drawn campaign as the Dataset of docs/reference/dataset.md."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench._programmes import Plan

if TYPE_CHECKING:
    import xarray as xr


def _padded(rows: Floats, counts: NDArray[np.int64]) -> Floats:
    """Rows (R, ...) of captures with `counts` (F,) rows each as (F, T, ...), NaN where a hold is shorter."""
    out = np.full((len(counts), int(counts.max()), *rows.shape[1:]), np.nan)
    inside = np.arange(out.shape[1]) < counts[:, None]
    out[inside] = rows
    return out


def to_dataset(rig: Rig, plan: Plan, measured: Floats, random: np.random.Generator) -> "xr.Dataset":
    """The Dataset of a plan and what was measured (R, K); half of the campaigns have pressure sensors.

    Sensors sit at the regulators, so they read what was commanded. Between sessions whose pressures are
    `vented` or `unknown` no event is logged.
    """
    import xarray as xr

    counts = np.array([len(r) for r in plan.capture_rows_s])
    since = np.concatenate(plan.capture_rows_s)
    commanded = np.array(plan.capture_kpa)
    session = np.array([f"s{k + 1}" for k in plan.capture_session])
    logged = np.array(plan.command_logged)
    event_time = np.array([t for t, _ in plan.commands])[logged]
    event_session = np.array([f"s{k + 1}" for k in plan.command_session])[logged]
    coords = {
        "capture": np.arange(plan.captures),
        "chamber": list(rig.chambers),
        "chamber_min": ("chamber", np.array(rig.low_kpa, dtype=float)),
        "chamber_max": ("chamber", np.array(rig.high_kpa, dtype=float)),
        "session": ("capture", session),
        "repeat": ("capture", np.array(plan.capture_repeat, dtype=str)),
        "event_of": ("capture", np.searchsorted(event_time, np.array(plan.capture_s) + 1e-9) - 1),
        "event_session": ("event", event_session),
    }
    hold = _padded(since, counts)
    data = {
        "commanded": (("capture", "chamber"), commanded),
        "hold_s": (("capture", "time"), hold),
        "time_s": (("capture", "time"), hold + np.array(plan.capture_s)[:, None]),
        "settled": (("capture", "time"), np.isfinite(hold)),
        "event_time_s": ("event", event_time),
        "event_commanded": (("event", "chamber"), np.array([p for _, p in plan.commands])[logged]),
    }
    if random.random() < 0.5:
        read = commanded[:, None, :] + 0.05 * random.normal(size=(*hold.shape, commanded.shape[1]))
        data["measured"] = (
            ("capture", "time", "chamber"),
            np.where(np.isfinite(hold)[..., None], read, np.nan),
        )
    rows = _padded(measured, counts)
    if in_space(rig):
        coords |= {"marker": list(rig.marker_names), "axis": ["x", "y", "z"]}
        data["position_mm"] = (
            ("capture", "time", "marker", "axis"),
            rows.reshape(*hold.shape, len(rig.marker_names), 3),
        )
        data["rest_mm"] = (("marker", "axis"), rig.rest_mm)
    else:
        seen = rig.observables
        coords |= {
            "observable": [o.name for o in seen],
            "unit": ("observable", [o.unit for o in seen]),
            "marker_of": ("observable", [rig.marker_names[o.marker] if o.marker >= 0 else "" for o in seen]),
            "axis_of": ("observable", ["xyz"[o.axis] if o.axis >= 0 else "" for o in seen]),
        }
        data["observed"] = (("capture", "time", "observable"), rows)
    logs = {"tilt": ("deg", plan.session_tilt_deg), "payload": ("kg", plan.session_payload_kg)}
    logs = {name: log for name, log in logs.items() if len(set(log[1])) > 1}
    if logs:
        coords |= {
            "covariate": list(logs),
            "covariate_unit": ("covariate", [unit for unit, _ in logs.values()]),
        }
        value = np.array([each for _, each in logs.values()]).T[plan.capture_session]
        data["covariates"] = (
            ("capture", "time", "covariate"),
            np.where(np.isfinite(hold)[..., None], value[:, None, :], np.nan),
        )
    attrs = {"run": "", "source": "table", "between_sessions": plan.between_sessions, "units": "kPa"}
    dataset = xr.Dataset(data, coords=coords, attrs=attrs)
    for name in ("commanded", "event_commanded", "measured"):
        if name in dataset:
            dataset[name].attrs["units"] = "kPa"
    return dataset


def in_space(rig: Rig) -> bool:
    """Whether the observables are all markers, one after the other, along all three axes."""
    places = [(o.marker, o.axis) for o in rig.observables]
    return places == [(m, a) for m in range(len(rig.marker_names)) for a in range(3)]
