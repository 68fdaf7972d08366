"""How pressures and deflections evolve: one hold after another, on a time grid that is fine after each
command.

Between commands everything changes ever more slowly, so the grid's steps grow in proportion to the time
since the command; what is asked for in between is interpolated. The grid depends on the commands alone,
never on who looks when, so that a campaign is the same however often it is polled.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden import Body, Hidden

VALVE_S = 0.15  # time constant of a chamber filling through its valve
_KEPT_ROWS = 400_000


def _grid(growth: float, longest_step_s: float) -> Floats:
    """Times since a command: 10 ms at first, then growing by `growth`, up to `longest_step_s`; one day in
    all.
    """
    times = [0.01]
    while times[-1] * growth < longest_step_s:
        times.append(times[-1] + max(0.01, growth * times[-1]))
    steady = np.arange(times[-1] + longest_step_s, 86_400.0, longest_step_s)
    return np.concatenate([times, steady])


class Engine:
    """Chamber pressures and deflections of one body over time, with its hidden effects.

    Times are seconds since the start of the campaign and must not decrease from one `command` to the next;
    `state` may be asked for any time back to the start (of the last 400,000 grid rows).
    """

    def __init__(
        self, body: Body, hidden: Sequence[Hidden], growth: float = 0.08, longest_step_s: float = 2.0
    ) -> None:
        chambers = len(body.chamber_names)
        self.body = body
        self.hidden = tuple(hidden)
        self._since = _grid(growth, longest_step_s)
        self._time_s = 0.0  # up to here everything is settled
        self._since_s = 0.0  # the same, since the last command
        self._command_s = 0.0
        self._done = 0  # grid rows of this hold that are behind us
        self._line_kpa = np.zeros(chambers)  # what the valve holds the line at
        self._target_kpa = np.zeros(chambers)
        self._rows = 1
        self._times = np.zeros(1024)
        self._pressures = np.zeros((1024, chambers))
        self._deflections = np.zeros((1024, chambers))

    def command(self, time_s: float, pressure_kpa: ArrayLike) -> None:
        """Go to other set-points (C,), kPa, from `time_s` on."""
        time_s = max(float(time_s), self._time_s)
        self._settle(time_s)
        if time_s > self._time_s:
            self._append(*self._advance(np.array([time_s])))
        target = np.asarray(pressure_kpa, dtype=float).copy()
        for effect in self.hidden:
            target = effect.set_point(target)
        self._target_kpa = target
        self._command_s, self._since_s, self._done = time_s, 0.0, 0

    def state(self, time_s: ArrayLike) -> tuple[Floats, Floats]:
        """Chamber pressures, kPa, and deflections, mm, each (F, C), at times (F,)."""
        asked = np.atleast_1d(np.asarray(time_s, dtype=float))
        last = float(asked.max())
        self._settle(last)
        rows = self._rows
        if last > self._times[rows - 1]:
            before = self._remember()
            self._append(*self._advance(np.array([last])))
            found = self._interpolate(asked)
            self._recall(before)
            self._rows = rows
            return found
        return self._interpolate(asked)

    def _settle(self, until_s: float) -> None:
        """Compute all grid rows of the present hold up to `until_s`."""
        end = int(np.searchsorted(self._since, until_s - self._command_s + 1e-12, side="right"))
        if end > self._done:
            times = self._command_s + self._since[self._done : end]
            self._done = end
            self._append(*self._advance(times))

    def _advance(self, times: Floats) -> tuple[Floats, Floats, Floats]:
        steps = np.diff(times, prepend=self._time_s)
        since = times - self._command_s
        decay = np.exp(-(since - self._since_s) / VALVE_S)[:, None]
        line = self._target_kpa + (self._line_kpa - self._target_kpa) * decay
        self._line_kpa, self._time_s, self._since_s = line[-1], float(times[-1]), float(since[-1])
        pressure = line
        for effect in self.hidden:
            pressure = effect.line(since, steps, pressure)
        load = pressure
        for effect in self.hidden:
            load = effect.load(steps, load)
        deflection = self.body.deflection_mm(load)
        for effect in self.hidden:
            deflection = effect.deflect(times, steps, deflection)
        return times, pressure, deflection

    def _append(self, times: Floats, pressures: Floats, deflections: Floats) -> None:
        if self._rows > _KEPT_ROWS:
            half = self._rows // 2
            for rows in (self._times, self._pressures, self._deflections):
                rows[: self._rows - half] = rows[half : self._rows].copy()
            self._rows -= half
        end = self._rows + len(times)
        if end > len(self._times):
            more = max(end, 2 * len(self._times))
            self._times = np.resize(self._times, more)
            self._pressures = np.resize(self._pressures, (more, self._pressures.shape[1]))
            self._deflections = np.resize(self._deflections, (more, self._deflections.shape[1]))
        self._times[self._rows : end] = times
        self._pressures[self._rows : end] = pressures
        self._deflections[self._rows : end] = deflections
        self._rows = end

    def _interpolate(self, asked: Floats) -> tuple[Floats, Floats]:
        known = self._times[: self._rows]
        right = np.clip(np.searchsorted(known, asked, side="left"), 1, max(self._rows - 1, 1))
        left = right - 1
        if self._rows == 1:
            right = left
        width = known[right] - known[left]
        part = np.clip(
            np.where(width > 0, (asked - known[left]) / np.where(width > 0, width, 1.0), 1.0), 0.0, 1.0
        )
        part = part[:, None]
        return tuple(x[left] + part * (x[right] - x[left]) for x in (self._pressures, self._deflections))  # type: ignore[return-value]

    def _remember(self) -> tuple:
        memories = [dict(effect.memory) for effect in self.hidden]
        return self._time_s, self._since_s, self._done, self._line_kpa, memories

    def _recall(self, before: tuple) -> None:
        self._time_s, self._since_s, self._done, self._line_kpa, memories = before
        for effect, memory in zip(self.hidden, memories, strict=True):
            effect.memory = memory


def positions(
    body: Body,
    hidden: Sequence[Hidden],
    time_s: Floats,
    tilt_deg: Floats,
    deflection_mm: Floats,
) -> Floats:
    """What is seen, mm, (F, M, 3), of a body with deflections (F, C) at times (F,) on a base tilted by (F,)
    degrees.
    """
    return seen_positions(body.shape_mm(deflection_mm), hidden, time_s, tilt_deg, deflection_mm)


def seen_positions(
    shape_mm: Floats, hidden: Sequence[Hidden], time_s: Floats, tilt_deg: Floats, deflection_mm: Floats
) -> Floats:
    """What is seen, mm, (F, M, 3), of true shapes (F, M, 3) with deflections (F, C) at times (F,)."""
    seen = shape_mm
    for effect in hidden:
        seen = effect.see(time_s, tilt_deg, deflection_mm, seen)
    return seen
