"""Outside the library, of the eighth portion: what happens in laboratories and is on no list of usual suspects."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, pattern, shift, span


class ToolLeftOnIt(Law):
    """Tool left on it: somebody puts a thing down on the body, forgets it for some actuations, and takes it away.

    Of the laboratory; on such causes W. A. Shewhart, Economic Control of Quality of Manufactured Product, Van Nostrand,
    1931 (assignable causes). While it lies there, the body is pressed down and moves a little less.
    """

    effect = "tool_left_on"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        seen_s = np.sort(path.time_s[path.row])
        share = random.uniform(0.2, 0.35)
        begin = random.uniform(0.1, 0.85 - share)
        self._from_s, self._to_s = np.quantile(seen_s, [begin, begin + share])
        self._press = span(self.rig) * random.uniform(0.15, 0.35)
        self._held = random.uniform(0.05, 0.2)
        count = len(self.rig.observables)
        self._way = -pattern(self.rig) * np.sqrt(count) * random.uniform(0.4, 1.0, count)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        lies = ((path.time_s >= self._from_s) & (path.time_s < self._to_s)).astype(float)[:, None]
        less = self._held * (values - self.rig.at_rest)
        return values + strength * lies * (self._press * self._way - less)


class HosesStraighten(Law):
    """Hoses straighten: a bent supply hose under pressure wants to be straight, and pushes the body that it ends at.

    A. Wolf, An elementary theory of the Bourdon gage, Journal of Applied Mechanics 13, 1946. Each hose pushes its own
    way, whatever its chamber does to the body: with the pressure at first, and no more once it is straight.
    """

    effect = "hose_push"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        count = len(self.rig.chambers)
        way = random.normal(size=(count, 3))
        self._push = shift(self.rig, way / np.linalg.norm(way, axis=1, keepdims=True))
        self._push *= span(self.rig) * random.uniform(0.08, 0.2) * random.uniform(0.4, 1.2, (count, 1))
        self._straight = random.uniform(0.3, 0.8, count)  # the share of the pressure at which it nearly is

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * np.tanh(full(self.rig, path.kpa) / self._straight) @ self._push


class LampInTheEye(Law):
    """Lamp in the eye: in some poses the glossy body mirrors a lamp into the sensor, which is drawn towards the light.

    B. K. P. Horn, Robot Vision, MIT Press, 1986 (specular reflection). Each observable is drawn its own way, and only
    near the pose at which the angle is right.
    """

    effect = "glare"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._look = random.normal(size=len(self.rig.observables)) + 2 * pattern(self.rig)
        pose = self._pose(self.rig.settled(setting.path.kpa[setting.path.row]))
        self._at = float(np.quantile(pose, random.uniform(0.35, 0.8)))
        self._wide = float(pose.std()) * random.uniform(0.25, 0.5)
        self._drawn = (
            span(self.rig) * random.uniform(0.1, 0.25) * random.normal(size=len(self.rig.observables))
        )
        if np.sqrt(np.mean(self._drawn**2)) < 0.1 * span(self.rig):
            self._drawn *= 0.1 * span(self.rig) / np.sqrt(np.mean(self._drawn**2))

    def _pose(self, values: Floats) -> Floats:
        return (values - self.rig.at_rest) @ self._look

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        bright = np.exp(-(((self._pose(values) - self._at) / self._wide) ** 2) / 2)
        return values + strength * bright[:, None] * self._drawn


class LinesOfTheScale(Law):
    """Lines of the scale: an encoder that divides the lines of its scale has an error that comes back at each line.

    P. L. M. Heydemann, Determination and correction of quadrature fringe measurement errors in interferometers, Applied
    Optics 20(19), 1981. The two signals differ in size and are not quite a quarter apart, hence two waves a line.
    """

    effect = "cyclic_error"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.observables)
        self._line = span(self.rig) * random.uniform(0.4, 0.8)
        self._once, self._twice = span(self.rig) * np.array(
            [random.uniform(0.045, 0.08), random.uniform(0.015, 0.04)]
        )
        self._phase = random.uniform(0, 2 * np.pi, (2, count))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        turn = 2 * np.pi * (values - self.rig.at_rest) / self._line
        once = self._once * np.sin(turn + self._phase[0])
        return values + strength * (once + self._twice * np.sin(2 * turn + self._phase[1]))


class StrandBreaks(Law):
    """Strand breaks: in a hard actuation a reinforcing strand snaps, and that chamber is softer from then on.

    A. R. Bunsell (editor), Handbook of Properties of Textile and Technical Fibres, Woodhead, 2018. It happens without
    notice and for good, to a few chambers at most.
    """

    effect = "broken_strand"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path, count = setting.random, setting.path, len(self.rig.chambers)
        rows = np.sort(path.row)
        rows = rows[int(random.uniform(0.25, 0.5) * len(rows)) : int(0.75 * len(rows))]
        load = np.abs(path.kpa[rows])
        used = random.permutation(np.flatnonzero(load.max(axis=0) > 0.1 * self.rig.high_kpa))
        self._snaps_s = np.full(count, np.inf)
        for c in used[: max(1, round(count / 4))]:
            hard = load[:, c] >= 0.7 * load[:, c].max()
            self._snaps_s[c] = path.time_s[rows[hard][0]]
        self._softer = random.uniform(0.2, 0.5, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        broken = path.time_s[:, None] >= self._snaps_s
        return deflection * (1 + strength * np.where(broken, self._softer, 0.0))
