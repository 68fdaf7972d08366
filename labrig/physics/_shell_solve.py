"""Equilibrium: Newton's method until the forces are nearly balanced, then L-BFGS on the factor that is left.

Every step lowers the energy: directions that do not are shortened, and a factorisation that fails is made
convex, or shifted, until it does.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import get_lapack_funcs

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.physics._shell_system import System

Solve = Callable[[Floats], Floats]

_factor_single, _solve_single = get_lapack_funcs(("pbtrf", "pbtrs"), dtype=np.float32)
_factor_double, _solve_double = get_lapack_funcs(("pbtrf", "pbtrs"), dtype=np.float64)

TOLERANCE = 1e-5
"""Unbalanced force over the force of the air, at which a shape is an equilibrium."""
_NEARLY = 0.03
"""The same, at which Newton's factor is good enough for L-BFGS."""
_LEAST_LOAD = 0.02
"""The force of the air is taken as at least this part of that at full pressure."""
_LONGEST_MM = 25.0
_STIFFEST = 1e12
_NEWTON_STEPS, _QUASI_STEPS = 60, 300
_MEMORY, _PATIENCE, _EXPECTED = 12, 8, 0.1
"""L-BFGS: vectors kept; after so many steps the force should have fallen to this part, or a new factor is made."""


@dataclass
class Descent:
    """Where a search stands: coordinates, energy, gradient, and every energy on the way."""

    x: Floats
    energy: float
    gradient: Floats
    energies: list[float]
    steps: int = 0

    @property
    def force(self) -> float:
        """Norm of the unbalanced force."""
        return float(np.linalg.norm(self.gradient))


def reference_force(system: System, pressure_kpa: Floats, max_kpa: Floats) -> float:
    """Norm of the force of the air on the resting shape, with a floor; what residuals are measured in."""
    force, most = (float(np.linalg.norm(system.push_at_rest @ p)) for p in (pressure_kpa, max_kpa))
    return max(force, _LEAST_LOAD * most)


def minimise(system: System, field: Floats, start: Floats, target: float, scale: float) -> Descent:
    """Descend from `start` until the force is below `target` (or until nothing helps: see `Descent.force`)."""
    band = np.empty((system.size, system.bandwidth + 1))
    energy, gradient = system.energy(start, field)
    at = Descent(start.copy(), energy, gradient, [energy])
    convex, shift = True, 0.0
    near = max(_NEARLY * scale, target)
    solve: Solve | None = None
    while at.steps < _NEWTON_STEPS and (at.force > near or solve is None) and at.force > target:
        system.second(at.x, field, band, convex)
        solve, convex, shift = _factor(system, at.x, field, band, convex, shift)
        step = -solve(at.gradient)
        length = _move(system, field, at, step)
        if length == 0.0:
            if convex and shift > 1e3:
                return at
            convex, shift = True, max(8.0 * shift, 0.4)
            continue
        shift = 0.0 if shift < 0.15 else 0.2 * shift
        convex = length < 1.0
    if at.force > target and solve is not None:
        _finish(system, field, at, target, solve, band)
    return at


def _move(system: System, field: Floats, at: Descent, step: Floats) -> float:
    """Go along `step` as far as the energy falls; returns the part that was gone, 0 for none."""
    at.steps += 1
    slope = float(at.gradient @ step)
    part = min(1.0, _LONGEST_MM / max(float(np.abs(step).max()), 1e-300))
    if not slope < 0.0:
        return 0.0
    force = at.force
    while part > 1e-4:
        x = at.x + part * step
        energy, gradient = system.energy(x, field)
        falls = energy <= at.energy + 1e-4 * part * slope
        level = energy <= at.energy + system.rounding and np.linalg.norm(gradient) < force
        if np.isfinite(energy) and (falls or level):
            at.x, at.energy, at.gradient = x, energy, gradient
            at.energies.append(energy)
            return part
        part *= 0.5
    return 0.0


