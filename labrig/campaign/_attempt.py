"""One step, taken again where the pressures did not follow, as the rig's `follow` section says."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from labrig.campaign._execute import execute
from labrig.campaign._follow import Miss, misses, reached_kpa
from labrig.campaign._session import Session
from labrig.campaign._steps import Completed, Record, Recording, Result, Scan, Scanned, Step
from labrig.run_contents import StepResult
from labrig_drivers import DeviceError


@dataclass(frozen=True)
class Attempt:
    """What becomes of a step: `done` with its result, and what of it goes into the log."""

    done: Completed
    logged: StepResult


def attempt(
    session: Session, index: int, step: Step, again: Callable[[Step], None], pause: Callable[[], None]
) -> Attempt:
    """Carry out step `index`; a capture whose pressures did not follow is taken again, or does not count.

    `again` vents the chambers and brings them back to where they were before the step; `pause` vents and returns
    when a person wants to go on. Raises `DeviceError` when the pressures still do not follow and the run may not go
    on.
    """
    policy, left = session.rig.config.follow, session.rig.config.follow.repeats
    while True:
        started_s = session.now_s()
        session.begin_step(step, index)
        session.step_message(Completed(index, step, None, started_s), "STARTED")
        result, logged = execute(session, step)
        missed = _misses(session, step)
        if isinstance(step, Record | Scan):
            commanded = np.asarray(session.commanded_kpa, float).tolist()
            logged["commanded_kpa"] = commanded
            logged["reached_kpa"] = reached_kpa(session.held.samples, len(commanded))
        done = Completed(index, step, result, started_s, session.now_s())
        if not missed:
            return Attempt(done, logged)
        logged["missed"] = [miss.chamber for miss in missed]
        text = "; ".join(map(str, missed))
        if left == 0 and policy.on_miss == "skip":
            session.event(f"step {index}: {text}: the capture does not count", "WARNING")
            return Attempt(replace(done, result=_marked(result, missed)), logged)
        session.step_message(done, "FAILED", logged)
        if left > 0:
            left -= 1
            session.event(f"step {index}: {text}: taking the capture again", "WARNING")
        elif policy.on_miss == "pause" and session.control.attended:
            session.event(f"step {index}: {text}: check its tube, valve and sensor", "WARNING")
            pause()
            left = policy.repeats
        else:
            raise DeviceError(f"{session.rig.pressure.name}: {text}; check its tube, valve and sensor")
        again(step)


def _misses(session: Session, step: Step) -> list[Miss]:
    if not isinstance(step, Record | Scan):
        return []
    sag = isinstance(step, Record) and step.sag
    return misses(session.held.samples, session.commanded_kpa, session.rig.config, sag=sag)


def _marked(result: Result, missed: list[Miss]) -> Result:
    names = tuple(miss.chamber for miss in missed)
    return replace(result, missed=names) if isinstance(result, Recording | Scanned) else result
