"""The rows that every analysis works on: a row is one moment of one hold."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._linalg import sums_of
from labrig._ranges import ends
from labrig.arrays import Floats, Ints


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
