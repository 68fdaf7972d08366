"""What a plan does to a rig, moment by moment: the valves' way to each set-point, the holds, the rows."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Path
from labrig.bench._programmes import Plan

VALVE_S = 0.12
"""Time constant of the valves: half a second after an actuation 98 % of the way are gone."""
PAUSE_S = 600.0
"""How long a rig stays vented between a plan and a later one."""
_AFTER_S = np.array([0.0, 0.05, 0.1, 0.2, 0.35, 0.6, 1.0, 1.4])
_LONG_S = 15.0
_MOST_IN_HOLD = 8
_CLOSE_S = 0.02  # moments nearer to a row than this are the row


def make_path(plan: Plan, before: Plan | None = None) -> Path:
    """The path of a plan; with `before`, of that plan, a pause of `PAUSE_S` with the rig vented, and then the plan.

    Only the rows of `plan` are measured, in its order. Its times and sessions then go on from those of `before`.
    """
    begin_s = np.array([t for t, _ in plan.commands])
    target = np.array([p for _, p in plan.commands], dtype=float)
    session = np.array(plan.command_session)
    tilt, payload = np.array(plan.session_tilt_deg), np.array(plan.session_payload_kg)
    row_s = np.repeat(plan.capture_s, [len(r) for r in plan.capture_rows_s]) + np.concatenate(
        plan.capture_rows_s
    )
    end_s = plan.time_s
    if before is not None:
        late_s, sessions = before.time_s + PAUSE_S, before.session + 1
        first = np.array([p for _, p in before.commands], dtype=float)
        begin_s = np.concatenate([[t for t, _ in before.commands], [before.time_s], begin_s + late_s])
        target = np.concatenate([first, np.zeros_like(first[:1]), target])
        session = np.concatenate([before.command_session, [before.session], session + sessions]).astype(int)
        tilt = np.concatenate([before.session_tilt_deg, tilt])
        payload = np.concatenate([before.session_payload_kg, payload])
        row_s, end_s = row_s + late_s, end_s + late_s
    return _path(begin_s, end_s, target, session, tilt, payload, row_s)


def _path(
    begin_s: Floats, end_s: float, target: Floats, session: Ints, tilt: Floats, payload: Floats, row_s: Floats
) -> Path:
    time_s = _moments(begin_s, end_s, row_s)
    event = np.searchsorted(begin_s, time_s, side="right") - 1
    since = time_s - begin_s[event]
    hold_s = np.diff(np.append(begin_s, end_s))
    start = np.zeros_like(target)  # where the chambers are when an actuation begins
    for k in range(1, len(target)):
        start[k] = target[k - 1] + (start[k - 1] - target[k - 1]) * np.exp(-hold_s[k - 1] / VALVE_S)
    left = np.exp(-since / VALVE_S)[:, None]
    first_s = np.array([begin_s[session == s].min() for s in range(int(session.max()) + 1)])
    of = session[event]
    return Path(
        time_s=time_s,
        commanded_kpa=target[event],
        kpa=target[event] + (start[event] - target[event]) * left,
        event=event.astype(np.int64),
        hold_s=since,
        session=of.astype(np.int64),
        session_s=time_s - first_s[of],
        tilt_deg=tilt[of],
        payload_kg=payload[of],
        row=np.searchsorted(time_s, row_s).astype(np.int64),
    )


def _moments(begin_s: Floats, end_s: float, row_s: Floats) -> Floats:
    """All moments in order: a grid after each actuation, log-spaced ones through long holds, and the rows."""
    moments = []
    for start, hold in zip(begin_s, np.diff(np.append(begin_s, end_s)), strict=True):
        grid = _AFTER_S[0.9 * hold > _AFTER_S]
        if hold > _LONG_S:
            grid = np.concatenate([grid, np.geomspace(2.2, hold - 0.3, _MOST_IN_HOLD)])
        moments.append(start + grid)
    grid = np.concatenate(moments)
    ordered = np.sort(row_s)
    after = np.minimum(np.searchsorted(ordered, grid), len(ordered) - 1)
    near = np.minimum(np.abs(ordered[after] - grid), np.abs(ordered[np.maximum(after - 1, 0)] - grid))
    begins = np.isin(grid, begin_s)
    return np.unique(np.concatenate([grid[begins | (near > _CLOSE_S)], row_s]))
