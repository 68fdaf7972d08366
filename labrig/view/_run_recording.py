"""A run without a model in a recording: the markers as they moved, the surface at each capture, the pressures."""

from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._text import counted
from labrig.arrays import Floats
from labrig.view._colours import moved_colours, rgb
from labrig.view._fields import rms, skin
from labrig.view._legend import legend_picture
from labrig.view._scene import CHAMBER_COLOURS, scene_in_front

if TYPE_CHECKING:
    import xarray as xr

    from labrig.view._rerun import Recording

MAX_ROWS = 3000
MAX_CURVES = 12


def draw_run(recording: "Recording", run: "xr.Dataset") -> None:
    """Log a run (`labrig.open_run`) on the timelines `capture` and `time`."""
    from labrig.view import _rerun

    views: list[Any] = []
    if "position_mm" in run and np.isfinite(run["position_mm"].values).any():  # no cameras, or no capture yet
        views.append(_markers(recording, run))
    if "observed" in run and run.sizes["capture"]:
        views.append(_observables(recording, run))
    pressures = [_commanded(recording, run), _measured(recording, run)]
    recording.text("/about", _about(run))
    recording.picture("/legend", legend_picture(None, "", [str(name) for name in run["chamber"].values]))
    about = _rerun.stacked(
        _rerun.page("Run", "/about"), _rerun.picture("What the colours mean", "/legend"), shares=[1.2, 1.0]
    )
    bottom = _rerun.side_by_side(*pressures, about, shares=[2.0, 2.0, 1.2])
    view = _rerun.stacked(_rerun.side_by_side(*views), bottom, shares=[2.0, 1.0]) if views else bottom
    recording.arrange(_rerun.arrangement(view, "time"))


def _rows(run: "xr.Dataset") -> list[tuple[int, int]]:
    """(capture, row) of what is drawn: everything recorded, or evenly many of it."""
    recorded = np.argwhere(np.isfinite(run["time_s"].values))
    if len(recorded) > MAX_ROWS:
        recorded = recorded[np.linspace(0, len(recorded) - 1, MAX_ROWS).astype(int)]
    return [(int(n), int(t)) for n, t in recorded]


def _markers(recording: "Recording", run: "xr.Dataset") -> Any:
    position = np.asarray(run["position_mm"].values, dtype=float)
    time_s = np.asarray(run["time_s"].values, dtype=float)
    mean = _hold_means(position)
    rest = _rest(run, mean)
    known = np.isfinite(rest).all(axis=1)
    surface = skin(rest[known]) if known.all() else None
    radius = 0.006 * float(np.ptp(rest[known], axis=0).max())
    moved = np.linalg.norm(mean - rest, axis=2)
    top = float(np.nanquantile(moved, 0.98)) if np.isfinite(moved).any() else 1.0
    names = [str(name) for name in run["marker"].values]
    recording.upright("/rig")
    recording.at(time_s=0.0)
    if surface is not None:
        colours = moved_colours(np.zeros(len(surface.weight)), top)
        recording.mesh("/rig/surface", surface.vertices(rest), surface.triangles, colours)
    first = np.argmax(np.isfinite(time_s), axis=1)
    for n in range(len(position)):
        recording.at(capture=n, time_s=float(time_s[n, first[n]]))
        if surface is not None:
            shape = np.where(np.isfinite(mean[n]), mean[n], rest)
            distance = np.linalg.norm(shape - rest, axis=1)
            colours = moved_colours(np.clip(surface.vertices(distance), 0.0, None), top)
            recording.mesh("/rig/surface", surface.vertices(shape), surface.triangles, colours)
    last = rest.copy()
    for n, t in _rows(run):
        recording.at(capture=n, time_s=float(time_s[n, t]))
        seen = np.isfinite(position[n, t]).all(axis=1)
        last[seen] = position[n, t][seen]
        labels = [name for name, is_seen in zip(names, seen.tolist(), strict=True) if is_seen]
        recording.points("/rig/measured", position[n, t][seen], rgb("#f3cf9b"), radius, labels)
        unseen = [
            f"{name}: not seen" for name, is_seen in zip(names, seen.tolist(), strict=True) if not is_seen
        ]
        recording.points("/rig/occluded", last[~seen], rgb("#5a6472"), radius, unseen)
    return scene_in_front("Markers, and the surface in the colour of how far it moved", "/rig", rest[known])


