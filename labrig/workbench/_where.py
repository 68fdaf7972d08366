"""Where: the error of a marker, a chamber or a region against pressure, direction and time."""

from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np
from numpy.typing import NDArray
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.view import added
from labrig.workbench._answers import answering, told
from labrig.workbench._desk import Desk
from labrig.workbench._held import Key, opened, trial
from labrig.workbench._run import Pair, pair_of

if TYPE_CHECKING:
    from labrig.diagnosis import Opened
    from labrig.effects import Context


class _Panel(TypedDict):
    """What the residual of a place is drawn against."""

    key: str
    title: str
    unit: str
    varies: bool
    x: list[float | None]
    means: list[list[float]]


MOST = 1500
BINS = 12


def routes(desk: Desk) -> list[Route]:
    """`/api/where`."""
    return [Route("/api/where", answering(lambda request: _where(desk, request)))]


def _where(desk: Desk, request: Request) -> Any:
    asked = request.query_params
    pair = pair_of(desk, asked)
    text = desk.worker.ask(series, pair.key, asked.get("kind", "all"), asked.get("name", ""), found_in(pair))
    return Response(text, media_type="application/json")


def found_in(pair: Pair) -> tuple[str, ...]:
    """The effects that the diagnosis fitted for the model; none without a diagnosis."""
    return tuple(added(pair.diagnosis())) if pair.has("diagnosis.json") else ()


def series(key: Key, kind: str, name: str, effects: tuple[str, ...]) -> str:
    """The residual of a place over all that it may depend on, as JSON; in the worker.

    `kind` is marker, chamber, region, observable or all. The residual of a marker is signed, along the line on which
    the model moves it most, positive where it went farther than predicted; of a chamber or a region it is the mean
    over markers, of a chamber weighted by how far it alone moves each. In the unit of the observables.
    """
    from labrig.diagnosis import whole_change

    own = opened(key)
    context, rows, left = own.ready.context, own.ready.context.rows, own.ready.residual
    pattern, share, floor, chamber = _pattern(own, kind, name)
    measured = _along(left, pattern, share)
    fitted = np.full(len(measured), np.nan)
    if effects:
        try:
            change = whole_change(context, trial(key, effects, True).fit)
            fitted = _along(np.where(np.isfinite(left), change, np.nan), pattern, share)
        except LabrigError:
            effects = ()
    pressure = rows.actuation[:, chamber]
    turn = context.direction[rows.event, chamber]
    known = np.isfinite(measured)
    what = "pressure" if rows.by_pressure else "input"
    panels = [
        ("pressure", f"{what} of {rows.chambers[chamber]}", rows.actuation_unit, pressure),
        _in_hold_or_speed(context, chamber),
        ("direction", f"last move of {rows.chambers[chamber]}", "", turn),
        ("time in session", "time in session", "s", context.session_time_s),
    ]
    shown = np.flatnonzero(known)
    if len(shown) > MOST:
        shown = shown[np.linspace(0, len(shown) - 1, MOST).astype(int)]
    captures = [str(int(c)) for c in rows.capture[shown]]
    return told(
        {
            "kind": kind,
            "name": name,
            "units": own.units,
            "floor": floor,
            "effects": list(effects),
            "rms": float(np.sqrt(np.mean(measured[known] ** 2))) if known.any() else None,
            "y": _short(measured[shown]),
            "fitted": _short(fitted[shown]) if effects else [],
            "capture": captures,
            "panels": [_panel(*p, measured, fitted, known, shown) for p in panels],
            "places": own.places,
            "chamber": rows.chambers[chamber],
        }
    )


def _in_hold_or_speed(context: "Context", chamber: int) -> tuple[str, str, str, Floats]:
    """The panel of the time in the hold, or, of a record without holds, of the input's speed."""
    if not context.sample_s:
        return "time in hold", "time in hold", "s", context.elapsed_s
    rows = context.rows
    name = f"speed of {rows.chambers[chamber]}"
    return "input speed", name, f"{rows.actuation_unit}/s", context.input_speed[:, chamber]


