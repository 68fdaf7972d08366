"""What a page draws of a result: markers and their surface at every capture, or its observables. Plain values."""

from typing import TYPE_CHECKING, Any, NotRequired, TypedDict

import numpy as np

from labrig.arrays import Floats
from labrig.view import (
    Figure,
    capture_words,
    chamber_outlines,
    cloud,
    filled,
    name_places,
    proud,
    residuals,
    rms,
    skin,
    surface_figure,
)

if TYPE_CHECKING:
    from labrig.diagnosis import Result, VersusResult


MOST = 600
"""Captures that a page is given shapes of; of more, evenly many and the worst."""


Numbers = list[Any]
"""Numbers in lists as an array has axes, None for what is not one."""


class Shape(TypedDict):
    """A surface at rest, and what moves it."""

    names: list[str]
    rest: Numbers
    figure: Figure
    off: Numbers
    above: list[Numbers]
    beside: list[Numbers]
    weight: Numbers
    ends: Numbers
    middles: Numbers
    chambers: list[str]


class CaptureErrors(TypedDict):
    """The errors of every capture and, where there are some, of every marker."""

    error: Numbers
    error_after: Numbers
    marker_before: NotRequired[Numbers]
    marker_after: NotRequired[Numbers]


class Captures(CaptureErrors):
    """What is drawn of captures, of how many; of markers, where each was, should be, and how far that is off."""

    index: list[int]
    of: int
    names: list[str]
    words: list[str]
    measured: NotRequired[Numbers]
    seen: NotRequired[Numbers]
    before: NotRequired[Numbers]
    after: NotRequired[Numbers]
    each_before: NotRequired[Numbers]
    each_after: NotRequired[Numbers]


def shape_of(result: "Result | VersusResult") -> Shape | None:
    """The surface as a figure at rest, and what moves it: the skin's weights (V, M), the ends of the chambers' lines,
    how far the names of markers and of chambers stand `above` (N, 3), and which of them `beside` it.

    None where a run has no geometry.
    """
    markers = cloud(result.fields)
    if markers is None:
        return None
    surface = skin(markers.rest_mm)
    known = surface is not None and markers.reach is not None
    lines = chamber_outlines(surface, markers.chambers, markers.reach) if known else []  # type: ignore[arg-type]
    nothing = np.zeros(len(markers.names))
    named = name_places(markers.names, markers.rest_mm, surface, lines)
    return {
        "names": list(markers.names),
        "rest": short(markers.rest_mm),
        "figure": surface_figure(markers.names, markers.rest_mm, nothing, 1.0, "mm", surface, lines),
        "off": short(proud(markers.rest_mm), 3),
        "above": [short(named.of_markers), short(named.of_chambers)],
        "beside": [named.markers_beside.tolist(), named.chambers_beside.tolist()],
        "weight": [] if surface is None else short(surface.weight, 4),
        "ends": short(np.concatenate([o.ends for o in lines]), 3) if lines else [],
        "middles": short(np.array([o.middle for o in lines]), 3) if lines else [],
        "chambers": [o.name for o in lines],
    }


def errors_of(result: "Result") -> CaptureErrors:
    """The errors of every capture and of every marker, before and after: what changes with the effects."""
    before, after = residuals(result.fields)
    markers = cloud(result.fields)
    content: CaptureErrors = {
        "error": short(rms(before, axis=1), 4),
        "error_after": short(rms(after, axis=1), 4),
    }
    if markers is not None:
        content["marker_before"] = short(markers.before_mm, 4)
        content["marker_after"] = short(markers.after_mm, 4)
    return content


def captures_of(result: "Result | VersusResult") -> Captures:
    """Every capture: in words, its error before and after, and of markers where they were and should be."""
    fields = result.fields
    before, after = residuals(fields)
    errors = rms(before, axis=1)
    kept = _kept(errors)
    content: Captures = {
        "index": kept.tolist(),
        "of": len(errors),
        "names": [str(fields["capture"].values[k]) for k in kept],
        "words": [capture_words(fields, int(k)) for k in kept],
        "error": short(errors[kept], 4),
        "error_after": short(rms(after, axis=1)[kept], 4),
    }
    markers = cloud(fields)
    if markers is not None:
        content["measured"] = short(filled(markers.measured_mm, markers.base_mm)[kept])
        content["seen"] = np.asarray(np.isfinite(markers.measured_mm[kept]).all(axis=2)).tolist()
        content["before"] = short(markers.base_mm[kept])
        content["after"] = short(markers.model_mm[kept])
        content["each_before"] = short(markers.base_error_mm[kept], 4)
        content["each_after"] = short(markers.model_error_mm[kept], 4)
        content["marker_before"] = short(markers.before_mm, 4)
        content["marker_after"] = short(markers.after_mm, 4)
    return content


def _kept(errors: Floats) -> np.ndarray:
    if len(errors) <= MOST:
        return np.arange(len(errors))
    even = np.linspace(0, len(errors) - 1, MOST - 50).astype(int)
    worst = np.argsort(-np.nan_to_num(errors, nan=-1.0))[:50]
    return np.unique(np.concatenate([even, worst]))


def short(values: Floats, digits: int = 2) -> Numbers:
    """Nested lists of rounded numbers, None for what is not one."""
    rounded = np.round(np.asarray(values, dtype=float), digits).astype(object)
    rounded[~np.isfinite(np.asarray(values, dtype=float))] = None
    return rounded.tolist()
