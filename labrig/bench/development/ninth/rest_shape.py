"""Rest shapes of the ninth portion: tolerances, shrinkage, a warp, a blister, a mould out of line."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import body_mm, direction, long_axis, span, spread


def _no_rigid(rig: Rig, field: Floats, size: float) -> Floats:
    """The field (M, 3) as a change (K,), less what a rigid motion does, with `size` as root mean square.

    Where hardly anything is left (a field that is seen edge-on), the points are off along their own squared
    distance.
    """
    assert rig.rest_mm is not None
    centre, radius = body_mm(rig)
    arms = (rig.rest_mm - centre) / radius
    ways = [np.broadcast_to(axis, arms.shape) for axis in np.eye(3)]
    modes = np.column_stack(
        [spread(rig, way) for way in [*ways, *(np.cross(axis, arms) for axis in np.eye(3))]]
    )

    def rest(change: Floats) -> Floats:
        return np.asarray(change - modes @ np.linalg.lstsq(modes, change, rcond=1e-8)[0])

    change = spread(rig, field)
    left = rest(change)
    if np.linalg.norm(left) < 0.02 * np.sqrt(np.sum(field**2)):
        left = rest(spread(rig, np.sum(arms**2, axis=1, keepdims=True) * np.ones(3)))
    return left * size / np.sqrt(np.mean(left**2))


class _Fixed(Law):
    """What the five have in common: a constant change of the observables."""

    effect = "rest_shape"
    needs = frozenset({"markers"})
    _change: Floats

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._change


class Tolerances(_Fixed):
    """Tolerances: each marker's place scatters as moulded rubber does, each for itself.

    ISO 3302-1, Rubber: Tolerances for products, Part 1: Dimensional tolerances, 2014.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        field = random.normal(size=(len(rig.marker_names), 3)) * random.uniform(0.5, 1.0, 3)
        self._change = _no_rigid(rig, field, span(rig) * random.uniform(0.06, 0.15))


class Shrinkage(_Fixed):
    """Shrinkage: out of the mould silicone draws together by some per cent, along its length not as across.

    T. A. Osswald, L.-S. Turng, P. Gramann (editors), Injection Molding Handbook, Hanser, 2008. The points
    come nearer to the middle in proportion to their distance from it.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        assert rig.rest_mm is not None
        centre, radius = body_mm(rig)
        axis = long_axis(rig)[0]
        arms = (rig.rest_mm - centre) / radius
        other = random.uniform(-0.5, 0.5)
        field = -arms - other * (arms @ axis)[:, None] * axis
        self._change = _no_rigid(rig, field, span(rig) * random.uniform(0.06, 0.15))


class Warp(_Fixed):
    """Warp: two layers cured at different temperatures draw the body into an even curve along its length.

    S. Timoshenko, Analysis of bi-metal thermostats, Journal of the Optical Society of America 11, 1925.
    Points are off sideways by the square of their place along the body.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        axis, place = long_axis(rig)
        way = direction(random)
        if len({o.axis for o in rig.observables}) < 3:  # seen from one side: the layers lie in that plane
            way = np.where(np.isin(np.arange(3), [o.axis for o in rig.observables]), way, 0.0)
        way = way - (way @ axis) * axis
        way /= np.linalg.norm(way)
        self._change = _no_rigid(rig, place[:, None] ** 2 * way, span(rig) * random.uniform(0.08, 0.2))


class BlisteredLayer(_Fixed):
    """Blister: air or too much glue under one place of the skin raises it, and the points around it with it.

    R. M. Barrer and G. Skirrow, Transport and equilibrium phenomena in gas-elastomer systems, Journal of
    Polymer Science 3, 1948, on gas in rubber; the bump is a bell, highest near one marker.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        assert rig.rest_mm is not None
        radius = body_mm(rig)[1]
        top = rig.rest_mm[random.integers(len(rig.rest_mm))] + 0.15 * radius * random.normal(size=3)
        apart = np.sum((rig.rest_mm - top) ** 2, axis=1) / (radius * random.uniform(0.35, 0.6)) ** 2
        field = np.exp(-apart / 2)[:, None] * direction(random)
        self._change = _no_rigid(rig, field, span(rig) * random.uniform(0.06, 0.15))


class MouldMismatch(_Fixed):
    """Mould mismatch: the halves of the mould did not meet, and one side of the body is shifted.

    ISO 8062-3, Geometrical product specifications: Dimensional and geometrical tolerances for moulded parts,
    Part 3, 2007 (surface mismatch). The parting plane lies through the body anyhow.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        assert rig.rest_mm is not None
        way = direction(random) + random.choice([-1.0, 0.0, 1.0]) * long_axis(rig)[0]
        along = rig.rest_mm @ way
        beyond = along > np.quantile(along, random.uniform(0.35, 0.65))
        field = beyond[:, None] * direction(random)
        self._change = _no_rigid(rig, field, span(rig) * random.uniform(0.08, 0.2))
