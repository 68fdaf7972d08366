"""The rigs of the fourth portion: a tower, an iris, a bell, a cushion, a toggle and a cuff."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers, markers


class Tower(Rig):
    """Modules of two bellows each, one on top of the other: they grow, and lean to and fro in turn about x and y.

    A. Drotman, M. Ishida, S. Jadhav, M. T. Tolley, Application-driven design of soft, 3-D printed, pneumatic actuators
    with bellows, IEEE/ASME Trans. Mechatronics 24, 2019. Folds that open get ever stiffer; a ring of markers sits on
    each module's plate.
    """

    kind = "tower"

    def __init__(self, random: np.random.Generator) -> None:
        self._modules, ring = int(random.integers(3, 5)), int(random.integers(7, 9))
        count = 2 * self._modules
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(25, 90) * random.uniform(0.94, 1.06, count)
        self.marker_names, self.observables = markers(self._modules * ring)
        self.noise = float(random.uniform(0.04, 0.09))
        around = 2 * np.pi * (np.arange(ring) + random.uniform(0, 1)) / ring
        rim_mm = random.uniform(18, 32) * np.linspace(1.0, random.uniform(0.7, 1.0), self._modules)
        flat = np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=1)
        self._ring_mm = rim_mm[:, None, None] * flat + random.normal(0, 0.4, (self._modules, ring, 3))
        self._tall_mm = random.uniform(18, 30) * random.uniform(0.9, 1.1, self._modules)
        self._grows_mm = self._tall_mm * random.uniform(0.25, 0.5, self._modules)
        self._leans_rad = np.deg2rad(random.uniform(9, 20)) * random.uniform(0.8, 1.2, (self._modules, 2))
        self._opens = random.uniform(0.6, 1.6, count)
        self.rest_mm = np.zeros((self._modules * ring, 3))
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        return np.arctan(self._opens * kpa / self.high_kpa) / np.arctan(self._opens)

    def shape(self, deflection: Floats) -> Floats:
        length = len(deflection)
        foot, turn, out = np.zeros((length, 3)), np.broadcast_to(np.eye(3), (length, 3, 3)), []
        for m in range(self._modules):
            pair = deflection[:, 2 * m : 2 * m + 2]
            lean = pair @ (self._leans_rad[m] * np.array([1.0, -1.0]))
            half = turn @ _about(m % 2, 0.5 * lean)
            turn = turn @ _about(m % 2, lean)
            tall = self._tall_mm[m] + self._grows_mm[m] * pair.mean(axis=1)
            foot = foot + half[:, :, 2] * tall[:, None]
            out.append(foot[:, None] + self._ring_mm[m] @ turn.swapaxes(1, 2))
        return np.concatenate(out, axis=1).reshape(length, -1)


def _about(axis: int, angle: Floats) -> Floats:
    """Rotations (T, 3, 3) about x (0) or y (1) by angles (T,)."""
    out = np.zeros((len(angle), 3, 3))
    other = 1 - axis
    out[:, axis, axis] = 1.0
    out[:, other, other] = out[:, 2, 2] = np.cos(angle)
    sign = -1.0 if axis == 0 else 1.0
    out[:, other, 2], out[:, 2, other] = sign * np.sin(angle), -sign * np.sin(angle)
    return out


class Iris(Rig):
    """A soft ring whose cells close its opening from all sides, seen from above by one camera.

    Cells of cloth move fast at first, with the root of the load. What has closed cannot close again: the opening
    shrinks exponentially. Markers have an x and a y.
    """

    kind = "iris"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(3, 7)), int(random.integers(16, 29))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(8, 40) * random.uniform(0.9, 1.1, count)
        self.marker_names, in_space = markers(seen)
        self.observables = tuple(o for o in in_space if o.axis < 2)
        self.noise = float(random.uniform(0.02, 0.05))
        angle = 2 * np.pi * (np.arange(seen) + random.normal(0, 0.15, seen)) / seen
        self._out = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        self._open_mm = random.uniform(15, 30) * (1 + 0.03 * random.normal(size=seen))
        self._zero_mm = random.normal(0, 3, 2)
        self.rest_mm = np.column_stack([self._zero_mm + self._open_mm[:, None] * self._out, np.zeros(seen)])
        middle = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / count
        apart, narrow = angle - middle[:, None], count * random.uniform(0.8, 1.6)
        bump = np.exp(narrow * (np.cos(apart) - 1))
        self._closes = random.uniform(0.4, 0.9) * random.uniform(0.85, 1.15, (count, 1)) * bump  # (C, M)
        self._aside_mm = random.uniform(0.5, 2.5) * bump * np.sin(apart)
        self._early = random.uniform(0.15, 0.8, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * np.sqrt((1 + self._early) / (np.abs(load) + self._early))

    def shape(self, deflection: Floats) -> Floats:
        left_mm = self._open_mm * np.exp(-np.maximum(deflection @ self._closes, -1.0))
        aside_mm = deflection @ self._aside_mm
        across = np.stack([-self._out[:, 1], self._out[:, 0]], axis=1)
        points = self._zero_mm + left_mm[..., None] * self._out + aside_mm[..., None] * across
        return points.reshape(len(deflection), -1)


class Bell(Rig):
    """A jellyfish: arms around a crown curl in under it, and a chamber in the crown lifts it and spreads them all.

    A. A. Villanueva, C. F. Smith, S. Priya, A biomimetic robotic jellyfish (Robojelly) actuated by shape memory alloy
    composite actuators, Bioinspiration and Biomimetics 6, 2011. Each arm is an arc of a circle; pressure curls it less
    and less.
    """

    kind = "bell"

    def __init__(self, random: np.random.Generator) -> None:
        arms = int(random.integers(4, 7))
        self.chambers = chambers(arms + 1)
        self.high_kpa = np.append(np.full(arms, random.uniform(30, 120)), random.uniform(10, 40))
        self.high_kpa = self.high_kpa * random.uniform(0.95, 1.05, arms + 1)
        self.marker_names, self.observables = markers(3 * arms + 1)
        self.noise = float(random.uniform(0.05, 0.12))
        around = 2 * np.pi * np.arange(arms) / arms + random.normal(0, 0.05, arms)
        self._out = np.stack([np.cos(around), np.sin(around)], axis=1)
        self._crown_mm, self._long_mm = random.uniform(12, 25), random.uniform(40, 75)
        self._at = np.array([0.4, 0.7, 1.0]) + random.normal(0, 0.03, (arms, 3))  # places along each arm
        self._droops_rad = np.deg2rad(random.uniform(5, 35))
        self._curls_rad = np.deg2rad(random.uniform(50, 110)) * random.uniform(0.9, 1.1, arms)
        self._spreads_rad = np.deg2rad(random.uniform(5, 15))
        self._lifts_mm = random.uniform(4, 10)
        self._fades = random.uniform(0.7, 2.2, arms + 1)
        self.rest_mm = self.shape(np.zeros((1, arms + 1))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return np.sign(load) * np.expm1(-self._fades * np.abs(load)) / np.expm1(-self._fades)

    def shape(self, deflection: Floats) -> Floats:
        crown = deflection[:, -1]
        curl = (deflection[:, :-1] * self._curls_rad)[..., None] * self._at  # (T, arms, 3), up to each place
        first = self._droops_rad - self._spreads_rad * crown[:, None, None]
        chord = self._long_mm * self._at * np.sinc(0.5 * curl / np.pi)
        far = self._crown_mm + chord * np.cos(first + 0.5 * curl)
        height = self._lifts_mm * crown[:, None, None] - chord * np.sin(first + 0.5 * curl)
        arms = np.concatenate([far[..., None] * self._out[:, None], height[..., None]], axis=3)
        top = np.stack([0.0 * crown, 0.0 * crown, 6.0 + 1.5 * self._lifts_mm * crown], axis=1)
        return np.concatenate([arms.reshape(len(deflection), -1), top], axis=1)


class Cushion(Rig):
    """A seat on three to five air cells, over six to nine load cells that together carry one and the same weight.

    M. Kosiak, W. G. Kubicek, M. Olson, J. N. Danz, F. J. Kottke, Evaluation of pressure as a factor in the production
    of ischial ulcers, Archives of Physical Medicine and Rehabilitation 39, 1958. What one cell lifts it takes off the
    others; contact widens, so that a cell's pull grows with a power of its pressure.
    """

    kind = "cushion"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(3, 6)), int(random.integers(6, 10))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(6, 20) * random.uniform(0.9, 1.1, count)
        self.observables = tuple(Observable(f"load{k + 1}", "N") for k in range(seen))
        self.noise = float(random.uniform(0.2, 0.5))
        self._weight_n = random.uniform(400, 800)
        self._first = random.normal(0, 0.25, seen)
        middle, place = random.uniform(-1, 1, (count, 2)), random.uniform(-1, 1, (seen, 2))
        apart = np.linalg.norm(middle[:, None] - place, axis=2)
        self._lifts = random.uniform(0.7, 1.6, (count, 1)) * np.exp(
            -0.5 * (apart / random.uniform(0.5, 0.9)) ** 2
        )
        self._power = random.uniform(1.2, 1.8, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return np.sign(load) * np.abs(load) ** self._power

    def shape(self, deflection: Floats) -> Floats:
        stands = self._first + deflection @ self._lifts
        share = np.exp(stands - stands.max(axis=1, keepdims=True))
        return self._weight_n * share / share.sum(axis=1, keepdims=True)


class Toggle(Rig):
    """An arched spring between two bellows that push it to and fro: not quite bistable, and steep halfway.

    J. Qiu, J. H. Lang, A. H. Slocum, A curved-beam bistable mechanism, J. Microelectromechanical Systems 13, 2004. The
    spring's cubic has kept a little slope where it would snap; an encoder reads the lever's angle.
    """

    kind = "toggle"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = chambers(2)
        self.high_kpa = random.uniform(40, 160) * random.uniform(0.9, 1.1, 2)
        self.observables = (Observable("lever", "deg"),)
        self.noise = float(random.uniform(0.03, 0.08))
        self._slope = random.uniform(0.25, 0.9)
        rest = -random.uniform(0.35, 0.8)
        self._before = rest**3 + self._slope * rest
        self._push = np.array([random.uniform(0.9, 1.8), -random.uniform(0.4, 1.2)])
        self._turns_deg = random.uniform(10, 25)
        self._softens = random.uniform(0.25, 0.9, 2)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._softens) / (1 + self._softens * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        scale = 2 * np.sqrt(self._slope / 3)
        push = self._before + deflection @ self._push
        at = scale * np.sinh(np.arcsinh(3 * push / (self._slope * scale)) / 3)  # at^3 + slope at = push
        return (self._turns_deg * at)[:, None]


class Cuff(Rig):
    """A compression sleeve: three to seven cells along a limb, felt by five to twelve stretch sensors in its cloth.

    H. Partsch, M. Clark, S. Bassez et al., Measurement of lower leg compression in vivo, Dermatologic Surgery 32, 2006.
    A cell first fills its slack, and then tightens in proportion; each sensor's divider gives volts that level off.
    """

    kind = "cuff"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(3, 8)), int(random.integers(5, 13))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(5, 16) * random.uniform(0.9, 1.1, count)
        self.observables = tuple(Observable(f"stretch{k + 1}", "V") for k in range(seen))
        self.noise = float(random.uniform(0.002, 0.005))
        cell, place = np.arange(count) / (count - 1), np.sort(random.uniform(0, 1, seen))
        wide = random.uniform(0.6, 1.2) / count
        self._pulls = np.exp(-0.5 * ((cell[:, None] - place) / wide) ** 2) * random.uniform(0.7, 1.3, seen)
        self._zero_v = random.uniform(0.6, 1.4, seen)
        self._volts = random.uniform(0.5, 1.2)
        self._levels = random.uniform(0.1, 0.6, seen)
        self._slack = random.uniform(0.1, 0.6, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * np.abs(load) / (np.abs(load) + self._slack) * (1 + self._slack)

    def shape(self, deflection: Floats) -> Floats:
        stretch = deflection @ self._pulls
        return self._zero_v + self._volts * stretch / (1 + self._levels * np.abs(stretch))
