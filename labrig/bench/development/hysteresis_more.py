"""Further hysteresis: loops that are not symmetric, that widen with the load, or that lie in the skin."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some, span
from labrig.bench.development._story import finely, plays, steps


class GeneralisedPlay(Law):
    """Generalised play: the two curves between which each wall's inner part rests part from each other under load.

    M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis, Springer, 1989.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._rising = random.uniform(0.03, 0.08, count), random.uniform(0.1, 0.4, count)
        self._falling = random.uniform(0.03, 0.08, count), random.uniform(0.05, 0.3, count)
        self._share = some(random, count, 0.3, 0.7, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.abs(deflection)
        low = deflection - self._rising[0] - self._rising[1] * size
        high = deflection + self._falling[0] + self._falling[1] * size
        state, inner = np.zeros(deflection.shape[1]), np.empty_like(deflection)
        for t in range(len(inner)):
            state = np.minimum(np.maximum(state, low[t]), high[t])
            inner[t] = state
        return deflection + strength * self._share * (inner - deflection)


class ModifiedPrandtlIshlinskii(Law):
    """Modified Prandtl-Ishlinskii: plays, and behind them dead zones of one side, so that loops are fat at one end.

    K. Kuhnen, Modeling, identification and compensation of complex hysteretic nonlinearities: a modified
    Prandtl-Ishlinskii approach, European J. Control 9, 2003.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        widths = np.linspace(0.02, 0.3, 5)
        self._half_width = widths[:, None] * random.uniform(0.7, 1.3, count)
        self._weight = random.dirichlet(np.full(5, 2.0))
        self._from = np.array([0.25, 0.5, 0.75])
        self._bends = random.uniform(-0.25, 1.2, 3)
        self._share = some(random, count, 0.15, 0.4, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        behind = np.einsum("tnc,n->tc", plays(load, self._half_width), self._weight)
        change = self._bent(behind) - self._bent(load)
        return kpa + strength * self._share * self.rig.high_kpa * change

    def _bent(self, load: Floats) -> Floats:
        return load + np.maximum(load[..., None] - self._from, 0.0) @ self._bends


class ColemanHodgdon(Law):
    """Coleman-Hodgdon: the part that lags is fed by the motion, more of it at high load, and fades as motion goes on.

    B. D. Coleman, M. L. Hodgdon, A constitutive relation for rate-independent hysteresis in ferromagnetically soft
    materials, Int. J. Engineering Science 24, 1986.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._fades = random.uniform(2.5, 8.0, count)
        self._more = random.uniform(0.5, 3.0)
        self._fed = some(random, count, 0.15, 0.35)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        move = steps(deflection)
        stays = np.exp(-self._fades * np.abs(move))
        middle = np.abs(deflection - 0.5 * move)
        fed = self._fed * (1 + self._more * middle) * np.sign(move) * (1 - stays) / self._fades
        state, late = np.zeros(deflection.shape[1]), np.empty_like(deflection)
        for t in range(len(late)):
            state = state * stays[t] + fed[t]
            late[t] = state
        return deflection - strength * late


class JilesAtherton(Law):
    """Jiles-Atherton: pinned parts follow the curve without hysteresis only as far as the load drags them along.

    D. C. Jiles, D. L. Atherton, Theory of ferromagnetic hysteresis, J. Magnetism and Magnetic Materials 61, 1986.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._knee = random.uniform(0.15, 0.5, count)
        self._pinned = random.uniform(0.08, 0.3, count)
        self._share = some(random, count, 0.2, 0.45)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        moves, _, keep = finely(path, load, 0.05)
        free = _langevin(np.cumsum(moves, axis=0) / self._knee) / _langevin(1 / self._knee)
        follows = -np.expm1(-np.abs(moves) / self._pinned)
        way, state = np.sign(moves), np.zeros(load.shape[1])
        late = np.empty_like(moves)
        for t in range(len(moves)):
            ahead = free[t] - state
            state = state + follows[t] * np.where(ahead * way[t] > 0, ahead, 0.0)
            late[t] = state
        change = (late - free)[keep]
        return kpa + strength * self._share * self.rig.high_kpa * change


class DuhemLoop(Law):
    """Semilinear Duhem: a restoring force grows and turns exponentially, along another scale up than down.

    J. Oh, D. S. Bernstein, Semilinear Duhem model for rate-independent and rate-dependent hysteresis, IEEE Trans.
    Automatic Control 50, 2005.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._up = random.uniform(0.15, 0.5, count)
        self._down = self._up * random.uniform(0.4, 1.0)
        self._held = some(random, count, 0.06, 0.14)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        move = steps(deflection)
        way = np.sign(move)
        stays = np.exp(-np.abs(move) / np.where(move > 0, self._up, self._down))
        state, out = np.zeros(deflection.shape[1]), np.empty_like(deflection)
        for t in range(len(out)):
            state = way[t] + (state - way[t]) * stays[t]
            out[t] = state
        return deflection - strength * self._held * out


class FoamBacking(Law):
    """Generalised Prandtl-Ishlinskii in the skin: each observable lags behind plays of its own, up to a saturation.

    M. Al Janaideh, S. Rakheja, C.-Y. Su, A generalized Prandtl-Ishlinskii model for characterizing the hysteresis and
    saturation nonlinearities of smart actuators, Smart Materials and Structures 18, 2009.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.observables)
        size = span(self.rig)
        self._full = size * random.uniform(1.5, 4.0)
        widths = np.array([0.08, 0.2, 0.4, 0.7]) * size / self._full
        self._half_width = widths[:, None] * random.uniform(0.8, 1.2, count)
        self._weight = random.dirichlet(np.full(4, 2.0))
        self._share = random.uniform(0.15, 0.4)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        envelope = np.tanh((values - self.rig.at_rest) / self._full)
        behind = np.einsum("tnk,n->tk", plays(envelope, self._half_width), self._weight)
        return values + strength * self._share * self._full * (behind - envelope)


def _langevin(x: Floats) -> Floats:
    """coth x - 1 / x, as a series near zero."""
    near = np.abs(x) < 1e-2
    safe = np.where(near, 1.0, x)
    return np.where(near, x / 3, 1 / np.tanh(safe) - 1 / safe)