def _factor(
    system: System, x: Floats, field: Floats, band: Floats, convex: bool, shift: float, double: bool = False
) -> tuple[Solve, bool, float]:
    """A Cholesky factor, in single precision or `double`, of what `band` holds, made convex or shifted if it must
    be.
    """
    added = 0.0
    while True:
        if shift > added:
            band[:, 0] += (shift - added) * system.mass
            added = shift
        if double:
            factor, fault = _factor_double(band.T, lower=1)
        else:
            factor, fault = _factor_single(band.T.astype(np.float32), lower=1, overwrite_ab=1)
        if fault == 0:
            return _applied(factor, double), convex, shift
        if not convex:
            convex, added = True, 0.0
            system.second(x, field, band, True)
        elif shift > _STIFFEST:
            raise LabrigError(
                "the stiffness of a shell is not finite: are its parameters, or its start, far off?"
            )
        else:
            shift = max(4.0 * shift, 0.4)


def _applied(factor: Floats, double: bool) -> Solve:
    if double:
        return lambda v: _solve_double(factor, v, lower=1)[0]
    return lambda v: _solve_single(factor, v.astype(np.float32), lower=1)[0].astype(float)


def _finish(system: System, field: Floats, at: Descent, target: float, solve: Solve, band: Floats) -> None:
    """L-BFGS whose first approximation is the inverse that `solve` applies; a new one when it stalls, from the
    second on in double precision.
    """
    steps: list[Floats] = []
    turns: list[Floats] = []
    since, mark, renewed = 0, at.force, 0
    for _ in range(_QUASI_STEPS):
        if at.force <= target:
            return
        before_x, before_gradient = at.x, at.gradient
        length = _move(system, field, at, -_two_loops(at.gradient, steps, turns, solve))
        if length > 0.0:
            s, y = at.x - before_x, at.gradient - before_gradient
            if s @ y > 1e-10 * np.linalg.norm(s) * np.linalg.norm(y):
                steps, turns = [*steps[1 - _MEMORY :], s], [*turns[1 - _MEMORY :], y]
            since += 1
        stalled = since >= _PATIENCE and at.force > _EXPECTED * mark
        if length == 0.0 or stalled:
            if length == 0.0 and since == 0 and renewed > 3:
                return
            convex = length == 0.0 or renewed % 2 == 1
            system.second(at.x, field, band, convex)
            solve, _, _ = _factor(system, at.x, field, band, convex, 0.0, double=renewed > 0)
            steps, turns, renewed = [], [], renewed + 1
            since, mark = 0, at.force
        elif since >= _PATIENCE:
            since, mark = 0, at.force


def _two_loops(gradient: Floats, steps: list[Floats], turns: list[Floats], solve: Solve) -> Floats:
    q = gradient.copy()
    parts = []
    for s, y in zip(reversed(steps), reversed(turns), strict=True):
        part = (s @ q) / (s @ y)
        q -= part * y
        parts.append(part)
    r = solve(q)
    for s, y, part in zip(steps, turns, reversed(parts), strict=True):
        r += s * (part - (y @ r) / (s @ y))
    return r


def respond(system: System, x: Floats, field: Floats, loads: Floats) -> Floats:
    """How the equilibrium x moves under small additional forces (D, n): (D, n), mm, by the exact stiffness."""
    band = np.empty((system.size, system.bandwidth + 1))
    system.second(x, field, band, False)
    factor, fault = _factor_double(band.T, lower=1)
    if fault == 0:
        return _solve_double(factor, np.asfortranarray(loads), lower=1)[0]
    from scipy.linalg import solve_banded

    width = system.bandwidth  # a stable equilibrium may still look unstable without the moments' own share
    full = np.zeros((2 * width + 1, system.size))
    full[width:] = band.T
    for k in range(1, width + 1):
        full[width - k, k:] = band[:-k, k]
    return solve_banded((width, width), full, loads, overwrite_ab=True)
