"""The rows that every analysis works on: a campaign's Dataset, flattened and its holds condensed.

A row is one moment of one hold. Holds of hundreds of frames say little more than a few well chosen
averages, so each is condensed to a handful of bins, denser at its beginning where creep and lag live.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig._linalg import sums_of
from labrig._lost_markers import lost_markers
from labrig._ranges import ends
from labrig.arrays import Floats, Ints
from labrig.effects._resolution import levels_of, resolution_of

if TYPE_CHECKING:
    from xarray import Dataset


TRANSIENT_S = 1.0
"""Seconds after an actuation that a quasi-static model says nothing about (valves, inertia)."""

_ROW_BUDGET = 1500
_MAX_BINS, _MIN_BINS = 120, 4


@dataclass(frozen=True)
class Covariate:
    """Something else that was logged with the rows: values (F,), NaN where it was not."""

    unit: str
    values: Floats


_PRESSURES = {"kPa", "Pa", "MPa", "hPa", "bar", "mbar", "psi", "torr", "mmHg", "inHg", "atm"}


@dataclass(frozen=True)
class Rows:
    """A campaign as F rows of K observables under C chambers, with its E actuations.

    Shapes: `actuation`, `measured` (F, C); `values` (F, K), NaN where not seen; `capture`, `session`,
    `event` (F,) indices; `hold_s`, `time_s` (F,), NaN where unknown; `event_actuation` (E, C),
    `event_time_s`, `event_session` (E,); `low`, `high` (C,) limits of the actuation; `unit`, `marker`,
    `axis` (K,), the last two -1 where an observable is no marker's; `rest_mm` (M, 3) or None;
    `repeat` (captures,) labels; `resolution` (K,) the step in which an observable was recorded, 0 where there is none
    to be seen; `early` (K,) how far those rows of the first second that are left out lie from the rest of their holds,
    root mean square; `session_keys` (sessions,) names of the sessions that are no other run's, where the
    run has an identity; `start_s` when the run began, by a clock that runs of one rig share, or NaN; `goes_on` are the
    sessions that begin with what the one before has left, vented meanwhile.
    """

    chambers: tuple[str, ...]
    actuation_unit: str
    low: Floats
    high: Floats
    actuation: Floats
    measured: Floats
    values: Floats
    capture: Ints
    session: Ints
    event: Ints
    hold_s: Floats
    time_s: Floats
    event_actuation: Floats
    event_time_s: Floats
    event_session: Ints
    sessions: tuple[str, ...]
    observables: tuple[str, ...]
    unit: tuple[str, ...]
    marker: Ints
    axis: Ints
    markers: tuple[str, ...]
    rest_mm: Floats | None
    repeat: tuple[str, ...]
    covariates: dict[str, Covariate]
    between_sessions: str
    warnings: tuple[str, ...] = ()
    start_s: float = float("nan")
    session_keys: tuple[str, ...] = ()
    resolution: Floats = field(default_factory=lambda: np.zeros(0))
    early: Floats = field(default_factory=lambda: np.zeros(0))
    goes_on: tuple[int, ...] = ()
    own_units: tuple[str, ...] = ()
    """Of each input its unit, where they differ."""
    counted: bool = False
    """Whether no column was a clock, so that rows are taken as 1 s apart."""
    ruled_out: tuple[frozenset[str], ...] = ()
    """Of each capture the effects that somebody saw to it cannot act in it; empty where none is in any."""

    @property
    def n_captures(self) -> int:
        """How many captures there are."""
        return len(self.repeat)

    @cached_property
    def first(self) -> Ints:
        """The first row of each capture that has any, (n,)."""
        return np.unique(self.capture, return_index=True)[1]

    @property
    def owner(self) -> Ints:
        """The number of each observable's marker, (K,); one that is no marker's has a number of its own, after."""
        return np.where(self.marker >= 0, self.marker, len(self.markers) + np.arange(len(self.marker)))

    @property
    def by_pressure(self) -> bool:
        """Whether what is commanded is a pressure, so that a chamber at zero is vented."""
        return self.actuation_unit in _PRESSURES

    @property
    def origin(self) -> Floats:
        """Where each chamber's range begins; see `ends`."""
        return ends(self.low, self.high)[0]

    @property
    def span(self) -> Floats:
        """From there to the other limit, (C,); negative where a chamber is filled by vacuum."""
        return ends(self.low, self.high)[1]

    @property
    def fraction(self) -> Floats:
        """Actuation as a fraction of each chamber's range, shape (F, C)."""
        return self.share(self.actuation)

    def share(self, actuation: Floats) -> Floats:
        """Any actuation (..., C) as a fraction of each chamber's range."""
        origin, span = ends(self.low, self.high)
        return (actuation - origin) / span

    def thin(self, keep: NDArray[Any]) -> "Rows":
        """Keep some rows (a mask or indices); events and captures stay, so that history stays whole."""
        names = ("actuation", "measured", "values", "capture", "session", "event", "hold_s", "time_s")
        changed: dict[str, Any] = {name: getattr(self, name)[keep] for name in names}
        changed["covariates"] = {
            name: replace(cov, values=cov.values[keep]) for name, cov in self.covariates.items()
        }
        return replace(self, **changed)


