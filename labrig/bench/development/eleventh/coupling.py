"""Couplings of the eleventh portion: a strip on an elastic bed, and air that is squeezed within a valve's dead band."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, overlap

_SEVERAL = frozenset({"several"})


class BeamOnElasticBed(Law):
    """Hetényi: chambers lie beside each other under one strip; one lifts its neighbours, and presses down those beyond.

    M. Hetényi, Beams on Elastic Foundation, University of Michigan Press, 1946: what a load does at a distance goes as
    an exponential times the sum of a cosine and a sine. They lie in a row, or the strip is closed to a ring.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        place = np.arange(count) + random.normal(0, 0.08, count)
        apart = np.abs(place[:, None] - place)
        if count > 2 and random.random() < 0.5:
            apart = np.minimum(apart, np.abs(count - apart))
        x = random.uniform(0.9, 1.9) * apart
        lifts = np.exp(-x) * (np.cos(x) + np.sin(x))
        np.fill_diagonal(lifts, 0.0)
        self._lifts = lifts * random.uniform(0.08, 0.2) / np.abs(lifts).sum(axis=0).max()
        self._thrust = random.uniform(0.85, 1.15, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection + strength * (deflection * self._thrust) @ self._lifts


class SqueezedInTheDeadBand(Law):
    """Squeezed in a dead band: neighbours squeeze a chamber's shut-in air, and within its band its valve lets that be.

    R. Boyle, New Experiments Physico-Mechanical, 1662, for the air; makers of electronic regulators state the dead band
    in their data sheets. What it is off by stays until the chamber's own next set-point; of a step that all take at
    once, the neighbours' part that comes after the valve has shut is left.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        near = (overlap(self.rig) + 0.1) * random.uniform(0.6, 1.4, (count, count))
        np.fill_diagonal(near, 0.0)
        self._squeezes = random.uniform(0.2, 0.4) * near / near.sum(axis=0).max()
        self._band = random.uniform(0.03, 0.08) * random.uniform(0.8, 1.2, count)
        self._late = random.uniform(0.25, 0.5)
        self._within_s = random.uniform(0.3, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        first = np.flatnonzero(np.diff(path.event, prepend=-1))
        told = full(self.rig, path.commanded_kpa[first])
        moves = np.diff(told, axis=0, prepend=np.zeros_like(told[:1]))
        squeezed = moves @ self._squeezes
        begins, ends = np.empty_like(told), np.empty_like(told)
        off = np.zeros(told.shape[1])
        for k in range(len(told)):
            own = moves[k] != 0
            begins[k] = np.where(own, 0.0, off)
            off = np.clip(begins[k] + np.where(own, self._late, 1.0) * squeezed[k], -self._band, self._band)
            ends[k] = off
        of = np.searchsorted(first, np.arange(len(kpa)), side="right") - 1
        gone = -np.expm1(-path.hold_s / self._within_s)[:, None]
        shut_in = np.clip(np.abs(full(self.rig, kpa)) / 0.08, 0.0, 1.0)  # what is vented stays open
        now = begins[of] + (ends - begins)[of] * gone
        return kpa + strength * now * shut_in * self.rig.high_kpa
