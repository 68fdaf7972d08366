"""Captures and actuations of imported files put together into the Dataset of a campaign."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.log._dataset import rest_coordinates
from labrig.log._part import Part
from labrig.tables import Mapping, Observable, is_length

if TYPE_CHECKING:
    from xarray import Dataset


_JITTER = 0.05
"""A file in which an input moves by less than this part of its size, or of what it does in all files, is held."""


class _Gathered:
    """Rows, captures and events of all files, one after the other, as lists of arrays."""

    def __init__(self) -> None:
        self.rows: dict[str, list[Any]] = {}
        self.captures: dict[str, list[Any]] = {}
        self.events: dict[str, list[Any]] = {}
        self.n_captures = self.n_events = 0

    def add(self, part: Part, session: NDArray[np.object_], span: Floats) -> None:
        """Take in one file."""
        starts = part.starts
        lengths = np.diff(np.r_[starts, part.n])
        block = np.repeat(np.arange(len(starts)), lengths)
        known = np.logical_and.reduceat(np.isfinite(part.hold_s), starts)
        begin = part.time_s[starts] - np.where(known, part.hold_s[starts], 0.0)
        seen = np.isfinite(part.values).any(axis=1)
        recorded = np.logical_or.reduceat(seen, starts) & np.logical_or.reduceat(part.keep, starts)
        if part.file.events:
            number = part.capture[starts]
            allowed = np.array([True, *(e.record for e in part.file.events)])
            recorded &= allowed[number]
        u = _held_at(part.actuation, starts, lengths)
        changed = np.r_[True, _moves(u, span)]
        is_event = recorded | changed | (lengths > 1) | np.logical_or.reduceat(part.keep, starts)
        event_of = np.cumsum(is_event) - 1 + self.n_events
        capture_of = np.cumsum(recorded) - 1 + self.n_captures
        rows = recorded[block] & part.keep
        hold = np.where(known[block], part.hold_s, part.time_s - part.time_s[starts][block])
        _append(
            self.rows,
            capture=capture_of[block][rows],
            time_s=part.time_s[rows],
            hold_s=hold[rows],
            values=part.values[rows],
            measured=part.measured[rows],
            covariates=part.covariates[rows],
        )
        _append(
            self.captures,
            commanded=u[recorded],
            event_of=event_of[recorded],
            session=session[starts][recorded],
            repeat=part.repeat[starts][recorded],
            segment=part.segment[starts][recorded],
        )
        _append(self.events, time_s=begin[is_event], commanded=u[is_event], session=session[starts][is_event])
        self.n_events += int(is_event.sum())
        self.n_captures += int(recorded.sum())


def _append(to: dict[str, list[Any]], **parts: Any) -> None:
    for name, values in parts.items():
        to.setdefault(name, []).append(values)


def _moves(u: Floats, span: Floats) -> NDArray[np.bool_]:
    """Where an input (n, C) changes from one capture to the next, (n-1,); jitter of one that is held is no change.

    `span` (C,) is what the input goes over in all files.
    """
    held = np.ptp(u, axis=0) <= _JITTER * np.maximum(np.abs(u).max(axis=0), span)
    return ((u[1:] != u[:-1]) & ~held).any(axis=1)


def _held_at(actuation: Floats, starts: Ints, lengths: Ints) -> Floats:
    """The mean actuation of each capture, (captures, C); exactly its value where it does not change."""
    low, high = np.minimum.reduceat(actuation, starts), np.maximum.reduceat(actuation, starts)
    mean = np.add.reduceat(actuation, starts) / lengths[:, None]
    return np.where(low == high, low, mean)


def gather(mapping: Mapping, parts: Sequence[Part]) -> "Dataset":
    """The campaign of some files, laid out as docs/reference/dataset.md says.

    Raises `LabrigError` where no row has an observable that is a number.
    """
    gathered = _Gathered()
    many = len({s for p in parts for s in set(p.session)}) < sum(len(set(p.session)) for p in parts)
    span = np.ptp(np.concatenate([p.actuation for p in parts]), axis=0)
    for number, part in enumerate(parts):
        session = part.session
        if many and mapping.session is None:
            session = np.array([f"{s}#{number + 1}" for s in session], dtype=object)
        gathered.add(part, session, span)
    if gathered.n_captures == 0:
        raise LabrigError(f"{parts[0].table.path}: no row has an observable that is a number")
    rows, captures, events = (
        {name: np.concatenate(values) for name, values in each.items()}
        for each in (gathered.rows, gathered.captures, gathered.events)
    )
    return _dataset(mapping, parts[0].observables, rows, captures, events)


def _dataset(
    mapping: Mapping,
    observables: Sequence[Observable],
    rows: dict[str, np.ndarray],
    captures: dict[str, np.ndarray],
    events: dict[str, np.ndarray],
) -> "Dataset":
    import xarray as xr

    n = len(captures["session"])
    of = rows["capture"]
    starts = np.flatnonzero(np.r_[True, np.diff(of) != 0])
    place = np.arange(len(of)) - np.repeat(starts, np.diff(np.r_[starts, len(of)]))

    def padded(values: Floats) -> Floats:
        out = np.full((n, int(place.max()) + 1, *values.shape[1:]), np.nan)
        out[of, place] = values
        return out

    commanded = captures["commanded"]
    hold = padded(rows["hold_s"])
    data: dict[str, object] = {
        "commanded": (("capture", "chamber"), commanded, {"units": _unit(mapping)}),
        "measured": (("capture", "time", "chamber"), padded(rows["measured"])),
        "hold_s": (("capture", "time"), hold),
        "time_s": (("capture", "time"), padded(rows["time_s"])),
        "settled": (("capture", "time"), np.isfinite(hold)),
        "event_time_s": (("event",), events["time_s"]),
        "event_commanded": (("event", "chamber"), events["commanded"]),
    }
    limit = {"min": np.minimum(0.0, commanded.min(axis=0)), "max": commanded.max(axis=0)}
    coords: dict[str, object] = {
        "capture": np.arange(n),
        "chamber": [a.name for a in mapping.actuation],
        "session": ("capture", captures["session"].astype(str)),
        "repeat": ("capture", captures["repeat"].astype(str)),
        "event_of": ("capture", captures["event_of"]),
        "event_session": ("event", events["session"].astype(str)),
    }
    if any(captures["segment"]):
        coords["segment"] = ("capture", captures["segment"].astype(str))
    for side in ("min", "max"):
        given = [getattr(a, side) for a in mapping.actuation]
        coords[f"chamber_{side}"] = (
            "chamber",
            np.array([limit[side][c] if v is None else v for c, v in enumerate(given)], dtype=float),
        )
    _observables(mapping, observables, padded(rows["values"]), data, coords)
    if mapping.covariates:
        data["covariates"] = (("capture", "time", "covariate"), padded(rows["covariates"]))
        coords["covariate"] = [e.name for e in mapping.covariates]
        coords["covariate_unit"] = ("covariate", [e.unit for e in mapping.covariates])
    attrs: dict[str, object] = {"source": "table", "between_sessions": mapping.between_sessions}
    own = [each.unit for each in mapping.actuation]
    if len(set(own)) > 1:
        attrs["chamber_units"] = own
    return xr.Dataset(data, coords=coords, attrs=attrs)  # type: ignore[arg-type]


def _observables(
    mapping: Mapping,
    observables: Sequence[Observable],
    values: Floats,
    data: dict[str, object],
    coords: dict[str, object],
) -> None:
    """Markers with all three axes become `position_mm`; everything else stays an observable, with where its marker is
    at rest as far as the mapping says that.
    """
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
        places = [rest[o.marker].rest if o.marker in rest else None for o in chosen]
        if any(place is not None for place in places):
            coords.update(rest_coordinates([place or (np.nan,) * 3 for place in places]))


def _unit(mapping: Mapping) -> str:
    """The unit of what is commanded; of several inputs in different units all of them: kPa or mm."""
    return " or ".join(dict.fromkeys(each.unit for each in mapping.actuation))
