"""Creep of the eighth portion: one delay, a power of time, yarns, thin places, and a tape over a seam."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, columns, full, some
from labrig.bench.development._story import as_chain, lagged, pauses


class OneVoigtElement(Law):
    """One Voigt element: a share of the wall's deflection comes late, as a spring beside a dashpot, and goes late.

    I. M. Ward, J. Sweeney, Mechanical Properties of Solid Polymers, Wiley, 2013.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._share = random.uniform(0.1, 0.2) * random.uniform(0.8, 1.2, count)
        self._tau_s = np.exp(random.uniform(np.log(15.0), np.log(150.0))) * random.uniform(0.9, 1.1, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection + strength * self._share * lagged(path, deflection, self._tau_s[None])[:, 0]


class NuttingLaw(Law):
    """Nutting's law: the strain goes with a power of the time and a power of the stress; loads superpose.

    P. G. Nutting, A new general law of deformation, Journal of the Franklin Institute 191, 1921. All are alike.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        time_s = np.geomspace(1.0, 5000.0, 60)
        self._tau_s, self._yields = as_chain(time_s ** random.uniform(0.15, 0.45), time_s)
        self._power = random.uniform(1.0, 1.6)
        self._share = random.uniform(0.08, 0.16)  # in a minute at full pressure

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        stress = np.sign(load) * np.abs(load) ** self._power
        crept = np.einsum("tnc,n->tc", lagged(path, stress, self._tau_s), self._yields)
        return deflection + strength * self._share * crept


class UnconditionedYarn(Law):
    """Unconditioned yarn: new fibres stretch for good under each load that they have not yet borne for long enough.

    H. Leaderman, Elastic and Creep Properties of Filamentous Materials and Other High Polymers, Textile Foundation,
    1943. Secondary creep does not recover; once conditioned by a load, yarn bears it without more of it.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._stretches = some(random, count, 0.15, 0.3, 0.7)
        self._tau_s = np.exp(random.uniform(np.log(20.0), np.log(150.0)))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        pull = self._stretches * full(self.rig, kpa)
        aim = np.maximum(
            np.stack([pull, -pull], axis=1), 0.0
        )  # yarns that pressure pulls, and those that vacuum does
        share = -np.expm1(-pauses(path) / self._tau_s)
        gone = np.zeros(aim.shape[1:])
        out = np.empty_like(aim)
        for i in range(len(aim)):
            gone = gone + share[i] * np.maximum(aim[i] - gone, 0.0)
            out[i] = gone
        return deflection + strength * (out[:, 0] - out[:, 1])


class ThinPlacesCreep(Law):
    """Thin places creep: the body creeps where its wall came out thin, at two times, and hardly where it is thick.

    W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials, North-Holland, 1976.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        seen = columns(rig)
        thin = random.lognormal(0.0, 0.5, len(rig.observables))
        for row in seen:  # all axes of a marker alike
            thin[row[row >= 0]] = random.lognormal(0.0, 0.5)
        self._moves = alone(rig) * thin / np.sqrt(np.mean(thin**2))
        quick = random.uniform(5.0, 20.0)
        self._tau_s = np.array([quick, quick * random.uniform(8.0, 25.0)])
        self._share = random.uniform(0.12, 0.22) * random.dirichlet([4.0, 4.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        crept = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._share)
        return values + strength * crept @ self._moves


class SeamTapeCreeps(Law):
    """Tape over a seam creeps: above some pull its glue shears on and on, and draws back slowly once the pull is less.

    D. Satas (editor), Handbook of Pressure Sensitive Adhesive Technology, Van Nostrand Reinhold, 1989. Some chambers
    only have such seams.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._holds_to = random.uniform(0.1, 0.4, count)
        self._tau_s = np.array([random.uniform(8.0, 25.0), random.uniform(80.0, 400.0)])
        self._parts = random.dirichlet([4.0, 4.0])
        self._share = some(random, count, 0.5, 0.7, 0.7)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        over = np.sign(load) * np.maximum(np.abs(load) - self._holds_to, 0.0)
        crept = np.einsum("tnc,n->tc", lagged(path, over, self._tau_s), self._parts)
        return deflection + strength * self._share * crept