def rows_of(dataset: "Dataset", *, row_budget: int = _ROW_BUDGET) -> Rows:
    """Flatten a campaign (docs/reference/dataset.md) into rows.

    Raises `LabrigError` when it has no capture, or no observable.
    """
    position = dataset.get("position_mm")
    observed = dataset.get("observed")
    n_captures = dataset.sizes.get("capture", 0)
    if n_captures == 0:
        raise LabrigError(f"{_where(dataset)}: the run has no captures; nothing can be compared")
    if position is None and observed is None:
        raise LabrigError(f"{_where(dataset)}: the run has no observables; name some under 'observables:'")

    hold = np.asarray(dataset["hold_s"].values, float)
    time = np.asarray(dataset["time_s"].values, float)
    blocks: list[Floats] = []
    names: list[str] = []
    units: list[str] = []
    marker_of: list[int] = []
    axis_of: list[int] = []
    markers: tuple[str, ...] = ()
    if position is not None:
        markers = tuple(str(m) for m in dataset["marker"].values)
        blocks.append(np.asarray(position.values, float).reshape(*hold.shape, -1))
        for m, marker in enumerate(markers):
            for a, axis in enumerate("xyz"):
                names.append(f"{marker}.{axis}")
                units.append("mm")
                marker_of.append(m)
                axis_of.append(a)
    if observed is not None:
        blocks.append(np.asarray(observed.values, float))
        owners = [str(v) for v in dataset["marker_of"].values]
        letters = [str(v) for v in dataset["axis_of"].values]
        markers += tuple(o for o in dict.fromkeys(owners) if o and o not in markers)
        names += [str(v) for v in dataset["observable"].values]
        units += [str(v) for v in dataset["unit"].values]
        marker_of += [markers.index(o) if o else -1 for o in owners]
        axis_of += ["xyz".find(a) if a else -1 for a in letters]
    values = np.concatenate(blocks, axis=2)

    measured_all = _extra(dataset, "measured", hold.shape, dataset.sizes["chamber"])
    covariate_names = [str(v) for v in dataset["covariate"].values] if "covariates" in dataset else []
    covariates_all = _extra(dataset, "covariates", hold.shape, len(covariate_names))
    seen = np.asarray(np.isfinite(values).any(axis=2))
    n_bins = int(np.clip(row_budget // n_captures, _MIN_BINS, _MAX_BINS))

    picked: dict[str, list[Any]] = {n: [] for n in ("capture", "hold", "time", "all", "early")}
    for c in range(n_captures):
        index = np.flatnonzero(seen[c])
        if not len(index):
            continue
        together = np.concatenate([values[c], measured_all[c], covariates_all[c]], axis=1)
        chunks = _bins(index, hold[c], n_bins)
        picked["early"].append(_before(values[c], index, chunks[0][0]))
        for chunk in chunks:
            picked["capture"].append(c)
            picked["hold"].append(_mean(hold[c, chunk]))
            picked["time"].append(_mean(time[c, chunk]))
            picked["all"].append(_middle(together[chunk]))
    if not picked["capture"]:
        raise LabrigError(f"{_where(dataset)}: no observable was seen in any capture")

    capture = np.array(picked["capture"], dtype=np.int64)
    commanded = np.asarray(dataset["commanded"].values, float)
    event_of = np.asarray(dataset["event_of"].values, dtype=np.int64)
    low, high = _limits(dataset, commanded)
    session_names = [str(v) for v in dataset["session"].values]
    event_sessions = [str(v) for v in dataset["event_session"].values]
    sessions = tuple(dict.fromkeys(event_sessions + session_names))
    code = {s: i for i, s in enumerate(sessions)}
    widths = [values.shape[2], measured_all.shape[2]]
    observed_rows, measured_rows, cov = np.split(np.array(picked["all"]), np.cumsum(widths), axis=1)
    rest = np.full(
        (len(markers), 3), np.nan
    )  # nobody knows it of a marker of which not all coordinates are there
    if "rest_mm" in dataset:
        rest[: dataset.sizes["marker"]] = dataset["rest_mm"].values
    return Rows(
        chambers=tuple(str(v) for v in dataset["chamber"].values),
        actuation_unit=str(dataset["commanded"].attrs.get("units", "")),
        own_units=tuple(map(str, dataset.attrs.get("chamber_units", ()))),
        low=low,
        high=high,
        actuation=commanded[capture],
        measured=measured_rows,
        values=observed_rows,
        capture=capture,
        session=np.array([code[session_names[c]] for c in capture], dtype=np.int64),
        event=event_of[capture],
        hold_s=np.array(picked["hold"], float),
        time_s=np.array(picked["time"], float),
        event_actuation=np.asarray(dataset["event_commanded"].values, float),
        event_time_s=np.asarray(dataset["event_time_s"].values, float),
        event_session=np.array([code[s] for s in event_sessions], dtype=np.int64),
        sessions=sessions,
        observables=tuple(names),
        unit=tuple(units),
        marker=np.array(marker_of, dtype=np.int64),
        axis=np.array(axis_of, dtype=np.int64),
        markers=markers,
        rest_mm=rest if np.isfinite(rest).any() else None,
        repeat=tuple(str(v) for v in dataset["repeat"].values),
        ruled_out=ruled_out_in(dataset),
        covariates={
            name: Covariate(str(unit), cov[:, i])
            for i, (name, unit) in enumerate(
                zip(covariate_names, dataset["covariate_unit"].values if covariate_names else [], strict=True)
            )
        },
        between_sessions=str(dataset.attrs.get("between_sessions", "unknown")),
        warnings=(*map(str, dataset.attrs.get("warnings", ())), *lost_markers(dataset)),
        start_s=float(dataset.attrs.get("start_s", np.nan)),
        counted=dataset.attrs.get("clock") == "rows",
        resolution=resolution_of(values.reshape(-1, values.shape[2]), levels_of(commanded, hold.shape[1])),
        session_keys=_keys(sessions, str(dataset.attrs.get("run_id", ""))),
        early=root_mean_square(np.concatenate(picked["early"])),
    )


def ruled_out_in(dataset: "Dataset") -> tuple[frozenset[str], ...]:
    """Of each capture the effects that were ruled out in it; empty where none was in any."""
    if "ruled_out" not in dataset.coords:
        return ()
    return tuple(frozenset(str(text).split()) for text in dataset["ruled_out"].values)


def _keys(sessions: Sequence[str], run: str) -> tuple[str, ...]:
    """Sessions that are only counted (0, 1, ...) are told from those of another run by the run."""
    return tuple(f"{run[:8]}/{name}" if run and name.isdigit() else name for name in sessions)


def _where(dataset: "Dataset") -> str:
    return str(dataset.attrs.get("run", "run"))


def _extra(dataset: "Dataset", name: str, shape: tuple[int, ...], width: int) -> Floats:
    if name not in dataset:
        return np.full((*shape, width), np.nan)
    return np.asarray(dataset[name].values, float)


def _limits(dataset: "Dataset", commanded: Floats) -> tuple[Floats, Floats]:
    low = np.asarray(dataset["chamber_min"].values, float).copy()
    high = np.asarray(dataset["chamber_max"].values, float).copy()
    low = np.where(np.isfinite(low), low, np.minimum(0.0, commanded.min(axis=0)))
    high = np.where(np.isfinite(high), high, np.maximum(0.0, commanded.max(axis=0)))
    return low, np.where(high > low, high, low + np.maximum(1.0, np.abs(low)))


def _bins(index: Ints, hold_s: Floats, n_bins: int) -> list[Ints]:
    """Drop the transient and split one hold into at most `n_bins` runs of rows."""
    t = hold_s[index]
    if len(index) <= 2 or not np.isfinite(t).all() or t[-1] <= t[0]:
        if len(index) <= n_bins:
            return [np.array([i]) for i in index]
        return np.array_split(index, n_bins)
    begin = min(TRANSIENT_S, t[0] + (t[-1] - t[0]) / 3)
    kept = index[t >= begin - 1e-9]
    t = hold_s[kept]
    if len(kept) <= n_bins:
        return [np.array([i]) for i in kept]
    floor = max(t[0], 1e-3)
    log_edges = np.geomspace(floor, t[-1], n_bins // 2 + 1)
    edges = np.unique(np.concatenate([log_edges, np.linspace(floor, t[-1], n_bins - n_bins // 2 + 1)]))
    place = np.clip(np.searchsorted(edges, t, side="right") - 1, 0, len(edges) - 2)
    return [kept[place == b] for b in np.unique(place)]


def _before(values: Floats, seen: Ints, begin: int) -> Floats:
    """How far rows that were seen before `begin` lie from the middle of those after, (n, K)."""
    rest = values[seen[seen >= begin]]
    usual = np.array([_mean(column) for column in rest.T])
    return values[seen[seen < begin]] - usual


def capture_means(values: Floats, capture: NDArray[Any]) -> tuple[Floats, Ints]:
    """Mean of each capture over its rows (F, ...) -> (n, ...), NaN where nothing was seen; and the captures, sorted."""
    captures, index = np.unique(capture, return_inverse=True)
    seen = np.isfinite(values)
    total, count = (
        sums_of(index, v, len(captures)) for v in (np.where(seen, values, 0.0), seen.astype(float))
    )
    return np.where(count > 0, total / np.maximum(count, 1), np.nan), captures


def root_mean_square(values: Floats) -> Floats:
    """Root mean square of what was seen in each column; 0 where nothing was."""
    count = np.isfinite(values).sum(axis=0)
    return np.sqrt(np.nansum(values**2, axis=0) / np.maximum(count, 1))


def _mean(x: Floats) -> float:
    good = x[np.isfinite(x)]
    return float(good.mean()) if len(good) else float("nan")


def _middle(x: Floats) -> Floats:
    """Per column: the median of five or more rows (spikes don't move it), else the mean; NaN if unseen."""
    if len(x) == 1:
        return x[0]
    seen = np.where(np.isfinite(x), x, np.nan)
    count = np.isfinite(x).sum(axis=0)
    ordered = np.sort(seen, axis=0)  # what was not seen stands behind
    column = np.arange(x.shape[1])
    lower, upper = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(x) - 1)
    out = 0.5 * (ordered[lower, column] + ordered[upper, column])
    few = (count > 0) & (count < 5)
    if few.any():
        out[few] = np.nanmean(seen[:, few], axis=0)
    return out
