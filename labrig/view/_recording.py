"""A finished campaign or diagnosis as an .rrd recording that a person finds arranged."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._durable import aside, put_at
from labrig._errors import LabrigError
from labrig._text import number, word
from labrig.view._colours import floor_for_colours, rgb
from labrig.view._fields import (
    Cloud,
    actuated,
    capture_numbers,
    cloud,
    kept_captures,
    residuals,
    rms,
    skin,
    worst_captures,
)
from labrig.view._legend import legend_picture
from labrig.view._naming import added
from labrig.view._scene import CHAMBER_COLOURS, draw_state, scene_in_front
from labrig.view._style import BEFORE, FLOOR
from labrig.view._words import has_improved, note

if TYPE_CHECKING:
    import xarray as xr

    from labrig.diagnosis import Result
    from labrig.view._rerun import Recording

MAX_CAPTURES = 400
ARROW_SHARE = 0.2  # of the surface's size, that the longest arrows take


def write_recording(source: "Result | xr.Dataset", path: str | Path) -> Path:
    """Write a result, or a run as `labrig.open_run` gives it, as an .rrd recording; returns its path.

    It is written under another name first, so that a recording is never half a recording. Raises `LabrigError` where
    the disk is full.
    """
    from labrig.view._rerun import Recording

    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    recording = Recording(path.stem)
    try:
        with aside(path) as partial:
            recording.to_file(partial)
            draw(recording, source)
            recording.close()
            put_at(partial, path)
    except RuntimeError as error:  # as rerun says what the system says
        if "os error" not in str(error):
            raise
        said = str(error).rpartition("Failed to write: ")[2].partition(" (os error")[0]
        raise LabrigError(f"the recording {path} cannot be written: {said}; make room there") from error
    return path


def draw(recording: "Recording", source: "Result | xr.Dataset") -> None:
    """Log a result or a run into an open recording."""
    if hasattr(source, "fields"):
        _draw_result(recording, source)  # pyright: ignore[reportArgumentType]
    else:
        from labrig.view._run_recording import draw_run

        draw_run(recording, source)  # pyright: ignore[reportArgumentType]


def _draw_result(recording: "Recording", result: "Result") -> None:
    from labrig.view import _rerun

    fields, summary = result.fields, result.summary
    markers = cloud(fields)
    improved = has_improved(summary)
    scenes: list[Any] = []
    floor: float | None = None
    if markers is not None:
        floor = floor_for_colours(summary.get("error", {}).get("floor"), markers.before_mm)
        scale = _draw_clouds(recording, markers, capture_numbers(fields), improved, floor)
        new = " + ".join(word(name) for name in added(summary)) or "best candidate"
        arrows = f"arrows: residual × {number(scale)}"
        name = "Before: the model as it was" if improved else "The model as it is"
        scenes.append(scene_in_front(f"{name} ({arrows})", "/before", markers.rest_mm))
        if improved:
            scenes.append(scene_in_front(f"After: with {new}", "/after", markers.rest_mm))
    curves = [_draw_errors(recording, result, improved)]
    if actuated(fields):
        curves.append(_draw_commanded(recording, fields))
    recording.text("/verdict", _verdict(result))
    chambers = [str(name) for name in fields["chamber"].values] if actuated(fields) else []
    text = _rerun.page("Verdict", "/verdict")
    if markers is not None or chambers:
        recording.picture("/legend", legend_picture(floor, str(summary.get("units", "")), chambers))
        text = _rerun.stacked(text, _rerun.picture("What the colours mean", "/legend"), shares=[2.5, 1.0])
    bottom = _rerun.side_by_side(*curves)
    if scenes:
        top = _rerun.side_by_side(*scenes, text, shares=[*([3.0] * len(scenes)), 2.0])
        view = _rerun.stacked(top, bottom, shares=[2.2, 1.0])
    else:
        view = _rerun.side_by_side(_rerun.stacked(*curves), text, shares=[2.0, 1.0])
    recording.arrange(_rerun.arrangement(view, "capture", at=worst_number(fields)))


def worst_number(fields: "xr.Dataset") -> int | None:
    """The number of the capture with the largest error before anything was added; None where there is none."""
    error = rms(residuals(fields)[0], axis=1)
    return int(capture_numbers(fields)[np.nanargmax(error)]) if np.isfinite(error).any() else None


def _draw_clouds(recording: "Recording", markers: Cloud, numbers: Any, improved: bool, floor: float) -> float:
    """Log every capture before and after; returns by how much the residual arrows are longer than the residuals."""
    size = float(np.ptp(markers.rest_mm, axis=0).max()) or 1.0
    before = markers.base_error_mm
    seen = before[np.isfinite(before)]
    top = float(np.quantile(seen, 0.98)) if seen.size else 1.0
    scale = _round_down(ARROW_SHARE * size / (np.sqrt(3.0) * top or 1.0))
    surface = skin(markers.rest_mm)
    states = [("/before", markers.base_mm)] + ([("/after", markers.model_mm)] if improved else [])
    for root, _ in states:
        recording.upright(root)
    for n in kept_captures(len(before), rms(before, axis=1), MAX_CAPTURES):
        recording.at(capture=int(numbers[n]))
        for root, predicted in states:
            measured = markers.measured_mm[n]
            draw_state(recording, root, markers.names, surface, measured, predicted[n], floor, scale)
    return scale


def _round_down(value: float) -> float:
    """1, 1.5, 2, 3, 5, 7, 10, 15, ... not above `value`; at least 1."""
    if value <= 1:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) if step * power <= value) * power)


def _draw_errors(recording: "Recording", result: "Result", improved: bool) -> Any:
    from labrig.view import _rerun

    before, after = residuals(result.fields)
    at = capture_numbers(result.fields)
    units = str(result.summary.get("units", ""))
    recording.series("/error/before", "before" if improved else "error", rgb(BEFORE), 2.0)
    recording.curve("/error/before", "capture", at, rms(before, axis=1))
    if improved:
        recording.series("/error/after", "after", rgb("#4fa3c1"), 2.0)
        recording.curve("/error/after", "capture", at, rms(after, axis=1))
    floor = result.summary.get("error", {}).get("floor")
    if floor is not None:
        recording.series("/error/floor", "noise floor", rgb(FLOOR), 1.0)
        recording.curve("/error/floor", "capture", at[[0, -1]], np.array([floor, floor], dtype=float))
    return _rerun.plot(f"rms error, {units}", "/error/**")


def _draw_commanded(recording: "Recording", fields: "xr.Dataset") -> Any:
    from labrig.view import _rerun

    commanded = np.asarray(fields["commanded"].values, dtype=float)
    for k, name in enumerate(str(chamber) for chamber in fields["chamber"].values):
        path = f"/commanded/{name}"
        recording.series(path, name, rgb(CHAMBER_COLOURS[k % len(CHAMBER_COLOURS)]), 1.5, steps=True)
        recording.curve(path, "capture", capture_numbers(fields), commanded[:, k])
    unit = str(fields["commanded"].attrs.get("units", ""))
    return _rerun.plot(f"commanded, {unit}", "/commanded/**", legend=False)


def _verdict(result: "Result") -> str:
    """The verdict as a page of markdown."""
    words, units = note(result.summary), str(result.summary.get("units", ""))
    lines = [f"# {words.headline}", *filter(None, [words.named, words.why])]
    if words.else_:
        lines += ["### What else could it be?", words.else_]
    lines += ["### What to measure next", words.next_]
    lines += ["### From the model to the noise", f"| | rms error, {units} |", "|---|---|"]
    table = "\n".join(
        [
            *lines[-2:],
            *(f"| {word(label.removeprefix('+ '))} | {number(value)} |" for label, value in result.waterfall),
        ]
    )
    lines[-2:] = [table]
    worst = worst_captures(result.fields, 5)
    after = {w.capture: f" → {number(w.model)}" if has_improved(result.summary) else "" for w in worst}
    rows = "\n".join(
        f"- capture {w.capture}: {number(w.base)}{after[w.capture]} {units} ({w.where})" for w in worst
    )
    return "\n\n".join([*lines, "### The worst captures", rows])
