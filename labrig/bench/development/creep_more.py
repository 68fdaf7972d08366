"""Further creep: nonlinear dampers, times that the load sets, flow that does not come back, one chamber alone."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import in_a_minute, lagged, pauses


class FractionalZener(Law):
    """Fractional Zener: the walls yield by a Mittag-Leffler function of time (here by its spectrum of exponentials).

    F. Mainardi, Fractional Calculus and Waves in Linear Viscoelasticity, Imperial College Press, 2010.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        order = setting.random.uniform(0.3, 0.75)
        middle_s = np.exp(setting.random.uniform(np.log(10), np.log(200)))
        tau_s = np.geomspace(0.3, 3e4, 18)
        share = 1 / (np.cosh(order * np.log(tau_s / middle_s)) + np.cos(np.pi * order))
        self._tau_s, self._yields = in_a_minute(tau_s, share)
        self._size = some(setting.random, len(self.rig.chambers), 0.06, 0.16, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class SchaperyCreep(Law):
    """Schapery: the clock of creep runs faster under load, and the load counts more than in proportion.

    R. A. Schapery, On the characterization of nonlinear viscoelastic materials, Polymer Engineering and Science 9,
    1969.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tau_s = np.exp(random.uniform(np.log(15), np.log(300))) * np.array([0.15, 1.0])
        self._yields = random.dirichlet([2.0, 3.0])
        self._hurries = random.uniform(0.8, 2.5)
        self._power = random.uniform(1.0, 1.8)
        self._size = some(random, len(self.rig.chambers), 0.1, 0.25)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = np.maximum(deflection, 0.0)
        runs = pauses(path)[:, None] * np.exp(self._hurries * np.minimum(load, 1.5))
        share = -np.expm1(-runs[:, None] / self._tau_s[:, None])
        pull = load**self._power
        state, late = np.zeros(share.shape[1:]), np.empty_like(deflection)
        for t in range(len(late)):
            state = state + share[t] * (pull[t] - state)
            late[t] = self._yields @ state
        return deflection + strength * self._size * late


class BurgersFlow(Law):
    """Burgers body: a spring beside a damper yields and comes back; a damper in series flows on, and does not.

    I. M. Ward, J. Sweeney, Mechanical Properties of Solid Polymers, 3rd ed., Wiley, 2013.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._tau_s = np.exp(random.uniform(np.log(8), np.log(80), 1))
        flown = _flow(path, self.rig.deflection(path.kpa))
        self._flows = random.uniform(0.3, 0.9) / max(float(flown.max()), 1.0)
        self._size = some(random, len(self.rig.chambers), 0.08, 0.2, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = lagged(path, deflection, self._tau_s)[:, 0] + self._flows * _flow(path, deflection)
        return deflection + strength * self._size * late


class EyringDashpot(Law):
    """Eyring's damper beside a spring: it gives way with the hyperbolic sine of what is left, fast and then hardly.

    G. Halsey, H. J. White, H. Eyring, Mechanical properties of textiles I, Textile Research J. 15, 1945.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._activation = random.uniform(0.06, 0.25)
        self._tau_s = np.exp(random.uniform(np.log(80), np.log(600))) * random.uniform(0.7, 1.4, count)
        self._size = some(random, count, 0.1, 0.3)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        stays, width = np.exp(-pauses(path)[:, None] / self._tau_s), 2 * self._activation
        state, late = np.zeros(deflection.shape[1]), np.empty_like(deflection)
        for t in range(len(late)):
            left = np.clip((deflection[t] - state) / width, -15.0, 15.0)
            state = deflection[t] - width * np.arctanh(np.tanh(left) * stays[t])
            late[t] = state
        return deflection + strength * self._size * late


class NortonDashpot(Law):
    """Norton's damper beside a spring, in one or two chambers: it gives way with a power of what is left.

    F. H. Norton, The Creep of Steel at High Temperatures, McGraw-Hill, 1929.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._power = random.uniform(2.0, 4.0)
        self._tau_s = np.exp(random.uniform(np.log(5), np.log(50)))
        self._size = np.zeros(count)
        self._size[random.permutation(count)[: int(random.integers(1, 3))]] = random.uniform(0.1, 0.3)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load, further = full(self.rig, kpa), self._power - 1
        runs = further * pauses(path) / self._tau_s
        state, late = np.zeros(load.shape[1]), np.empty_like(load)
        for t in range(len(late)):
            left = load[t] - state
            size = np.maximum(np.abs(left), 1e-9)
            state = load[t] - np.sign(left) * size * (1 + runs[t] * size**further) ** (-1 / further)
            late[t] = state
        return kpa + strength * self._size * self.rig.high_kpa * late


class ZenerRelaxation(Law):
    """Standard linear solid: one chamber alone loses a share of its force, or gains way, exponentially under load.

    C. Zener, Elasticity and Anelasticity of Metals, University of Chicago Press, 1948.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        relaxes = any(o.unit == "N" for o in self.rig.observables)
        self._chamber = int(random.integers(len(self.rig.chambers)))
        self._tau_s = np.exp(random.uniform(np.log(10), np.log(120), 1))
        self._size = random.uniform(0.1, 0.3) * (-1.0 if relaxes else 1.0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        own = deflection[:, self._chamber : self._chamber + 1]
        late = lagged(path, own, self._tau_s)[:, 0, 0]
        out = deflection.copy()
        share = strength * self._size
        out[:, self._chamber] += (share if share > 0 else np.expm1(share)) * late
        return out


def _flow(path: Path, deflection: Floats) -> Floats:
    """The time integral (T, C) of what is carried, in s."""
    return np.cumsum(pauses(path)[:, None] * deflection, axis=0)
