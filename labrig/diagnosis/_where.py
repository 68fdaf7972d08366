"""Where the model fails: its error by marker, region, chamber, pressure, direction, time and pair."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from labrig import contents
from labrig.arrays import Floats, Ints
from labrig.diagnosis._floor import Floor
from labrig.effects import Context
from labrig.effects.coupling import overlap

_CLEAR, _BY_CHANCE = 1.3, 0.05
_KEPT = {"marker": 12, "session": 12, "observable": 12, "capture": 5, "pair of chambers": 8}


@dataclass(frozen=True)
class Place:
    """A part of a campaign: some of its `rows` (F,) and some of its counted observables, `columns` (K,)."""

    group: str
    name: str
    rows: NDArray[np.bool_]
    columns: NDArray[np.bool_]

    def of(self, cells: Floats) -> Floats:
        """The part of cells (F, K) that lies here."""
        return cells[self.rows][:, self.columns]


def places(context: Context, counted: Ints) -> Iterator[Place]:
    """The places that errors are told for; `counted` (K,) are the observables that errors are quoted for."""
    rows = context.rows
    every_row, every_column = np.ones(len(rows.capture), dtype=bool), np.ones(len(counted), dtype=bool)

    def by_rows(group: str, name: str, mask: NDArray[np.bool_]) -> Iterator[Place]:
        if mask.any() and not mask.all():
            yield Place(group, name, mask, every_column)

    for m, name in enumerate(rows.markers):
        if (own := (rows.marker == m)[counted]).any():
            yield Place("marker", name, every_row, own)
    if rows.markers:
        # markers that one chamber moves most, along all axes together, are that chamber's region
        reach = (np.abs(context.jacobian).mean(axis=0) * context.span) ** 2
        for m in np.unique(rows.marker[rows.marker >= 0]):
            reach[rows.marker == m] = reach[rows.marker == m].sum(axis=0)
        owner = np.where(rows.marker >= 0, reach.argmax(axis=1), -1)
        for c, chamber in enumerate(rows.chambers):
            own = (owner == c)[counted]
            if own.any() and not own.all():
                yield Place("region", f"over {chamber}", every_row, own)
    if not rows.markers or len(rows.unit) <= 12:
        for i, k in enumerate(counted):
            yield Place("observable", rows.observables[int(k)], every_row, np.arange(len(counted)) == i)
    x = rows.fraction
    if context.moves:
        for c, chamber in enumerate(rows.chambers):
            yield from by_rows("chamber", f"{chamber} above half", x[:, c] > 0.5)
    load, mean_pressure = x.mean(axis=1), rows.actuation.mean(axis=1)
    if np.ptp(load) > 0:
        for low, high in pairwise(np.quantile(load, [0, 0.25, 0.5, 0.75, 1.0])):
            mask = (load >= low) & (load <= high)
            label = (
                f"{mean_pressure[mask].min():.3g} to {mean_pressure[mask].max():.3g} {rows.actuation_unit}"
            )
            kind = "pressure band" if rows.by_pressure else "input band"
            yield from by_rows(kind, label, mask)
    turn = np.sign(context.direction[rows.event].sum(axis=1))
    yield from by_rows("direction", "mostly up", turn > 0)
    yield from by_rows("direction", "mostly down", turn < 0)
    for group, t in (("time in session", context.session_time_s), ("time in hold", context.elapsed_s)):
        if np.ptp(t) > 0:
            for low, high in pairwise(np.quantile(t, [0, 1 / 3, 2 / 3, 1])):
                if high > low:
                    yield from by_rows(group, f"{low:.3g} to {high:.3g} s", (t >= low) & (t <= high))
    for s, name in enumerate(rows.sessions):
        yield from by_rows("session", name, rows.session == s)
    if len(rows.chambers) > 1 and context.moves:
        near = overlap(context)
        for i, j in combinations(range(len(rows.chambers)), 2):
            if near[i, j] > 0:
                both = (x[:, i] > 0.5) & (x[:, j] > 0.5)
                name = f"{rows.chambers[i]} and {rows.chambers[j]} above half"
                yield from by_rows("pair of chambers", name, both)
    for c in np.unique(rows.capture):
        yield Place("capture", str(int(c)), rows.capture == c, every_column)


def where(context: Context, left: Floats, floor: Floor, counted: Ints) -> list[contents.Place]:
    """Errors (root mean square, in units) of parts of the campaign, and each part's share of the whole.

    `left` (F, K) is measured minus model; `share` is the part of the square beyond the floor that falls in
    the group; `clear` says that its error stands above the floor by more than 30 %, and by more than chance would have
    it in the worst of a group in one campaign of twenty (a chi-square of captures times observables, after Bonferroni).
    """
    square = np.where(np.isfinite(left), left, np.nan)[:, counted] ** 2
    floor_square = float(np.mean(floor.row[counted] ** 2))
    excess = float(np.nansum(square - floor_square))
    out: list[contents.Place] = []
    every = list(places(context, counted))
    in_group = Counter(place.group for place in every)
    for place in every:
        part = place.of(square)
        if not np.isfinite(part).any():
            continue
        mean = float(np.nanmean(part))
        numbers = len(np.unique(context.rows.capture[place.rows])) * part.shape[1]
        chance = float(chdtri(numbers, _BY_CHANCE / in_group[place.group])) / numbers
        share = float(np.nansum(part - floor_square)) / excess if excess > 0 else 0.0
        out.append(
            {
                "group": place.group,
                "name": place.name,
                "error": float(np.sqrt(mean)),
                "share": float(np.clip(share, 0.0, 1.0)),
                "clear": bool(mean > max(_CLEAR**2, chance) * floor_square),
            }
        )
    return _worst_first(out)


def _worst_first(entries: list[contents.Place]) -> list[contents.Place]:
    out = []
    for group in dict.fromkeys(e["group"] for e in entries):
        own = sorted((e for e in entries if e["group"] == group), key=lambda e: -e["error"])
        out += own[: _KEPT.get(group, len(own))]
    return sorted(out, key=lambda e: -e["error"])
