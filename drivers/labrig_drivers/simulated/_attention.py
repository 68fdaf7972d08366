"""Where a quick body is told to look closely: at the shapes that it is held in.

On the way from one set-point to the next a shell's shape comes from its quick stand-in. Once it has been held for
half a second, what the stand-in lacks is faded in, from the shape solved at that set-point; when it leaves, that is
faded out. What is seen depends on commands and times alone, not on who looks when.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden import Body

_FROM_S, _FADE_S = 0.5, 0.5
_LEAVE_S, _LEFT_S = 0.1, 1.0


class ExactBody(Body, Protocol):
    """A body that knows what its quick shapes lack near a set-point."""

    def prepare(self, pressure_kpa: Floats) -> None: ...
    def correction_mm(self, pressure_kpa: Floats, deflection_mm: Floats) -> Floats: ...


def is_exact(body: object) -> bool:
    """Whether a body has corrections."""
    return hasattr(body, "correction_mm")


class Attention:
    """The set-points of a campaign so far, and the corrections they call for."""

    def __init__(self, body: ExactBody) -> None:
        self._body = body
        self._times = [-np.inf]
        self._targets = [np.zeros(len(body.chamber_names))]

    def prepare(self, pressure_kpa: Floats) -> None:
        """Solve the shape at set-points (C,) before it is needed."""
        self._body.prepare(pressure_kpa)

    def command(self, time_s: float, pressure_kpa: Floats) -> None:
        """Set-points (C,), kPa, are held from `time_s` on."""
        self._times.append(time_s)
        self._targets.append(pressure_kpa.copy())

    def correction_mm(self, time_s: Floats, deflection_mm: Floats) -> Floats:
        """What is added to the quick shapes, (F, M, 3) mm, at times (F,) with deflections (F, C)."""
        out = np.zeros((len(time_s), *self._body.rest_mm.shape))
        hold = np.searchsorted(np.array(self._times), time_s, side="right") - 1
        for k in np.unique(hold):
            rows = np.flatnonzero(hold == k)
            here = _held(time_s[rows] - self._times[k])
            self._add(out, rows, here, int(k), deflection_mm)
            rest = 1.0 - here
            for before in range(int(k) - 1, -1, -1):
                left = time_s[rows] - self._times[before + 1]
                if left.min() > _LEFT_S:
                    break
                stayed = _held(np.array([self._times[before + 1] - self._times[before]]))[0]
                self._add(out, rows, rest * stayed * np.exp(-left / _LEAVE_S), before, deflection_mm)
        return out

    def _add(
        self, out: Floats, rows: NDArray[np.int64], share: Floats, hold: int, deflection_mm: Floats
    ) -> None:
        some = share > 1e-4
        if some.any():
            lacking = self._body.correction_mm(self._targets[hold], deflection_mm[rows[some]])
            out[rows[some]] += share[some][:, None, None] * lacking


def _held(since_s: Floats) -> Floats:
    """How closely a hold is looked at: 0 on the way, 1 once it has lasted."""
    x = np.clip((since_s - _FROM_S) / _FADE_S, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)
