"""Where the model fails: its error by marker, region, chamber, pressure, direction, time and pair."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, combinations, pairwise

import numpy as np
from scipy.special import chdtri

from labrig import contents
from labrig.arrays import Bools, Floats, Ints
from labrig.diagnosis._floor import Floor
from labrig.effects import Context
from labrig.effects.coupling import overlap

_CLEAR, _BY_CHANCE = 1.3, 0.05
"""How many times the floor an error is that stands clear of it; in how many campaigns chance has it in any place."""
_FEW_OBSERVABLES = 12
"""Observables up to which each is told by itself, markers' too."""
_STRETCHES = 20
"""Parts of a record without holds, whose single rows say little."""
_KEPT = {"marker": 12, "session": 12, "observable": 12, "capture": 5, "stretch": 5, "pair of chambers": 8}
"""Places of a group that are told, the worst ones."""


@dataclass(frozen=True)
class Place:
    """A part of a campaign: some of its `rows` (F,) and some of its counted observables, `columns` (K,)."""

    group: str
    name: str
    rows: Bools
    columns: Bools

    def of(self, cells: Floats) -> Floats:
        """The part of cells (F, K) that lies here."""
        return cells[self.rows][:, self.columns]


def places(context: Context, counted: Ints) -> Iterator[Place]:
    """The places that errors are told for; `counted` (K,) are the observables that errors are quoted for."""
    rows, every = context.rows, np.ones(len(counted), dtype=bool)
    for group, name, columns in _by_observable(context, counted):
        yield Place(group, name, np.ones(len(rows.capture), dtype=bool), columns)
    for group, name, mask in chain(_by_condition(context), _by_time(context), _by_pair(context)):
        if mask.any() and not mask.all():
            yield Place(group, name, mask, every)
    if context.sample_s:  # a row says little
        for group, name, mask in chain(_by_speed(context), _by_stretch(context)):
            yield Place(group, name, mask, every)
        return
    for c in np.unique(rows.capture):
        yield Place("capture", str(int(c)), rows.capture == c, every)


_Part = tuple[str, str, Bools]
"""The group of a place, its name, and its rows (F,) or counted observables (K,)."""


def _by_observable(context: Context, counted: Ints) -> Iterator[_Part]:
    """Markers, regions of the surface, and single observables where there are few."""
    rows = context.rows
    for m, name in enumerate(rows.markers):
        if (own := (rows.marker == m)[counted]).any():
            yield "marker", name, own
    if rows.markers:
        # markers that one chamber moves most, along all axes together, are that chamber's region
        reach = (np.abs(context.jacobian).mean(axis=0) * context.span) ** 2
        for m in np.unique(rows.marker[rows.marker >= 0]):
            reach[rows.marker == m] = reach[rows.marker == m].sum(axis=0)
        owner = np.where(rows.marker >= 0, reach.argmax(axis=1), -1)
        for c, chamber in enumerate(rows.chambers):
            own = (owner == c)[counted]
            if own.any() and not own.all():
                yield "region", f"over {chamber}", own
    if not rows.markers or len(rows.unit) <= _FEW_OBSERVABLES:
        for i, k in enumerate(counted):
            yield "observable", rows.observables[int(k)], np.arange(len(counted)) == i


def _by_condition(context: Context) -> Iterator[_Part]:
    """High pressures of each chamber, bands of the mean pressure, and the direction that most of them came from."""
    rows, x = context.rows, context.rows.fraction
    if context.moves:
        for c, chamber in enumerate(rows.chambers):
            yield "chamber", f"{chamber} above half", x[:, c] > 0.5
    load, mean = x.mean(axis=1), rows.actuation.mean(axis=1)
    if np.ptp(load) > 0:
        band = "pressure band" if rows.by_pressure else "input band"
        for low, high in pairwise(np.quantile(load, [0, 0.25, 0.5, 0.75, 1.0])):
            if not (own := (load >= low) & (load <= high)).any():
                continue  # of two rows no one is in the middle
            yield band, f"{mean[own].min():.3g} to {mean[own].max():.3g} {rows.actuation_unit}", own
    way = np.sign(context.direction[rows.event].sum(axis=1))
    yield "direction", "mostly up", way > 0
    yield "direction", "mostly down", way < 0


def _by_time(context: Context) -> Iterator[_Part]:
    """Thirds of the times in the session and in the hold, and sessions."""
    for group, t in (("time in session", context.session_time_s), ("time in hold", context.elapsed_s)):
        for low, high in pairwise(np.quantile(t, [0, 1 / 3, 2 / 3, 1])):
            if high > low:
                yield group, f"{low:.3g} to {high:.3g} s", (t >= low) & (t <= high)
    for s, name in enumerate(context.rows.sessions):
        yield "session", name, context.rows.session == s


def _by_speed(context: Context) -> Iterator[_Part]:
    """Thirds of the speed of a record's inputs, of several their mean."""
    speed = context.input_speed.mean(axis=1)
    for low, high in pairwise(np.quantile(speed, [0, 1 / 3, 2 / 3, 1])):
        if high > low:
            own = (speed >= low) & (speed <= high)
            yield "input speed", f"{low:.3g} to {high:.3g} {context.rows.actuation_unit}/s", own


def _by_stretch(context: Context) -> Iterator[_Part]:
    """Stretches of a record, as long as each other."""
    t = context.session_time_s
    edges = np.linspace(t.min(), t.max(), _STRETCHES + 1)
    for low, high in pairwise(edges):
        if (own := (t >= low) & (t <= high)).any():
            yield "stretch", f"{low:.3g} to {high:.3g} s", own


def _by_pair(context: Context) -> Iterator[_Part]:
    """High pressures of two neighbouring chambers at once."""
    names, x = context.rows.chambers, context.rows.fraction
    if len(names) < 2 or not context.moves:
        return
    near = overlap(context)
    for i, j in combinations(range(len(names)), 2):
        if near[i, j] > 0:
            yield (
                "pair of chambers",
                f"{names[i]} and {names[j]} above half",
                (x[:, i] > 0.5) & (x[:, j] > 0.5),
            )


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
    found = list(places(context, counted))
    in_group = Counter(place.group for place in found)
    for place in found:
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
    """The worst places first, of some groups only so many."""
    kept: Counter[str] = Counter()
    out = []
    for entry in sorted(entries, key=lambda e: -e["error"]):
        kept[entry["group"]] += 1
        if kept[entry["group"]] <= _KEPT.get(entry["group"], len(entries)):
            out.append(entry)
    return out
