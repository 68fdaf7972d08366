"""Rigs of the eleventh portion: a truss of bellows, a paper lantern of ribs, a tail on a table, a honeycomb slab."""

import numpy as np
from scipy.special import erf

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers, markers

_THIRD = 2 * np.pi / 3
_SLANTS = [(j, (j + k) % 3) for j in range(3) for k in (0, 1)]
"""Which node above and which below each of the six slants of a storey holds: rings are turned by half a part."""


class Truss(Rig):
    """A truss: storeys of three nodes each, on slanting bellows that lengthen; rings of rods or bellows close them.

    N. S. Usevitch et al., An untethered isoperimetric soft robot, Science Robotics 5, 2020; the nodes are where all
    lengths fit, by Newton's method. A bellows' load is a line and a cube of its lengthening, as its folds open out.
    """

    kind = "truss"

    def __init__(self, random: np.random.Generator) -> None:
        self._storeys = int(random.choice([1, 2], p=[0.65, 0.35]))
        self._ring_moves = self._storeys == 1 and random.random() < 0.4
        slants = 6 * self._storeys
        count = slants + 3 * self._ring_moves
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(40, 110) * random.uniform(0.95, 1.05, count)
        self.marker_names, self.observables = markers(3 * self._storeys + slants + 1)
        self.noise = float(random.uniform(0.05, 0.15))
        wide_mm = random.uniform(60, 110) * random.uniform(0.75, 1.0, self._storeys + 1).cumprod()
        high_mm = np.cumsum(np.append(0.0, random.uniform(0.9, 1.4, self._storeys) * wide_mm[:-1]))
        self._nodes_mm = np.stack(
            [self._ring(wide_mm[k], high_mm[k], 0.5 * k, random) for k in range(self._storeys + 1)]
        )
        self._longer = random.uniform(0.12, 0.2) / self._storeys**0.5 * random.uniform(0.92, 1.08, count)
        self._cube = random.uniform(0.35, 0.65) * random.uniform(0.95, 1.05, count)
        self._ball_mm, self._mast_mm = random.uniform(6, 12), random.uniform(15, 50)
        self._thick_mm, self._bulges_mm = random.uniform(8, 15), random.uniform(0.5, 2.5)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    @staticmethod
    def _ring(wide_mm: float, high_mm: float, turn: float, random: np.random.Generator) -> Floats:
        angle = _THIRD * (np.arange(3) + turn)
        ring = np.stack([wide_mm * np.cos(angle), wide_mm * np.sin(angle), np.full(3, high_mm)], axis=1)
        return ring + random.normal(0, 0.015 * wide_mm, ring.shape)

    def deflection(self, kpa: Floats) -> Floats:
        load, a = kpa / self.high_kpa, self._cube
        third = np.sqrt((1 - a) / (3 * a))
        return 2 * third * np.sinh(np.arcsinh(load / (2 * a * third**3)) / 3)

    def _storey(self, below: Floats, storey: int, slants: Floats, ring: Floats) -> Floats:
        """The nodes (T, 3, 3) above those `below`, from how much longer slants (T, 6) and ring (T, 3) are."""
        rest, foot = self._nodes_mm[storey + 1], self._nodes_mm[storey]
        long_mm = np.array([np.linalg.norm(rest[j] - foot[i]) for j, i in _SLANTS]) * (1 + slants)
        ring_mm = np.linalg.norm(rest - np.roll(rest, -1, axis=0), axis=1) * (1 + ring)
        lengths = np.concatenate([long_mm, ring_mm], axis=1)
        at = rest + np.mean(below - foot, axis=1, keepdims=True)
        size_mm = float(np.linalg.norm(rest[0] - foot[0]))
        for _ in range(9):
            slope = np.zeros((len(at), 9, 3, 3))
            off = np.zeros((len(at), 9))
            for row, (j, i) in enumerate([*_SLANTS, (0, 1), (1, 2), (2, 0)]):
                way = at[:, j] - (below[:, i] if row < 6 else at[:, i])
                far = np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 0.02 * size_mm)
                slope[:, row, j] = way / far
                if row >= 6:
                    slope[:, row, i] = -way / far
                off[:, row] = far[:, 0] - lengths[:, row]
            flat = slope.reshape(-1, 9, 9)
            turned = np.swapaxes(flat, 1, 2)
            step = np.linalg.solve(turned @ flat + 1e-4 * np.eye(9), turned @ off[..., None])[..., 0]
            most = np.abs(step).max(axis=1, keepdims=True)
            step *= 0.3 * size_mm / np.maximum(most, 0.3 * size_mm)
            at = at - step.reshape(-1, 3, 3)
        return at

    def shape(self, deflection: Floats) -> Floats:
        times = len(deflection)
        longer = self._longer * deflection
        below = np.broadcast_to(self._nodes_mm[0], (times, 3, 3))
        nodes: list[Floats] = []
        middles: list[Floats] = []
        for storey in range(self._storeys):
            own = slice(6 * storey, 6 * storey + 6)
            ring = longer[:, 6:9] if self._ring_moves else np.zeros((times, 3))
            above = self._storey(below, storey, longer[:, own], ring)
            centre = 0.5 * (above.mean(axis=1, keepdims=True) + below.mean(axis=1, keepdims=True))
            middle = 0.5 * np.stack([above[:, j] + below[:, i] for j, i in _SLANTS], axis=1)
            thick = (self._thick_mm + self._bulges_mm * deflection[:, own])[..., None]
            middles.append(middle + thick * self._unit(middle - centre))
            nodes.append(above + self._ball_mm * self._unit(above - above.mean(axis=1, keepdims=True)))
            below = above
        up = self._unit(np.cross(below[:, 1] - below[:, 0], below[:, 2] - below[:, 0]))
        mast = (below.mean(axis=1) + self._mast_mm * up)[:, None]
        return np.concatenate([*nodes, *middles, mast], axis=1).reshape(times, -1)

    @staticmethod
    def _unit(vector: Floats) -> Floats:
        return vector / np.maximum(np.linalg.norm(vector, axis=-1, keepdims=True), 1e-9)


