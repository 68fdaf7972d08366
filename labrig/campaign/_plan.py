"""What a run is going to do: every step, when, how long it takes, and which limits it would break."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypedDict

import numpy as np

from labrig._errors import LabrigError
from labrig._seed import whole_seed
from labrig.arrays import Floats
from labrig.campaign._advice import Adviser
from labrig.campaign._execute import execute, limit_errors
from labrig.campaign._observe import Observation
from labrig.campaign._procedure import Procedure, RigInfo
from labrig.campaign._session import Control, Session
from labrig.campaign._signals import SignalGuard
from labrig.campaign._steps import Actuate, Record, Result, Step
from labrig.campaign._walk import ProcedureError, Walk
from labrig.rig import Rig, RigConfig
from labrig_drivers import (
    Channel,
    Identity,
    MarkerFrame,
    PressureSample,
    Scan,
    SimulatedClock,
    VentReport,
    one_target,
)

_DRY_TICK_S = 0.25
_VENT_S = 1.0
_SCAN_S = 20.0
_RAMP_TICKS = 20
"""So many set-points are sent at most on the way to one."""
_NEAR_S = 1.0
"""Before the end of a wait the ideal devices are asked as on a real rig, s; the rest of it is skipped."""
_LONGEST_S = 366 * 24 * 3600.0
"""A plan that takes longer is a slip: a time in another unit."""
_MOST_STEPS = 1_000_000
MOST_SET_POINTS = 100_000
"""What a plan may have at most: at a second each more than a day."""


class PlanFacts(TypedDict):
    """What must be the same when a run is resumed."""

    procedure: str
    parameters: dict[str, Any]
    seed: int
    rig_name: str
    limits: list[Any]
    markers: list[str]
    steps_sha256: str


@dataclass
class Plan:
    """The steps of a run with their start times, s from its start; broken limits; the time it all takes.

    `stopped` says why the procedure could not be followed to its end on an ideal rig, where every set-point is
    reached at once and the markers stay at rest; None if it could. `may_refuse` is what the pressure controller may
    refuse once it has answered; empty where nothing is.
    """

    steps: list[Step] = field(default_factory=list)
    start_s: list[float] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    duration_s: float = 0.0
    stopped: str | None = None
    may_refuse: str = ""

    @property
    def captures(self) -> int:
        """How many recordings there are."""
        return sum(isinstance(step, Record) for step in self.steps)


def rig_info(config: RigConfig, seed: int = 0) -> RigInfo:
    """What a procedure may know of a rig."""
    return RigInfo(config.name, config.channels, config.markers, config.scanner is not None, whole_seed(seed))


def dry_run(procedure: Procedure, config: RigConfig, seed: int = 0, adviser: Adviser | None = None) -> Plan:
    """Follow a procedure on a simulated clock and an ideal rig; nothing moves, broken limits are collected.

    An `adviser` is not asked: what it could add is checked when it does. Raises `LabrigError` for a plan of more than
    100,000 set-points, before it is made where the procedure says how many it has.
    """
    info = rig_info(config, seed)
    _check_size(procedure, procedure.set_points(info))
    clock = SimulatedClock(0.0)
    mocap = _IdealMocap(config, clock) if config.mocap is not None else None
    rig = Rig(config, clock, _IdealPressure(config, clock), mocap, _IdealScanner(clock))
    session = _DrySession(rig, None, Observation([]), SignalGuard(), Control(), _DRY_TICK_S)
    plan, actuated = Plan(), 0
    refused, certain = one_target(config.pressure.kind, config.pressure.options, config.channels)

    def carry_out(index: int, step: Step) -> Result:
        nonlocal actuated
        if index >= _MOST_STEPS:
            raise LabrigError(f"more than {_MOST_STEPS} steps; does the procedure ever end?")
        actuated += isinstance(step, Actuate)
        _check_size(procedure, actuated)
        plan.steps.append(step)
        plan.start_s.append(clock.now_s())
        broken = limit_errors(step, config)
        if isinstance(step, Actuate) and not broken and (line := refused(np.array(step.pressure_kpa))):
            if certain:
                broken = [line]
            else:
                plan.may_refuse = plan.may_refuse or f"step {index} ({step.kind}): {line}"
        plan.broken += [f"step {index} ({step.kind}): {error}" for error in broken]
        if broken and isinstance(step, Actuate):
            step = Actuate(_into_limits(step, config))
        session.begin_step(step, index)
        return execute(session, step)[0]

    walk = Walk(procedure, info, adviser)
    try:
        walk.run(carry_out, lambda: None)
    except ProcedureError as error:
        plan.stopped = str(error)
        if not procedure.closed_loop:
            raise
    finally:
        walk.close()
    plan.duration_s = clock.now_s()
    if plan.duration_s > _LONGEST_S:
        name, days = procedure.procedure_name(), plan.duration_s / 86400.0
        raise LabrigError(
            f"{name}: it would take {days:.3g} days, and a run may take a year at most; give shorter times, "
            "which are in seconds"
        )
    return plan


def _check_size(procedure: Procedure, count: float) -> None:
    if count > MOST_SET_POINTS:
        name = procedure.procedure_name()
        raise LabrigError(
            f"{name}: more than {MOST_SET_POINTS} set-points; ask for fewer, or measure in several runs"
        )


class _DrySession(Session):
    """Waits in one go where nothing can happen meanwhile."""

    def wait_until(self, time_s: float) -> None:
        """Ask the ideal devices now, and at the end of the wait."""
        self.poll()
        if (skipped_s := time_s - _NEAR_S - self.clock.now_s()) > 0:
            self.clock.sleep(skipped_s)
        super().wait_until(time_s)

    def ramp_tick_s(self, target_kpa: Floats) -> float:
        """The slower the way, the fewer its steps: nothing happens on it."""
        slew_kpa_s = np.array([chamber.slew_kpa_s for chamber in self.rig.config.chambers])
        way_s = float(np.max(np.abs(target_kpa - self.commanded_kpa) / slew_kpa_s))
        return max(self.tick_s, way_s / _RAMP_TICKS)


def _into_limits(step: Actuate, config: RigConfig) -> tuple[float, ...]:
    wanted = [*step.pressure_kpa, *[0.0] * len(config.chambers)][: len(config.chambers)]
    low, high = [c.min_kpa for c in config.chambers], [c.max_kpa for c in config.chambers]
    return tuple(np.clip(np.nan_to_num(wanted), low, high).tolist())


def plan_facts(procedure: Procedure, config: RigConfig, seed: int, plan: Plan) -> PlanFacts:
    """What must be the same when a run is resumed, as plain values."""
    return {
        "procedure": procedure.procedure_name(),
        "parameters": procedure.model_dump(mode="json"),
        "seed": seed,
        "rig_name": config.name,
        "limits": [chamber.model_dump(mode="json") for chamber in config.chambers],
        "markers": list(config.markers),
        "steps_sha256": _steps_sha256(procedure, plan),
    }


def plan_sha256(procedure: Procedure, config: RigConfig, seed: int, plan: Plan) -> str:
    """A name for a plan: another one where the procedure, a parameter, the rig, the seed or a step is another one."""
    return sha256_of(plan_facts(procedure, config, seed, plan))


def _steps_sha256(procedure: Procedure, plan: Plan) -> str:
    """A hash of the steps themselves; of a closed loop only its name, for its steps depend on measurements."""
    steps = [] if procedure.closed_loop else [step.to_dict() for step in plan.steps]
    return sha256_of([procedure.procedure_name(), steps])


def sha256_of(values: Any) -> str:
    """The hash of plain values."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