def _pattern(own: "Opened", kind: str, name: str) -> tuple[Floats, Floats, float, int]:
    """A place as weights of the observables, (K,), signed and not, its floor, and the chamber that moves it most."""
    context, rows, floor = own.ready.context, own.ready.context.rows, own.ready.floor.row
    reach = np.abs(context.jacobian).mean(axis=0) * np.abs(context.span)
    counted = own.ready.regression.counted
    chosen = np.zeros(len(rows.observables))
    weight = np.ones(len(rows.observables))
    if kind == "marker" and name in rows.markers:
        chosen[rows.marker == rows.markers.index(name)] = 1
    elif kind == "observable" and name in rows.observables:
        chosen[rows.observables.index(name)] = 1
    elif kind == "chamber" and name in rows.chambers:
        chosen[counted] = 1
        weight = _of_markers(own, reach[:, rows.chambers.index(name)])
    elif kind == "region" and name.removeprefix("over ") in rows.chambers:
        chosen[reach.argmax(axis=1) == rows.chambers.index(name.removeprefix("over "))] = 1
    elif kind == "all":
        chosen[counted] = 1
    else:
        raise LabrigError(f"there is no {kind} {name!r} in this run")
    chosen[np.setdiff1d(np.arange(len(chosen)), counted)] *= float(kind == "observable")
    line = _line(own)
    pattern, share = chosen * weight * line, chosen * weight * line**2
    if not pattern.any():
        raise LabrigError(f"{kind} {name}: nothing was measured there")
    noise = float(np.sqrt((pattern**2 * floor**2).sum() / (pattern**2).sum()))
    chamber = (
        rows.chambers.index(name)
        if kind == "chamber"
        else int((reach * (chosen[:, None] > 0)).sum(0).argmax())
    )
    return pattern, share, noise, chamber


def _line(own: "Opened") -> Floats:
    """Of each marker the unit vector along which the model moves it most, as weights (K,); 1 for other observables."""
    context, rows = own.ready.context, own.ready.context.rows
    out = np.ones(len(rows.observables))
    for m in range(len(rows.markers)):
        at = np.flatnonzero(rows.marker == m)
        moved = context.displacement[:, at]
        if not len(at) or not np.abs(moved).any():
            continue
        axis = np.linalg.svd(moved, full_matrices=False)[2][0]
        out[at] = axis if (moved @ axis).sum() >= 0 else -axis
    return out


def _of_markers(own: "Opened", reach: Floats) -> Floats:
    """The same weight for all coordinates of a marker: how far it is moved."""
    rows = own.ready.context.rows
    out = reach.copy()
    for m in range(len(rows.markers)):
        at = rows.marker == m
        out[at] = np.sqrt((reach[at] ** 2).sum())
    return out


def _along(left: Floats, pattern: Floats, share: Floats) -> Floats:
    """Weighted means (F,) of residuals (F, K) along a pattern, over what was seen of them."""
    seen = np.isfinite(left)
    total = np.where(seen, share, 0.0).sum(axis=1)
    return (np.where(seen, left, 0.0) @ pattern) / np.where(total > 0, total, np.nan)


def _panel(
    key: str,
    title: str,
    unit: str,
    x: Floats,
    measured: Floats,
    fitted: Floats,
    known: NDArray[np.bool_],
    shown: NDArray[np.int64],
) -> _Panel:
    """A panel with its points and the means along it; without those where nothing varies."""
    varies = bool(np.ptp(x[known]) > 1e-9) if known.any() else False
    means = _means(x[known], measured[known], fitted[known]) if varies else []
    return {
        "key": key,
        "title": title,
        "unit": unit,
        "varies": varies,
        "x": _short(x[shown]),
        "means": means,
    }


def _means(x: Floats, measured: Floats, fitted: Floats) -> list[list[float]]:
    """Mean x, measured, its standard error and fitted, in parts of equally many points, or at each of few places."""
    order = np.argsort(x, kind="stable")
    places = np.unique(x)
    if len(places) <= BINS:
        parts = np.split(order, np.searchsorted(x[order], places[1:]))
    else:
        parts = np.array_split(order, BINS)
    return [
        [
            float(x[p].mean()),
            float(measured[p].mean()),
            float(measured[p].std() / np.sqrt(max(len(p), 1))),
            float(np.nanmean(fitted[p])) if np.isfinite(fitted[p]).any() else float("nan"),
        ]
        for p in parts
        if len(p)
    ]


def _short(values: Floats) -> list[float | None]:
    return [float(f"{v:.4g}") if np.isfinite(v) else None for v in values]
