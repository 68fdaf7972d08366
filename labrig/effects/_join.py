"""Several runs of one rig as one campaign."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.effects._rows import Covariate, Rows, root_mean_square

_TOGETHER = "they can't be diagnosed together"
_AGAIN = f"{_TOGETHER}; import one of them again, with `scale` and `unit` as the other has them"
_SAME = {
    "chambers": f"chambers: {_TOGETHER}",
    "observables": f"observables: {_TOGETHER}",
    "unit": f"units of the observables: {_AGAIN}",
    "actuation_unit": f"units of the actuation: {_AGAIN}",
    "own_units": f"units of the actuation: {_AGAIN}",
}
"""What has to be the same in all runs, and what is said where it is not."""


def join_rows(parts: Sequence[Rows], *, remembers: bool = True) -> Rows:
    """Put several runs of one rig one after the other; each keeps its own sessions and repeats.

    Where all of them know when they began, and none began before the one before it ended, their times go on; else each
    is taken to begin as the one before it ends. Of a rig that is vented in between, and whose runs know when they
    began, each remembers what it did in those before, unless it is said not to.

    Raises `LabrigError` when the runs have other chambers or observables.
    """
    first = parts[0]
    if len(parts) == 1:
        return first
    for part in parts[1:]:
        for name, words in _SAME.items():
            if getattr(part, name) != getattr(first, name):
                raise LabrigError(f"the runs differ in their {words}")
    later, known = _later(parts)
    follows = remembers and known and all(p.between_sessions == "vented" for p in parts)
    if follows:
        parts = [*map(_vented, parts[:-1]), parts[-1]]
    captures = np.cumsum([0, *(p.n_captures for p in parts)])
    events = np.cumsum([0, *(len(p.event_time_s) for p in parts)])
    session = np.cumsum([0, *(len(p.sessions) for p in parts)])
    joined: dict[str, Any] = {f.name: getattr(first, f.name) for f in fields(Rows)}
    for name in ("actuation", "measured", "values", "hold_s", "event_actuation"):
        joined[name] = np.concatenate([getattr(p, name) for p in parts])
    goes_on = [s + first for p, first in zip(parts, session.tolist(), strict=False) for s in p.goes_on]
    joined["goes_on"] = tuple(sorted([*goes_on, *(session[1:-1].tolist() if follows else [])]))
    joined["time_s"] = np.concatenate([p.time_s + late for p, late in zip(parts, later, strict=True)])
    joined["event_time_s"] = np.concatenate(
        [p.event_time_s + late for p, late in zip(parts, later, strict=True)]
    )
    offsets = {"capture": captures, "session": session, "event": events, "event_session": session}
    for name, offset in offsets.items():
        joined[name] = np.concatenate([getattr(p, name) + o for p, o in zip(parts, offset[:-1], strict=True)])
    joined["sessions"] = tuple(f"{i + 1}:{s}" for i, p in enumerate(parts) for s in p.sessions)
    joined["resolution"] = np.max([p.resolution for p in parts], axis=0)
    joined["early"] = root_mean_square(np.array([p.early for p in parts]))
    joined["session_keys"] = tuple(key for p in parts for key in p.session_keys or p.sessions)
    joined["repeat"] = tuple(f"{i + 1}:{r}" if r else "" for i, p in enumerate(parts) for r in p.repeat)
    if any(p.ruled_out for p in parts):
        of_none = (frozenset[str](),)
        joined["ruled_out"] = tuple(r for p in parts for r in p.ruled_out or of_none * p.n_captures)
    joined["counted"] = any(p.counted for p in parts)
    joined["low"] = np.min([p.low for p in parts], axis=0)
    joined["high"] = np.max([p.high for p in parts], axis=0)
    joined["covariates"], left_out = _logged_together(parts)
    joined["warnings"] = (*(w for p in parts for w in p.warnings), *left_out)
    return Rows(**joined)


def _logged_together(parts: Sequence[Rows]) -> tuple[dict[str, Covariate], list[str]]:
    """What all of several runs logged beside, one after the other; and a line on each that some of them did not log."""
    out, lines = {}, []
    for name in dict.fromkeys(n for p in parts for n in p.covariates):
        own = [p.covariates[name] for p in parts if name in p.covariates]
        if len(own) < len(parts):
            lines.append(f"{name} was logged in {len(own)} of the {len(parts)} runs: nothing follows it")
            continue
        if len(units := dict.fromkeys(each.unit for each in own)) > 1:
            raise LabrigError(
                f"the runs have {name!r} in {' and in '.join(units)}: import them again with it in one unit"
            )
        out[name] = Covariate(own[0].unit, np.concatenate([each.values for each in own]))
    return out, lines


def _later(parts: Sequence[Rows]) -> tuple[list[float], bool]:
    """How long after the first run each began, s, and whether that is known: else one after the other, as given."""
    took = [float(np.nanmax(p.time_s, initial=0.0)) for p in parts]
    later = [p.start_s - parts[0].start_s for p in parts]
    ends = [late + own for late, own in zip(later, took, strict=True)]
    if all(np.isfinite(later)) and all(start >= end for start, end in zip(later[1:], ends, strict=False)):
        return later, later[-1] > 0
    return [0.0, *np.cumsum(took[:-1]).tolist()], False


def _vented(rows: Rows) -> Rows:
    """A run with its end as one more event: there every chamber is vented."""
    end = np.nanmax(np.concatenate([rows.time_s, rows.event_time_s]))
    return replace(
        rows,
        event_actuation=np.vstack([rows.event_actuation, np.clip(0.0, rows.low, rows.high)]),
        event_time_s=np.append(rows.event_time_s, end),
        event_session=np.append(rows.event_session, rows.event_session[-1]),
    )