def _hold_means(position: Floats) -> Floats:
    """Means over each hold, (N, M, 3)."""
    finite = np.isfinite(position)
    count = finite.sum(axis=1)
    total = np.where(finite, position, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _rest(run: "xr.Dataset", mean: Floats) -> Floats:
    """Where the markers rest; the mean over the campaign where that is not known."""
    usual = _hold_means(mean[None])[0]
    if "rest_mm" not in run:
        return usual
    rest = np.asarray(run["rest_mm"].values, dtype=float)
    return np.where(np.isfinite(rest), rest, usual)


def _commanded(recording: "Recording", run: "xr.Dataset") -> Any:
    from labrig.view import _rerun

    at, values = (
        np.asarray(run["event_time_s"].values, dtype=float),
        np.asarray(run["event_commanded"].values),
    )
    for k, name in enumerate(str(chamber) for chamber in run["chamber"].values):
        recording.series(
            f"/commanded/{name}", name, rgb(CHAMBER_COLOURS[k % len(CHAMBER_COLOURS)]), 1.5, steps=True
        )
        recording.curve(f"/commanded/{name}", "time", at, values[:, k].astype(float))
    return _rerun.plot(f"commanded, {run['commanded'].attrs.get('units', '')}", "/commanded/**", legend=False)


def _measured(recording: "Recording", run: "xr.Dataset") -> Any:
    from labrig.view import _rerun

    at = np.asarray(run["time_s"].values, dtype=float).ravel()
    order = np.argsort(at, kind="stable")[: int(np.isfinite(at).sum())]
    for k, name in enumerate(str(chamber) for chamber in run["chamber"].values):
        values = np.asarray(run["measured"].values[..., k], dtype=float).ravel()[order]
        if np.isfinite(values).any():
            recording.series(f"/measured/{name}", name, rgb(CHAMBER_COLOURS[k % len(CHAMBER_COLOURS)]))
            recording.curve(f"/measured/{name}", "time", at[order], values)
    return _rerun.plot(f"measured, {run['commanded'].attrs.get('units', '')}", "/measured/**", legend=False)


def _observables(recording: "Recording", run: "xr.Dataset") -> Any:
    """Those observables that vary most, each over time."""
    from labrig.view import _rerun

    values = np.asarray(run["observed"].values, dtype=float).reshape(-1, run.sizes["observable"])
    at = np.asarray(run["time_s"].values, dtype=float).ravel()
    keep = np.flatnonzero(np.isfinite(at))
    keep = keep[np.argsort(at[keep], kind="stable")]
    spread = rms(values - np.nan_to_num(_hold_means(values[None])[0]), axis=0)
    chosen = np.sort(np.argsort(-np.nan_to_num(spread, nan=-1.0))[:MAX_CURVES])
    for i, k in enumerate(chosen):
        name, unit = str(run["observable"].values[k]), str(run["unit"].values[k])
        recording.series(
            f"/observed/{name}", f"{name}, {unit}", rgb(CHAMBER_COLOURS[i % len(CHAMBER_COLOURS)])
        )
        recording.curve(f"/observed/{name}", "time", at[keep], values[keep, k])
    return _rerun.plot("observed", "/observed/**")


def _about(run: "xr.Dataset") -> str:
    lines = [
        f"# {run.attrs.get('run', 'run')}",
        f"{counted(run.sizes['capture'], 'capture')}, {counted(run.sizes['chamber'], 'chamber')}",
    ]
    if run.sizes.get("marker", 0):
        lines.append(counted(run.sizes["marker"], "marker"))
    for warning in run.attrs.get("warnings", []):
        lines.append(f"**{warning}**")
    return "\n\n".join(lines)
