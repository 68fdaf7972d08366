"""Creep of the ninth portion: Burgers' body, decades, a stretched exponential, a springpot, a spectrum."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, full
from labrig.bench.development._story import as_chain, in_a_minute, lagged, pauses


def _crept(path: Path, drive: Floats, tau_s: Floats, yields: Floats) -> Floats:
    """What a chain yields (T, C) under a drive (T, C), without keeping its links."""
    share = -np.expm1(-pauses(path)[:, None] / tau_s)
    state = np.zeros((len(tau_s), drive.shape[1]))
    out = np.empty_like(drive)
    for i in range(len(drive)):
        state += share[i][:, None] * (drive[i] - state)
        out[i] = yields @ state
    return out


class BurgersBody(Law):
    """Burgers' body: a Maxwell and a Voigt element in a row; a part comes and goes late, a little flows.

    J. M. Burgers, Mechanical considerations, model systems, phenomenological theories of relaxation and of
    viscosity, First Report on Viscosity and Plasticity, Amsterdam, 1935. In a vulcanised rubber the flow is
    next to nothing.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._share = random.uniform(0.1, 0.2) * random.uniform(0.8, 1.2, count)
        self._tau_s = np.exp(random.uniform(np.log(12.0), np.log(90.0))) * random.uniform(0.85, 1.15, count)
        self._flows_per_s = random.uniform(2e-5, 1e-4)  # as a share of the delayed part, at full pressure

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        delayed = lagged(path, deflection, self._tau_s[None])[:, 0]
        flow = self._flows_per_s * np.cumsum(load * pauses(path)[:, None], axis=0)
        return deflection + strength * self._share * (delayed + flow)


class CreepByDecades(Law):
    """Creep by decades: each decade of time adds as much as the one before.

    A. N. Gent, Relaxation processes in vulcanized rubber, J. Applied Polymer Science 6, 1962: a ln(1 + t/t0),
    after each change of the load, and the changes superpose. It is some per cent of the strain; chambers
    differ by their walls.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        time_s = np.geomspace(0.3, 5000.0, 60)
        start_s = np.exp(random.uniform(np.log(0.5), np.log(3.0)))
        self._tau_s, self._yields = as_chain(np.log1p(time_s / start_s), time_s)
        self._share = random.uniform(0.1, 0.18) * random.uniform(0.8, 1.2, count)  # in a minute

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection + strength * self._share * _crept(path, deflection, self._tau_s, self._yields)


class StretchedExponentialBody(Law):
    """Kohlrausch's stretched exponential: the whole body goes on as 1 - exp(-(t/tau)^beta).

    R. Kohlrausch, Theorie des elektrischen Rückstandes in der Leidener Flasche, Annalen der Physik 91, 1854;
    G. Williams, D. C. Watts, Transactions of the Faraday Society 66, 1970. After each change all that is seen
    goes on as it went.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        time_s = np.geomspace(0.3, 5000.0, 60)
        tau_s = np.exp(random.uniform(np.log(15.0), np.log(150.0)))
        beta = random.uniform(0.35, 0.65)
        self._tau_s, self._yields = as_chain(-np.expm1(-((time_s / tau_s) ** beta)), time_s)
        self._share = random.uniform(0.1, 0.18)  # in a minute

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._share * _crept(
            path, values - self.rig.at_rest, self._tau_s, self._yields
        )


class SpringpotInParallel(Law):
    """A springpot beside a spring, the fractional Voigt element: 1 - E_alpha(-(t/tau)^alpha).

    R. L. Bagley, P. J. Torvik, A theoretical basis for the application of fractional calculus to
    viscoelasticity, J. Rheology 27, 1983; the spectrum of its times is that of F. Mainardi, Fractional
    Calculus and Waves in Linear Viscoelasticity, Imperial College Press, 2010. Pressure is the stress; all
    chambers are cast of one rubber.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        alpha = random.uniform(0.35, 0.75)
        tau_s = np.exp(random.uniform(np.log(15.0), np.log(150.0)))
        times_s = np.geomspace(0.2, 3e4, 24)
        rate = tau_s / times_s
        slow = rate ** (2 * alpha) + 2 * rate**alpha * np.cos(np.pi * alpha) + 1
        self._tau_s, self._yields = in_a_minute(times_s, rate**alpha * np.sin(np.pi * alpha) / slow)
        self._share = random.uniform(0.1, 0.18) * random.uniform(0.9, 1.1, count)  # in a minute

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        return deflection + strength * self._share * _crept(path, load, self._tau_s, self._yields)


class SpectrumByPlace(Law):
    """A spectrum of retardation times, with a weight of its own at each place: a Prony series of three terms.

    J. D. Ferry, Viscoelastic Properties of Polymers, Wiley, 1961. One cast cures unevenly: the times are
    those of the material, but how much of each there is varies from place to place.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._tau_s = random.uniform(2.0, 6.0) * random.uniform(6.0, 10.0) ** np.arange(3.0)
        yields = random.uniform(0.02, 0.12, (len(rig.observables), 3))
        for row in columns(rig):  # all axes of a marker alike
            yields[row[row >= 0]] = random.uniform(0.02, 0.12, 3)
        self._yields = yields

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        late = lagged(path, values - self.rig.at_rest, self._tau_s)
        return values + strength * np.einsum("tnk,kn->tk", late, self._yields)
