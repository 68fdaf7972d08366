"""Giving a hidden effect a size that means something: mm rms, or multiples of the noise floor."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated._engine import Engine, positions
from labrig_drivers.simulated.hidden import Body, Hidden


@dataclass(frozen=True)
class Programme:
    """A campaign's actuations and the moments at which it is looked at.

    `command_s` (E,), `command_kpa` (E, C), `row_s` (R,) rising, `tilt_deg` (R,) of the base.
    """

    command_s: Floats
    command_kpa: Floats
    row_s: Floats
    tilt_deg: Floats


def run_programme(
    body: Body, hidden: list[Hidden], programme: Programme, growth: float = 0.15
) -> tuple[Floats, Floats]:
    """True pressures (R, C), kPa, and positions (R, M, 3), mm, at the rows of a programme, without noise."""
    for effect in hidden:
        effect.memory = {}
    engine = Engine(body, hidden, growth=growth, longest_step_s=20.0)
    for time_s, pressure_kpa in zip(programme.command_s, programme.command_kpa, strict=True):
        engine.command(time_s, pressure_kpa)
    pressure, deflection = engine.state(programme.row_s)
    return pressure, positions(body, hidden, programme.row_s, programme.tilt_deg, deflection)


def reference_programme(max_kpa: Floats, duration_s: float = 240.0) -> Programme:
    """Sixty random holds, looked at five times each from their middle on: where amplitudes are defined."""
    random = np.random.default_rng(2024)
    hold_s = duration_s / 60
    command_s = np.asarray(np.arange(60) * hold_s, dtype=float)
    row_s = (command_s[:, None] + np.linspace(0.5, 0.97, 5) * hold_s).ravel()
    pressures = random.uniform(0.0, max_kpa, (60, len(max_kpa)))
    return Programme(command_s, pressures, row_s, np.zeros(row_s.size))


def calibrate(
    body: Body,
    effect: Hidden,
    rms_mm: float,
    programme: Programme,
    observed: Callable[[Floats], Floats] | None = None,
    tolerance: float = 0.01,
) -> float:
    """Set `effect.strength` so that it changes the positions by `rms_mm`; returns the rms reached, mm.

    The root mean square is over rows, markers and axes of (with the effect) - (without), both at the same
    programme; `observed` may turn positions (R, M, 3) into other observables first.
    """
    look = observed or (lambda position: position)
    without = look(run_programme(body, [], programme)[1])

    def change_mm(strength: float) -> float:
        effect.strength = strength
        return float(np.sqrt(np.mean((look(run_programme(body, [effect], programme)[1]) - without) ** 2)))

    strength, low, high = effect.natural, 0.0, np.inf
    reached, slope = change_mm(strength), 1.0
    for _ in range(20):
        if abs(reached / rms_mm - 1.0) < tolerance:
            break
        if reached < rms_mm:
            low = strength
        else:
            high = strength
        # a secant on logarithmic scales: most effects follow a power of their strength
        factor = (rms_mm / max(reached, 1e-12)) ** (1.0 / slope)
        following = strength * float(np.clip(factor, 0.1, 10.0))
        if not low < following < high:  # too far from any power: halve the bracket instead
            following = float(np.sqrt(low * high)) if low > 0 else 0.3 * high
        change = change_mm(following)
        if change > 0 and reached > 0:
            slope = float(np.clip(np.log(change / reached) / np.log(following / strength), 0.3, 10.0))
        strength, reached = following, change
    effect.memory = {}
    return reached
