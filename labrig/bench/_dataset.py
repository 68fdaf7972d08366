"""A drawn campaign as the Dataset of docs/reference/dataset.md."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from labrig.bench._bodies import BenchBody
from labrig.bench._programmes import Plan

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


def _padded(rows: Array, counts: NDArray[np.int64]) -> Array:
    """Rows (R, ...) of captures with `counts` (F,) rows each as (F, T, ...), NaN where a hold is shorter."""
    out = np.full((len(counts), int(counts.max()), *rows.shape[1:]), np.nan)
    inside = np.arange(out.shape[1]) < counts[:, None]
    out[inside] = rows
    return out


def to_dataset(
    body: BenchBody, plan: Plan, measured: Array, max_kpa: float, random: np.random.Generator
) -> "xr.Dataset":
    """The Dataset of a plan and its measured positions (R, M, A); half of the campaigns have pressure
    sensors.

    Sensors sit at the regulators, so they read what was commanded. Between sessions whose pressures are
    `released` or `unknown` no event is logged.
    """
    import xarray as xr

    counts = np.array([len(r) for r in plan.capture_rows_s])
    since = np.concatenate(plan.capture_rows_s)
    commanded = np.array(plan.capture_kpa)
    session = np.array([f"s{k + 1}" for k in plan.capture_session])
    events = _events(plan)
    event_time = np.array([t for t, _, _ in events])
    coords = {
        "capture": np.arange(plan.captures),
        "chamber": list(body.chamber_names),
        "chamber_min": ("chamber", np.zeros(len(body.chamber_names))),
        "chamber_max": ("chamber", np.full(len(body.chamber_names), max_kpa)),
        "session": ("capture", session),
        "repeat": ("capture", np.array(plan.capture_repeat, dtype=str)),
        "event_of": ("capture", np.searchsorted(event_time, np.array(plan.capture_s) + 1e-9) - 1),
        "event_session": ("event", np.array([f"s{k + 1}" for _, _, k in events])),
    }
    hold = _padded(since, counts)
    data = {
        "commanded": (("capture", "chamber"), commanded),
        "hold_s": (("capture", "time"), hold),
        "time_s": (("capture", "time"), hold + np.array(plan.capture_s)[:, None]),
        "settled": (("capture", "time"), np.isfinite(hold)),
        "event_time_s": ("event", event_time),
        "event_commanded": (("event", "chamber"), np.array([p for _, p, _ in events])),
    }
    if random.random() < 0.5:
        read = commanded[:, None, :] + 0.05 * random.normal(size=(*hold.shape, commanded.shape[1]))
        data["measured"] = (
            ("capture", "time", "chamber"),
            np.where(np.isfinite(hold)[..., None], read, np.nan),
        )
    rows = _padded(measured, counts)
    if len(body.axes) == 3:
        coords |= {"marker": list(body.marker_names), "axis": ["x", "y", "z"]}
        data["position_mm"] = (("capture", "time", "marker", "axis"), rows)
        data["rest_mm"] = (("marker", "axis"), body.rest_mm)
    else:
        coords |= {
            "observable": list(body.marker_names),
            "unit": ("observable", [body.unit]),
            "marker_of": ("observable", [""]),
            "axis_of": ("observable", [""]),
        }
        data["observed"] = (("capture", "time", "observable"), rows[..., 0])
    if len(set(plan.session_tilt_deg)) > 1:
        tilt = np.array(plan.session_tilt_deg)[plan.capture_session]
        coords |= {"covariate": ["tilt"], "covariate_unit": ("covariate", ["deg"])}
        value = np.where(np.isfinite(hold), tilt[:, None], np.nan)
        data["covariates"] = (("capture", "time", "covariate"), value[..., None])
    attrs = {"run": "", "source": "table", "between_sessions": plan.between_sessions, "units": "kPa"}
    dataset = xr.Dataset(data, coords=coords, attrs=attrs)
    for name in ("commanded", "event_commanded", "measured"):
        if name in dataset:
            dataset[name].attrs["units"] = "kPa"
    return dataset


def _events(plan: Plan) -> list[tuple[float, Array, int]]:
    """Actuations that a log would show: time, pressures, session; releases between sessions are not logged."""
    starts = np.array([plan.capture_s[plan.capture_session.index(k)] for k in range(plan.session + 1)])
    ends = np.array(
        [
            max(t for t, s in zip(plan.capture_s, plan.capture_session, strict=True) if s == k)
            for k in range(plan.session + 1)
        ]
    )
    events = []
    for time_s, pressure in plan.commands:
        session = int(np.searchsorted(starts, time_s + 6.0, side="right")) - 1
        session = max(session, 0)
        between = session < plan.session and time_s > ends[session] and not pressure.any()
        if not between:
            events.append((time_s, pressure, session))
    return events
