"""From a campaign's Dataset to rows: one moment of one hold each.

Holds of hundreds of frames say little more than a few well chosen averages, so each is condensed to a handful of bins,
denser at its beginning where creep and lag live.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig._lost_markers import lost_markers
from labrig.arrays import Floats, Ints
from labrig.effects._as_a_run import REST_OF, as_a_run
from labrig.effects._resolution import levels_of, resolution_of
from labrig.effects._rows import Covariate, Rows, root_mean_square

if TYPE_CHECKING:
    from xarray import Dataset


TRANSIENT_S = 1.0
"""Seconds after an actuation that a quasi-static model says nothing about (valves, inertia)."""
_ROW_BUDGET = 1500
_MAX_BINS, _MIN_BINS = 120, 4


def rows_of(dataset: "Dataset", *, row_budget: int = _ROW_BUDGET) -> Rows:
    """Flatten a campaign (docs/reference/dataset.md) into rows.

    Raises `LabrigError` when it has no capture, or no observable, or is no run otherwise (`as_a_run`).
    """
    dataset = as_a_run(dataset)
    n_captures = dataset.sizes["capture"]
    seen = _observables_of(dataset)
    condensed = _condensed(dataset, seen.values, int(np.clip(row_budget // n_captures, _MIN_BINS, _MAX_BINS)))
    capture = condensed.capture
    commanded = np.asarray(dataset["commanded"].values, float)
    low, high = _limits(dataset, commanded)
    session_names = [str(v) for v in dataset["session"].values]
    event_sessions = [str(v) for v in dataset["event_session"].values]
    sessions = tuple(dict.fromkeys(event_sessions + session_names))
    code = {s: i for i, s in enumerate(sessions)}
    return Rows(
        chambers=tuple(str(v) for v in dataset["chamber"].values),
        actuation_unit=str(dataset["commanded"].attrs.get("units", "")),
        own_units=tuple(map(str, dataset.attrs.get("chamber_units", ()))),
        low=low,
        high=high,
        actuation=commanded[capture],
        measured=condensed.measured,
        values=condensed.values,
        capture=capture,
        session=np.array([code[session_names[c]] for c in capture], dtype=np.int64),
        event=np.asarray(dataset["event_of"].values, dtype=np.int64)[capture],
        hold_s=condensed.hold_s,
        time_s=condensed.time_s,
        event_actuation=np.asarray(dataset["event_commanded"].values, float),
        event_time_s=np.asarray(dataset["event_time_s"].values, float),
        event_session=np.array([code[s] for s in event_sessions], dtype=np.int64),
        sessions=sessions,
        observables=seen.names,
        unit=seen.units,
        marker=seen.marker,
        axis=seen.axis,
        markers=seen.markers,
        rest_mm=_rest_mm(dataset, seen.markers),
        repeat=tuple(str(v) for v in dataset["repeat"].values),
        ruled_out=ruled_out_in(dataset),
        covariates={
            name: Covariate(unit, values)
            for (name, unit), values in zip(_covariates(dataset), condensed.covariates.T, strict=True)
        },
        between_sessions=str(dataset.attrs.get("between_sessions", "unknown")),
        warnings=(*map(str, dataset.attrs.get("warnings", ())), *lost_markers(dataset)),
        start_s=float(dataset.attrs.get("start_s", np.nan)),
        counted=dataset.attrs.get("clock") == "rows",
        resolution=resolution_of(
            seen.values.reshape(-1, seen.values.shape[2]), levels_of(commanded, seen.values.shape[1])
        ),
        session_keys=_keys(sessions, str(dataset.attrs.get("run_id", ""))),
        early=condensed.early,
    )


@dataclass(frozen=True)
class _Observables:
    """What was measured, (captures, times, K): the markers' coordinates, then everything else.

    `marker`, `axis` (K,): the number of its marker and of its axis, -1 of what has none.
    """

    values: Floats
    names: tuple[str, ...]
    units: tuple[str, ...]
    marker: Ints
    axis: Ints
    markers: tuple[str, ...]


def _observables_of(dataset: "Dataset") -> _Observables:
    position, observed = dataset.get("position_mm"), dataset.get("observed")
    if position is None and observed is None:
        raise LabrigError(f"{_where(dataset)}: the run has no observables; name some under 'observables:'")
    blocks: list[Floats] = []
    names: list[str] = []
    units: list[str] = []
    marker: list[int] = []
    axis: list[int] = []
    markers: tuple[str, ...] = ()
    if position is not None:
        markers = tuple(str(m) for m in dataset["marker"].values)
        blocks.append(np.asarray(position.values, float).reshape(*position.shape[:2], -1))
        names += [f"{name}.{letter}" for name in markers for letter in "xyz"]
        units += ["mm"] * len(names)
        marker += np.repeat(np.arange(len(markers)), 3).tolist()
        axis += [0, 1, 2] * len(markers)
    if observed is not None:
        blocks.append(np.asarray(observed.values, float))
        owners = [str(v) for v in dataset["marker_of"].values]
        letters = [str(v) for v in dataset["axis_of"].values]
        markers += tuple(o for o in dict.fromkeys(owners) if o and o not in markers)
        names += [str(v) for v in dataset["observable"].values]
        units += [str(v) for v in dataset["unit"].values]
        marker += [markers.index(o) if o else -1 for o in owners]
        axis += ["xyz".find(a) if a else -1 for a in letters]
    return _Observables(
        values=np.concatenate(blocks, axis=2),
        names=tuple(names),
        units=tuple(units),
        marker=np.array(marker, dtype=np.int64),
        axis=np.array(axis, dtype=np.int64),
        markers=markers,
    )


@dataclass(frozen=True)
class _Condensed:
    """Rows (F,) of all holds that were seen, and how far off each observable (K,) was before them, `early`."""

    capture: Ints
    hold_s: Floats
    time_s: Floats
    values: Floats
    measured: Floats
    covariates: Floats
    early: Floats


def _condensed(dataset: "Dataset", values: Floats, n_bins: int) -> _Condensed:
    """Each hold of `values` (captures, times, K) in at most `n_bins` rows; what else was measured in the same."""
    hold = np.asarray(dataset["hold_s"].values, float)
    time = np.asarray(dataset["time_s"].values, float)
    measured = _extra(dataset, "measured", hold.shape, dataset.sizes["chamber"])
    covariates = _extra(dataset, "covariates", hold.shape, len(_covariates(dataset)))
    seen = np.asarray(np.isfinite(values).any(axis=2))
    capture: list[int] = []
    clocks: list[tuple[float, float]] = []
    middles: list[Floats] = []
    early: list[Floats] = []
    for c in np.flatnonzero(seen.any(axis=1)).tolist():
        index = np.flatnonzero(seen[c])
        together = np.concatenate([values[c], measured[c], covariates[c]], axis=1)
        chunks = _bins(index, hold[c], n_bins)
        early.append(_before(values[c], index, chunks[0][0]))
        capture += [c] * len(chunks)
        clocks += [(_mean(hold[c, chunk]), _mean(time[c, chunk])) for chunk in chunks]
        middles += [_middle(together[chunk]) for chunk in chunks]
    if not capture:
        raise LabrigError(f"{_where(dataset)}: no observable was seen in any capture")
    widths = [values.shape[2], measured.shape[2]]
    of_values, of_measured, of_covariates = np.split(np.array(middles), np.cumsum(widths), axis=1)
    hold_s, time_s = np.array(clocks, float).T
    return _Condensed(
        capture=np.array(capture, dtype=np.int64),
        hold_s=hold_s,
        time_s=time_s,
        values=of_values,
        measured=of_measured,
        covariates=of_covariates,
        early=root_mean_square(np.concatenate(early)),
    )


def _covariates(dataset: "Dataset") -> list[tuple[str, str]]:
    """The name and unit of everything else that was logged."""
    if "covariates" not in dataset:
        return []
    each = zip(dataset["covariate"].values, dataset["covariate_unit"].values, strict=True)
    return [(str(name), str(unit)) for name, unit in each]


def _rest_mm(dataset: "Dataset", markers: Sequence[str]) -> Floats | None:
    """Where markers rest (M, 3); of one of which not all coordinates are measured as far as its observables say it."""
    rest = np.full((len(markers), 3), np.nan)
    if "rest_mm" in dataset:
        rest[: dataset.sizes["marker"]] = dataset["rest_mm"].values
    if all(name in dataset.coords for name in REST_OF):
        places = np.stack([dataset[name].values for name in REST_OF], axis=1)
        for owner, place in zip(dataset["marker_of"].values, places, strict=True):
            if str(owner):
                rest[markers.index(str(owner))] = place
    return rest if np.isfinite(rest).any() else None


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