class _Ideal:
    name = "ideal"

    def connect(self) -> None:
        """Nothing to open."""

    def close(self) -> None:
        """Nothing to release."""

    def identify(self) -> Identity:
        """An ideal device."""
        return Identity(self.name, "ideal", "exists in a dry run only")


class _IdealPressure(_Ideal):
    """Reaches every set-point at once."""

    def __init__(self, config: RigConfig, clock: SimulatedClock) -> None:
        self.channels: Sequence[Channel] = config.channels
        self._clock = clock
        self._pressure_kpa = np.zeros(len(self.channels))

    def set(self, pressure_kpa: Any) -> None:
        self._pressure_kpa = np.array(pressure_kpa, float)

    def samples(self) -> list[PressureSample]:
        return [PressureSample(self._clock.now_s(), self._pressure_kpa)]

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        self._clock.sleep(min(_VENT_S, timeout_s))
        self._pressure_kpa = np.zeros(len(self.channels))
        return VentReport(self._pressure_kpa, _VENT_S)


class _IdealMocap(_Ideal):
    """Sees every marker at rest."""

    def __init__(self, config: RigConfig, clock: SimulatedClock) -> None:
        self.marker_names: Sequence[str] = config.markers
        rest = config.rest_mm or {}
        self._position_mm = np.array([rest.get(name, (0.0, 0.0, 0.0)) for name in config.markers], float)
        self._position_mm = self._position_mm.reshape(-1, 3)
        self._clock = clock
        self._number = 0

    def frames(self) -> list[MarkerFrame]:
        self._number += 1
        status = np.zeros(len(self.marker_names), np.int8)
        return [MarkerFrame(self._clock.now_s(), self._number, self._position_mm, status)]


class _IdealScanner(_Ideal):
    """Delivers one triangle after a while."""

    def __init__(self, clock: SimulatedClock) -> None:
        self._clock = clock

    def scan(self, timeout_s: float = 120.0) -> Scan:
        self._clock.sleep(min(_SCAN_S, timeout_s))
        return Scan(self._clock.now_s(), np.zeros((3, 3)), np.array([[0, 1, 2]]), (), "")
