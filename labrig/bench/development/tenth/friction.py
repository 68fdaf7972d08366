"""Friction of the tenth portion: a smoothed Coulomb force, and walls that drag their neighbours along."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import overlap
from labrig.bench.development._story import finely


class SmoothedCoulomb(Law):
    """Smoothed Coulomb: from each turn the force goes over to its limit the other way by a hyperbolic tangent.

    J. T. Oden, J. A. C. Martins, Models and computational methods for dynamic friction phenomena, Computer Methods in
    Applied Mechanics and Engineering 52, 1985, on regularised laws; taken here over the way, as the body creeps through
    each turn. The limit is the same at all loads.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._limit = random.uniform(0.03, 0.07) * random.uniform(0.75, 1.25, count)
        self._within = random.uniform(0.03, 0.12)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step, _, where = finely(path, deflection, 0.02)
        count = step.shape[1]
        way, since, begun, held = np.ones(count), np.zeros(count), np.zeros(count), np.zeros(count)
        out = np.empty_like(step)
        for i in range(len(step)):
            turns = step[i] * way < 0
            begun, since = np.where(turns, held, begun), np.where(turns, 0.0, since)
            way = np.where(turns, -way, way)
            since = since + np.abs(step[i])
            held = begun + (way - begun) * np.tanh(since / self._within)
            out[i] = held
        return deflection - strength * self._limit * out[where]


class RubsOnItsNeighbour(Law):
    """Walls that rub on each other: a wall that moves drags the one beside it along, until it slides past.

    R. D. Mindlin, H. Deresiewicz, Elastic spheres in contact under varying oblique forces, J. Applied Mechanics 20,
    1953: what counts is the way of one against the other, and the limit grows with what presses both together. What one
    is held back by moves the other on; pairs that move the same places rub the most.
    """

    effect = "friction"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        count = len(rig.chambers)
        first, second = np.triu_indices(count, 1)
        near = overlap(rig)[first, second] + 0.02 * random.random(len(first))
        most = np.argsort(-near)[: max(count - 1, 1)]
        self._first, self._second = first[most], second[most]
        self._rubs = random.uniform(0.04, 0.08) * random.uniform(0.7, 1.3, len(most))
        self._always = random.uniform(0.2, 0.5)  # of the limit, without any air
        self._gives = random.uniform(0.05, 0.15)  # how far one goes past the other before it slides

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step, _, where = finely(path, deflection, 0.02)
        far = np.cumsum(step, axis=0)
        past = step[:, self._first] - step[:, self._second]
        press = np.clip(0.5 * (far[:, self._first] + far[:, self._second]), 0.0, None)
        limit = self._always + (1 - self._always) * press
        held = np.zeros(past.shape[1])
        out = np.empty_like(past)
        for i in range(len(past)):
            held = np.clip(held + past[i] / self._gives, -limit[i], limit[i])
            out[i] = held
        force = self._rubs * out[where]
        change = np.zeros_like(deflection)
        for pair in range(len(self._first)):
            change[:, self._first[pair]] -= force[:, pair]
            change[:, self._second[pair]] += force[:, pair]
        return deflection + strength * change