class Lantern(Rig):
    """A lantern: inflated ribs between a fixed ring and a lid bow out, and draw the lid down, aslant, and round.

    B. Mosadegh et al., Pneumatic networks for soft robotics that actuate rapidly, Advanced Functional Materials 24,
    2014: until the cells of a rib touch each other it hardly bends, and then in proportion. A chord is shorter than
    its arc by the square of the bow; what the stiff lid does not allow the ribs make up for by bowing more, or less.
    """

    kind = "lantern"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 8))
        lid = int(random.integers(3, 5))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(30, 90) * random.uniform(0.95, 1.05, count)
        self.marker_names, self.observables = markers(2 * count + lid)
        self.noise = float(random.uniform(0.05, 0.2))
        self._wide_mm = random.uniform(30, 55)
        self._arc_mm = random.uniform(80, 150)
        self._round = 2 * np.pi * np.arange(count) / count + random.normal(0, 0.03, count)
        self._bow_mm = self._arc_mm * random.uniform(0.05, 0.1) * random.uniform(0.9, 1.1, count)
        self._bows_mm = self._arc_mm * random.uniform(0.14, 0.22) * random.uniform(0.9, 1.1, count)
        lever = np.stack([np.ones(count), np.cos(self._round), np.sin(self._round)], axis=1)
        self._lever, self._fit = lever, np.linalg.pinv(lever)
        self._makes_up = random.uniform(0.3, 0.7)
        self._twists = np.deg2rad(random.uniform(3, 12)) * random.choice([-1.0, 1.0])
        self._thick_mm, self._fills_mm = random.uniform(5, 9), random.uniform(1, 4)
        self._place = np.array([0.35, 0.65]) + random.normal(0, 0.02, (count, 2))
        dots = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(lid) / lid
        far_mm = self._wide_mm * random.uniform(0.5, 0.9, lid)
        self._lid_mm = np.stack(
            [far_mm * np.cos(dots), far_mm * np.sin(dots), np.full(lid, random.uniform(3, 12))], axis=1
        )
        self._touch = random.uniform(0.25, 0.45) * random.uniform(0.95, 1.05, count)
        self._blur = random.uniform(0.09, 0.16)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        def bent(load: Floats) -> Floats:
            return np.logaddexp(0.0, (load - self._touch) / self._blur)

        none = bent(np.zeros_like(self._touch))
        return (bent(kpa / self.high_kpa) - none) / (bent(np.ones_like(self._touch)) - none)

    def shape(self, deflection: Floats) -> Floats:
        times = len(deflection)
        bow = self._bow_mm + self._bows_mm * deflection
        lost = np.pi**2 * bow**2 / (4 * self._arc_mm)
        chord = self._arc_mm * (1 - np.tanh(lost / self._arc_mm))
        lid = chord @ self._fit.T  # height, and how far it rises towards x and y, over the ring
        bow = bow + self._makes_up * (chord - lid @ self._lever.T)
        slope = lid[:, 1:] / self._wide_mm
        normal = np.concatenate([-slope, np.ones((times, 1))], axis=1)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        turn = self._twists * deflection.mean(axis=1)

        def on_lid(points_mm: Floats) -> Floats:
            """Points (N, 3) of the lid, turned about its axis and then tilted by the shortest way, (T, N, 3)."""
            c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
            x, y = c * points_mm[:, 0] - s * points_mm[:, 1], s * points_mm[:, 0] + c * points_mm[:, 1]
            z = np.broadcast_to(points_mm[:, 2], x.shape)
            flat = np.stack([x, y, z], axis=-1)
            axis = np.stack([-normal[:, 1], normal[:, 0], np.zeros(times)], axis=1)[:, None]
            cosine = normal[:, 2][:, None, None]
            along = np.sum(axis * flat, axis=-1, keepdims=True)
            tilted = cosine * flat + np.cross(axis, flat) + axis * along / (1 + cosine)
            return tilted + lid[:, :1, None] * np.array([0.0, 0.0, 1.0])

        ring = np.stack([np.cos(self._round), np.sin(self._round), np.zeros_like(self._round)], axis=1)
        feet, heads = self._wide_mm * ring, on_lid(self._wide_mm * ring)
        out_mm = bow[..., None] * np.sin(np.pi * self._place)
        out_mm = out_mm + (self._thick_mm + self._fills_mm * deflection)[..., None]
        up = self._place[..., None]
        ribs = (1 - up) * feet[:, None] + up * heads[:, :, None] + out_mm[..., None] * ring[:, None]
        return np.concatenate([ribs.reshape(times, -1), on_lid(self._lid_mm).reshape(times, -1)], axis=1)


