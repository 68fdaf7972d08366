"""Pressure programmes of blind campaigns: what is actuated when, and at which moments it is looked at."""

from dataclasses import dataclass, field

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats

FIRST_ROW_S = 1.6  # by then a chamber has filled through its valve to 2e-5 of the step


@dataclass
class Plan:
    """A programme under construction: one capture for each actuation, and releases between sessions."""

    random: np.random.Generator
    max_kpa: Floats
    time_s: float = 1.0
    session: int = 0
    between_sessions: str = "unknown"
    commands: list[tuple[float, Floats]] = field(default_factory=list)
    command_session: list[int] = field(default_factory=list)
    command_logged: list[bool] = field(default_factory=list)
    capture_s: list[float] = field(default_factory=list)
    capture_kpa: list[Floats] = field(default_factory=list)
    capture_session: list[int] = field(default_factory=list)
    capture_repeat: list[str] = field(default_factory=list)
    capture_rows_s: list[Floats] = field(default_factory=list)
    session_tilt_deg: list[float] = field(default_factory=lambda: [0.0])
    session_payload_kg: list[float] = field(default_factory=lambda: [0.0])
    min_kpa: Floats = field(default_factory=lambda: np.zeros(1))  # broadcast against `max_kpa`

    def capture(self, pressure_kpa: Floats, hold_s: float, rows: int, repeat: str = "") -> None:
        """Actuate, and look at `rows` moments of the hold, evenly spaced or (long holds) in ever longer
        steps.
        """
        if hold_s > 15.0:
            rows_s = np.geomspace(FIRST_ROW_S, hold_s - 0.2, rows)
        else:
            rows_s = np.linspace(FIRST_ROW_S, hold_s - 0.2, rows)
        self._command(pressure_kpa, logged=True)
        self.capture_s.append(self.time_s)
        self.capture_kpa.append(pressure_kpa)
        self.capture_session.append(self.session)
        self.capture_repeat.append(repeat)
        self.capture_rows_s.append(rows_s)
        self.time_s += hold_s

    def next_session(
        self, pause_s: float, vented: bool, tilt_deg: float = 0.0, payload_kg: float = 0.0
    ) -> None:
        """End a session; in between the pressures are vented (no log says so) or held."""
        if vented:
            self._command(np.zeros_like(self.max_kpa), logged=False)
        self.time_s += pause_s
        self.session += 1
        self.session_tilt_deg.append(tilt_deg)
        self.session_payload_kg.append(payload_kg)

    def _command(self, pressure_kpa: Floats, logged: bool) -> None:
        self.commands.append((self.time_s, pressure_kpa))
        self.command_session.append(self.session)
        self.command_logged.append(logged)

    @property
    def captures(self) -> int:
        return len(self.capture_s)


def _set_point(plan: Plan) -> Floats:
    """Anywhere in the box; now and then some chambers are vented or full."""
    random = plan.random
    x = random.uniform(0.0, 1.0, plan.max_kpa.size)
    edge = random.random(plan.max_kpa.size) < 0.15
    return _between(plan, np.where(edge, np.round(x), x))


def _between(plan: Plan, share: Floats) -> Floats:
    """Pressures (C,) at shares (C,) of the way from the lower limits to the upper ones."""
    return plan.min_kpa + (plan.max_kpa - plan.min_kpa) * share


def _one_way(plan: Plan, low: float, high: float) -> Floats:
    """Pressures (C,) of between `low` and `high` of a limit: the upper ones, or by chance lower ones that are not 0."""
    size = plan.random.uniform(low, high, plan.max_kpa.size)
    if not np.any(plan.min_kpa):
        return plan.max_kpa * size
    return np.where(plan.random.random(size.size) < 0.5, plan.min_kpa, plan.max_kpa) * size


def _hold(plan: Plan, long_share: float) -> tuple[float, int]:
    """Length and number of rows of a hold."""
    if plan.random.random() < long_share:
        return float(np.exp(plan.random.uniform(np.log(18.0), np.log(120.0)))), 6
    return float(plan.random.uniform(3.5, 7.0)), 4


def _holds(plan: Plan, count: int, repeats: bool, long_share: float) -> None:
    """Random holds; about one in five belongs to a pair (approach, probe) that comes back again and again."""
    pairs = [(_set_point(plan), _set_point(plan)) for _ in range(4)]
    end = plan.captures + count
    while plan.captures < end:
        if repeats and plan.random.random() < 0.11:
            which = int(plan.random.integers(len(pairs)))
            plan.capture(pairs[which][0], 5.0, 4)
            plan.capture(pairs[which][1], 5.0, 4, repeat=f"r{which + 1}")
        else:
            plan.capture(_set_point(plan), *_hold(plan, long_share))


