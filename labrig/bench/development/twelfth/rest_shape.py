"""Rest shapes of the twelfth portion: chambers that were cut too long, and the tolerances of all parts."""

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way
from labrig.bench.development.twelfth._sensors import usual


class CutTooLong(Law):
    """Cut too long: sleeves and tubes were cut by hand, and with no pressure at all each chamber already is where a
    little pressure, or a little vacuum, would have brought it; from there all goes as modelled.

    ISO 3302-1, Rubber: Tolerances for products, 2014, on lengths that are cut.
    """

    effect = "rest_shape"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._longer = either_way(setting, 0.02, 0.08, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        off = self.rig.shape(self._longer[None])[0] - self.rig.at_rest
        return values + strength * off


class PartsHaveTolerances(Law):
    """Tolerances: links, pins and springs are a little off, each by itself, and so is where each sensor rests.

    ISO 2768-1, General tolerances, 1989. Of two sensors that are fixed to one part both are off, not quite alike.
    """

    effect = "rest_shape"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        far = usual(rig, setting.path)
        own = random.normal(0, 1.0, len(far))
        parts = random.integers(0, max(2, len(far) // 2), len(far))
        shared = random.normal(0, 1.0, int(parts.max()) + 1)[parts]
        self._off = random.uniform(0.05, 0.12) * far * (own + random.uniform(0.0, 1.0) * shared)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._off