class Tail(Rig):
    """A tail on a table: two to four chambers around its length bend it, two to six stretch sensors are glued on it.

    Y.-L. Park, B.-R. Chen, R. J. Wood, Design and fabrication of soft artificial skin using embedded microchannels and
    liquid conductors, IEEE Sensors Journal 12, 2012. A sensor tells its strain in per cent, and goes slack when it is
    pressed together by more than it was stretched on. Silicone gives way the faster, the thinner it has become; with
    syringes some of these tails are sucked as well as blown.
    """

    kind = "tail"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(2, 5)), int(random.integers(2, 7))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(20, 60) * random.uniform(0.95, 1.05, count)
        sucked = random.uniform(0.15, 0.5) if random.random() < 0.5 else 0.0
        self._low_kpa = 0.0 - sucked * self.high_kpa
        self.observables = tuple(Observable(f"strain{k + 1}", "%") for k in range(seen))
        self.noise = float(random.uniform(0.02, 0.06))
        around = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / count
        sensor = around[0] + 2 * np.pi * np.arange(seen) / seen + random.normal(0, 0.25, seen)
        place = random.uniform(0.2, 0.9, seen)
        swells = np.exp(-0.5 * ((place[:, None] - random.uniform(0.35, 0.65, count)) / 0.5) ** 2)
        bends = random.uniform(0.16, 0.3) * random.uniform(0.9, 1.1, count)
        longer = random.uniform(0.04, 0.1) * random.uniform(0.9, 1.1, count)
        off = np.cos(sensor[:, None] - around)  # a full chamber's own side becomes the longer one
        self._strain = swells * (longer + bends * off)
        self._shear = swells * bends * np.sin(sensor[:, None] - around) * random.uniform(0.3, 0.8)
        self._flatter = random.uniform(0.02, 0.08)  # of two chambers at once, as the section flattens
        self._stretched = random.uniform(0.08, 0.2, seen)
        self._slack = random.uniform(0.02, 0.05)
        self._gain = random.uniform(0.95, 1.05, seen)
        self._softens = random.uniform(0.6, 1.4) * random.uniform(0.95, 1.05, count)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        load = np.minimum(kpa / self.high_kpa, 30.0)
        return np.expm1(self._softens * load) / np.expm1(self._softens)

    def shape(self, deflection: Floats) -> Floats:
        far = 6.0 * np.tanh(deflection / 6.0)  # beyond which it would have burst
        both = (np.sum(far, axis=1) ** 2 - np.sum(far**2, axis=1))[:, None]
        strain = far @ self._strain.T - self._flatter * both / far.shape[1]
        strain = np.hypot(1 + strain, far @ self._shear.T) - 1
        tight = self._slack * np.logaddexp(0.0, (strain + self._stretched) / self._slack)
        return 100 * self._gain * tight