def _walk(plan: Plan, count: int, repeats: bool, long_share: float) -> None:
    """A few chambers change at a time, so that small reversals abound."""
    here = _set_point(plan)
    probe = (_set_point(plan), _set_point(plan))
    end = plan.captures + count
    while plan.captures < end:
        if repeats and plan.random.random() < 0.08:
            plan.capture(probe[0], 5.0, 4)
            plan.capture(probe[1], 5.0, 4, repeat="r1")
            here = probe[1]
            continue
        chosen = plan.random.permutation(here.size)[: int(plan.random.integers(1, min(3, here.size) + 1))]
        here = here.copy()
        anywhere = np.zeros(here.size)
        anywhere[chosen] = plan.random.uniform(0.0, 1.0, chosen.size)
        here[chosen] = _between(plan, anywhere)[chosen]
        plan.capture(here, *_hold(plan, long_share))


def _sweeps(plan: Plan, count: int, repeats: bool, long_share: float) -> None:
    """Staircases up and down along random directions; with repeats, each of the first ones comes twice."""
    end = plan.captures + count
    kept: list[tuple[str, Floats]] = []
    number = 0
    while plan.captures < end:
        if repeats and kept and plan.random.random() < 0.3:
            name, top = kept[int(plan.random.integers(len(kept)))]
        else:
            number += 1
            name, top = f"s{number}", _set_point(plan) * (plan.random.random(plan.max_kpa.size) < 0.7)
            if len(kept) < 4:
                kept.append((name, top))
        levels = [0.0, 0.25, 0.5, 0.75, 1.0, 0.8, 0.55, 0.3, 0.0]
        turn = plan.random.uniform(0.3, 0.7)
        if number % 2:
            levels = [0.0, 0.5, 1.0, turn_level(turn), 0.9, 0.6, 0.2, 0.0]
        for step, level in enumerate(levels):
            label = f"{name}.{number % 2}.{step}" if repeats and name in dict(kept) else ""
            plan.capture(top * level, *_hold(plan, long_share), repeat=label if level > 0 else "")


def turn_level(turn: float) -> float:
    """The level at which a sweep turns back for a while, on a coarse scale."""
    return float(np.round(turn, 1))


_ONE_SESSION = {"holds": _holds, "walk": _walk, "sweeps": _sweeps}
DESIGNS = ("holds", "walk", "sweeps", "sessions")
CONFOUNDED_DESIGNS = ("one_hold", "one_level")


def make_plan(
    design: str,
    random: np.random.Generator,
    max_kpa: Floats,
    captures: int,
    repeats: bool = True,
    tilted: bool = False,
    long_share: float = 0.12,
    loaded: bool = False,
    min_kpa: Floats | None = None,
) -> Plan:
    """A plan of about `captures` captures between the limits (C,), the lower ones zero unless there is `min_kpa`.

    From session to session `tilted` turns the base, and `loaded` hangs weights on.

    Designs: holds, walk, sweeps, sessions (three or four of those, minutes apart); and two that cannot tell
    some effects apart: one_hold (a single actuation watched for long), and one_level (one set of pressures,
    on and off, in holds of one length).
    """
    high = np.asarray(max_kpa, dtype=float)
    plan = Plan(random, high, min_kpa=np.zeros_like(high) if min_kpa is None else np.asarray(min_kpa, float))
    if design in _ONE_SESSION and not (tilted or loaded):
        _ONE_SESSION[design](plan, captures, repeats, long_share)
    elif design == "sessions" or design in _ONE_SESSION:
        _sessions(plan, design, captures, repeats, long_share, tilted, loaded)
    elif design == "one_hold":
        _one_hold(plan, captures)
    elif design == "one_level":
        top = _one_way(plan, 0.5, 0.9)
        while plan.captures < captures:
            plan.capture(top, 6.0, 4, repeat="on")
            plan.capture(0.0 * top, 6.0, 4, repeat="off")
    else:
        raise LabrigError(
            f"bench: there is no design '{design}' (known: {', '.join(DESIGNS + CONFOUNDED_DESIGNS)})"
        )
    return plan


def _sessions(
    plan: Plan, design: str, captures: int, repeats: bool, long_share: float, tilted: bool, loaded: bool
) -> None:
    random = plan.random
    count = int(random.integers(3, 5))
    plan.between_sessions = str(random.choice(["vented", "held", "unknown"]))
    vented = {"vented": True, "held": False}.get(plan.between_sessions, bool(random.random() < 0.5))
    for session in range(count):
        part = design if design in _ONE_SESSION else str(random.choice(list(_ONE_SESSION)))
        _ONE_SESSION[part](plan, max(captures // count, 8), repeats, long_share)
        if session + 1 < count:
            tilt = float(random.choice([30.0, 60.0, 90.0, -45.0])) if tilted else 0.0
            payload = float(random.choice([0.02, 0.05, 0.1, 0.2])) if loaded else 0.0
            plan.next_session(float(random.uniform(300.0, 2400.0)), vented, tilt, payload)


def _one_hold(plan: Plan, captures: int) -> None:
    """All captures belong to one actuation: nothing but time passes."""
    top = _one_way(plan, 0.4, 0.9)
    plan.capture(top, 6.0, 4)
    began_s = plan.capture_s[0]
    for k in range(1, captures):
        plan.capture_s.append(began_s)
        plan.capture_kpa.append(top)
        plan.capture_session.append(0)
        plan.capture_repeat.append("")
        plan.capture_rows_s.append(6.0 * k + np.linspace(1.6, 5.8, 4))
    plan.time_s = began_s + 6.0 * captures
