"""Where the model fails: its error by marker, region, chamber, pressure, direction, time and pair."""

from itertools import combinations, pairwise
from typing import Any

import numpy as np

from labrig.diagnosis._floor import Floor
from labrig.effects import Context
from labrig.effects._rows import Floats, Ints
from labrig.effects.coupling import overlap

_CLEAR = 1.3
_KEPT = {"marker": 12, "observable": 12, "capture": 5, "pair of chambers": 8}


def where(context: Context, left: Floats, floor: Floor, counted: Ints) -> list[dict[str, Any]]:
    """Errors (root mean square, in units) of parts of the campaign, and each part's share of the whole.

    `left` (F, K) is measured minus model; `share` is the part of the square beyond the floor that falls in
    the group; `clear` says that its error stands above the floor by more than 30 %.
    """
    rows = context.rows
    square = np.where(np.isfinite(left), left, np.nan)[:, counted] ** 2
    floor_square = float(np.mean(floor.row[counted] ** 2))
    excess = float(np.nansum(np.maximum(square - floor_square, -np.inf)))
    out: list[dict[str, Any]] = []

    def add(group: str, name: str, part: Floats) -> None:
        if not np.isfinite(part).any():
            return
        mean = float(np.nanmean(part))
        share = float(np.nansum(part - floor_square)) / excess if excess > 0 else 0.0
        clear = mean > _CLEAR**2 * floor_square
        out.append(
            {
                "group": group,
                "name": name,
                "error": float(np.sqrt(mean)),
                "share": float(np.clip(share, 0.0, 1.0)),
                "clear": bool(clear),
            }
        )

    def by_rows(group: str, names: list[str], masks: list[Any]) -> None:
        for name, mask in zip(names, masks, strict=True):
            if mask.any() and not mask.all():
                add(group, name, square[mask])

    if rows.markers:
        for m, name in enumerate(rows.markers):
            own = (rows.marker == m)[counted]
            if own.any():
                add("marker", name, square[:, own])
        _regions(context, square, counted, add)
    if not rows.markers or len(rows.unit) <= 12:
        for i, k in enumerate(counted):
            add("observable", rows.observables[int(k)], square[:, [i]])
    x = rows.fraction
    for c, chamber in enumerate(rows.chambers):
        if context.moves:
            by_rows("chamber", [f"{chamber} above half"], [x[:, c] > 0.5])
    load = x.mean(axis=1)
    edges = np.quantile(load, [0, 0.25, 0.5, 0.75, 1.0])
    mean_pressure = rows.actuation.mean(axis=1)
    if np.ptp(load) > 0:
        for low, high in pairwise(edges):
            mask = (load >= low) & (load <= high)
            label = f"{mean_pressure[mask].min():.3g}-{mean_pressure[mask].max():.3g} {rows.actuation_unit}"
            by_rows("pressure band", [label], [mask])
    turn = np.sign(context.direction[rows.event].sum(axis=1))
    by_rows("direction", ["mostly up", "mostly down"], [turn > 0, turn < 0])
    _stretches("time in session", context.session_time_s, "s", by_rows)
    _stretches("time in hold", context.elapsed_s, "s", by_rows)
    if len(rows.chambers) > 1 and context.moves:
        near = overlap(context)
        for i, j in combinations(range(len(rows.chambers)), 2):
            if near[i, j] > 0:
                both = (x[:, i] > 0.5) & (x[:, j] > 0.5)
                by_rows("pair of chambers", [f"{rows.chambers[i]} and {rows.chambers[j]} above half"], [both])
    for c in np.unique(rows.capture):
        add("capture", str(int(c)), square[rows.capture == c])
    return _worst_first(out)


def _regions(context: Context, square: Floats, counted: Ints, add: Any) -> None:
    """Markers that one chamber moves most are that chamber's region."""
    reach = np.abs(context.jacobian).mean(axis=0) * context.span
    owner = reach.argmax(axis=1)
    for c, chamber in enumerate(context.rows.chambers):
        own = (owner == c)[counted]
        if own.any() and not own.all():
            add("region", f"over {chamber}", square[:, own])


def _stretches(group: str, t: Floats, unit: str, by_rows: Any) -> None:
    if np.ptp(t) <= 0:
        return
    edges = np.quantile(t, [0, 1 / 3, 2 / 3, 1])
    for low, high in pairwise(edges):
        if high > low:
            by_rows(group, [f"{low:.3g}-{high:.3g} {unit}"], [(t >= low) & (t <= high)])


def _worst_first(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    out = []
    for group in dict.fromkeys(e["group"] for e in entries):
        own = sorted((e for e in entries if e["group"] == group), key=lambda e: -e["error"])
        out += own[: _KEPT.get(group, len(own))]
    return sorted(out, key=lambda e: -e["error"])