class Honeycomb(Rig):
    """A honeycomb slab: strips of cells under vacuum buckle and shrink, both ways; one camera sees it from in front.

    D. Yang et al., Buckling of elastomeric beams enables actuation of soft machines, Advanced Materials 27, 2015. The
    beams buckle as a column that is not quite straight; squares between them turn to and fro, and what they turn by
    brings them closer (J. N. Grima, K. E. Evans, Auxetic behavior from rotating squares, J. Materials Science Letters
    19, 2000). It hangs from its upper edge; pressures are below the room's.
    """

    kind = "honeycomb"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(2, 5))
        across, down = int(random.integers(3, 6)), int(random.integers(3, 6))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(15, 50) * random.uniform(0.95, 1.05, count)
        self.marker_names = tuple(f"m{k + 1}" for k in range(across * down))
        self.observables = tuple(
            Observable(f"m{k + 1}.{'xyz'[axis]}", "mm", k, axis)
            for k in range(across * down)
            for axis in (0, 2)
        )
        self.noise = float(random.uniform(0.03, 0.1))
        self._wide_mm, self._high_mm = random.uniform(70, 140), random.uniform(60, 120)
        x, z = np.meshgrid(np.linspace(-0.47, 0.47, across), np.linspace(-0.12, -0.97, down))
        jitter = random.normal(0, 0.01, (2, across * down))
        self._x_mm = self._wide_mm * (x.ravel() + jitter[0])
        self._z_mm = self._high_mm * (z.ravel() + jitter[1])
        cell_mm = self._wide_mm / (2.5 * across)
        spot = random.uniform(0, 2 * np.pi, across * down)
        to_and_fro = np.where((np.add.outer(np.arange(down), np.arange(across)) % 2).ravel() == 0, 1.0, -1.0)
        self._spot_mm = cell_mm * random.uniform(0.2, 0.5) * np.exp(1j * spot)
        self._way = to_and_fro
        self._middle_mm = self._wide_mm * ((np.arange(count) + 0.5) / count - 0.5)
        self._half_mm = 0.5 * self._wide_mm / count
        self._blur_mm = self._half_mm * random.uniform(0.4, 0.7)
        self._skew, self._turns = np.deg2rad(random.uniform(3, 8)), np.deg2rad(random.uniform(36, 50))
        self._holds = random.uniform(0.15, 0.35)  # how far from its clamped edge it is kept from shrinking
        self._over = random.uniform(1.5, 2.4) * random.uniform(0.95, 1.05, count)  # full vacuum over critical
        self._crooked = random.uniform(0.12, 0.3)
        self.rest_mm = np.zeros((across * down, 3))
        self.rest_mm[:, [0, 2]] = self.shape(np.zeros((1, count))).reshape(-1, 2)

    def _bows(self, load: Floats) -> Floats:
        """How far beams bow under loads over the critical one: t^3 + (1 - load) t = load * crooked, by Newton."""
        push = np.abs(load) * self._crooked
        out = np.cbrt(push) + np.sqrt(np.maximum(load - 1, 0.0))
        for _ in range(30):
            slope = np.maximum(3 * out**2 + 1 - load, 1e-12)
            out = np.maximum(out - (out**3 + (1 - load) * out - push) / slope, 0.0)
        return np.where(load < 0, -out, out)

    def deflection(self, kpa: Floats) -> Floats:
        return self._bows(kpa / self.high_kpa * self._over) / self._bows(self._over)

    def _within(self, x_mm: Floats) -> tuple[Floats, Floats]:
        """How much of each strip is at places (M,), and how much of it up to there from the middle, in mm: (M, C)."""
        low = (x_mm[:, None] - self._middle_mm + self._half_mm) / self._blur_mm
        high = (x_mm[:, None] - self._middle_mm - self._half_mm) / self._blur_mm

        def area(t: Floats) -> Floats:
            return 0.5 * self._blur_mm * (t * erf(t) + np.exp(-(t**2)) / np.sqrt(np.pi))

        return 0.5 * (erf(low) - erf(high)), area(low) - area(high)

    def shape(self, deflection: Floats) -> Floats:
        turn = self._turns * 2.5 * np.tanh(deflection / 2.5)
        shrinks = np.cos(self._skew) - np.cos(self._skew + turn)
        here, up_to = self._within(self._x_mm)
        middle = self._within(np.zeros(1))[1]
        free = 1 - np.exp(self._z_mm / (self._holds * self._high_mm))
        x = self._x_mm - free * (shrinks @ (up_to - middle).T)
        z = self._z_mm - (self._z_mm + self._holds * self._high_mm * free) * (shrinks @ here.T)
        squares = self._spot_mm * np.exp(1j * self._way * (turn @ here.T))
        x, z = x + free * np.real(squares), z + free * np.imag(squares)
        return np.stack([x, z], axis=-1).reshape(len(deflection), -1)
