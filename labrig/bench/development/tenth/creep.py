"""Creep of the tenth portion: a modified power law in the walls, and a glue line at the foot that turns the body."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span, turned
from labrig.bench.development._story import as_chain, lagged


class ModifiedPower(Law):
    """Williams' modified power law: between two plateaus the walls yield by one over a power of one plus tau over t.

    M. L. Williams, Structural analysis of viscoelastic materials, AIAA Journal 2(5), 1964. It begins as a power of the
    time under load and ends at a limit, decades later.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        power = random.uniform(0.35, 0.75)
        tau_s = np.exp(random.uniform(np.log(10.0), np.log(300.0)))
        time_s = np.geomspace(0.3, 5000.0, 60)
        self._tau_s, self._yields = as_chain((1 + tau_s / time_s) ** -power, time_s)
        self._share = random.uniform(0.06, 0.14) * random.uniform(0.8, 1.2, count)  # in a minute

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("n,tnc->tc", self._yields, lagged(path, deflection, self._tau_s))
        return deflection + strength * self._share * late


class GlueLineAtTheFoot(Law):
    """Glue line: what holds the body's foot shears slowly under the moment of the chambers, and turns all of it.

    O. Volkersen, Die Nietkraftverteilung in zugbeanspruchten Nietverbindungen, Luftfahrtforschung 15, 1938, on shear in
    a joint; J. D. Ferry, Viscoelastic Properties of Polymers, Wiley, 1961: one exponential of seconds, one of minutes.
    Each chamber loads the foot about an axis of its own.
    """

    effect = "creep"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = np.array([random.uniform(4, 15), random.uniform(50, 250)])
        self._weights = random.dirichlet([3.0, 4.0])
        centre, radius_mm = body_mm(self.rig)
        self._foot_mm = centre + random.uniform(0.6, 1.3) * radius_mm * direction(random)
        common = direction(random)
        axes = np.array([0.6 * common + direction(random) for _ in range(count)])
        most = 0.35 * span(self.rig) * np.sqrt(3.0) / radius_mm / np.sqrt(count)
        self._moments = axes * random.uniform(0.7, 1.3, (count, 1)) * min(most, 0.06)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        late = np.einsum("n,tnc->tc", self._weights, lagged(path, deflection, self._tau_s))
        points = positions(self.rig, values)
        turn = strength * late @ self._moments
        return moved(self.rig, values, turned(points, self._foot_mm, turn))
