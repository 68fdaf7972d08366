"""Drift of the eleventh portion: bolts that work loose with use, and a table that levels itself on air."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, long_axis, moved, positions, span, turned

_MARKERS = frozenset({"markers"})


class BoltsWorkLoose(Law):
    """Bolts work loose: a jolt that is too much for a joint makes it slip, and turns its bolt back a little.

    G. H. Junker, New criteria for self-loosening of fasteners under vibration, SAE Transactions 78, 1969. The looser
    it is the less it bears, so that smaller actuations loosen it too; the body turns about its foot as it goes.
    """

    effect = "drift"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        assert rig.rest_mm is not None
        _, along = long_axis(rig)
        foot = np.argsort(along if random.random() < 0.5 else -along)[:3]
        self._about_mm = rig.rest_mm[foot].mean(axis=0)
        jolts = self._jolts(path, rig.deflection(path.kpa))
        self._bears = np.quantile(jolts, random.uniform(0.4, 0.7)) + 1e-9  # while it is tight
        wanted = random.uniform(0.4, 0.8)  # of the preload, by the end
        low, high = np.log(1e-4), np.log(1e2)
        for _ in range(50):
            self._loosens = float(np.exp(0.5 * (low + high)))
            done = self._lost(jolts)[-1] > wanted
            low, high = (low, np.log(self._loosens)) if done else (np.log(self._loosens), high)
        far_mm = float(np.linalg.norm(rig.rest_mm - self._about_mm, axis=1).max())
        ends = random.uniform(0.4, 0.8) * span(rig) * np.sqrt(3.0) / (far_mm * wanted)
        self._turn = min(ends, 0.25) * direction(random)

    @staticmethod
    def _jolts(path: Path, deflection: Floats) -> Floats:
        """How far the walls go, (E,), in each actuation."""
        last = np.searchsorted(path.event, np.arange(path.event[-1] + 1), side="right") - 1
        step = np.diff(deflection[last], axis=0, prepend=np.zeros((1, deflection.shape[1])))
        return np.sqrt(np.mean(step**2, axis=1))

    def _lost(self, jolts: Floats) -> Floats:
        """The share (E,) of the preload that is gone after each actuation."""
        gone, out = 0.0, np.empty(len(jolts))
        for i, jolt in enumerate(jolts):
            slip = max(jolt / self._bears - (1 - gone), 0.0)
            gone = min(gone + self._loosens * slip, 0.95)
            out[i] = gone
        return out

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        lost = self._lost(self._jolts(path, deflection))[path.event]
        turn = strength * lost[:, None] * self._turn
        return moved(self.rig, values, turned(positions(self.rig, values), self._about_mm, turn))


class TableOnAirLegs(Law):
    """Table on air legs: each leg sinks as its air seeps out, until its valve opens and lifts it back: a sawtooth.

    E. I. Rivin, Passive Vibration Isolation, ASME Press, 2003, on levelling valves with a dead band. The rig stands on
    the table, the cameras stand on the floor; legs do not keep time with each other, so it also tilts.
    """

    effect = "drift"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        legs = int(random.integers(3, 5))
        centre, radius_mm = body_mm(self.rig)
        self._period_s = np.exp(random.uniform(np.log(150.0), np.log(1200.0))) * random.uniform(
            0.6, 1.5, legs
        )
        self._phase = random.uniform(0, 1, legs)
        self._lift = random.uniform(0.03, 0.15)  # the share of a period that a leg goes up
        angle = 2 * np.pi * (np.arange(legs) + 0.5) / legs
        leg = np.column_stack([np.cos(angle), np.sin(angle)])
        away = random.uniform(1.0, 4.0) * radius_mm  # from the body to a leg
        self._about_mm = centre + away * np.append(random.uniform(-0.6, 0.6, 2), -random.uniform(0.1, 0.5))
        band_mm = random.uniform(0.4, 0.8) * span(self.rig) * np.sqrt(3.0)
        deep = band_mm * random.uniform(0.6, 1.4, legs)
        # the plane through the tops of all legs: how high its middle is, and its slope along x and y
        self._plane = np.linalg.pinv(np.column_stack([np.ones(legs), away * leg])) * deep

    def _sunk(self, time_s: Floats) -> Floats:
        """How deep (T, L) the legs are, from 0 to 1."""
        at = np.mod(time_s[:, None] / self._period_s + self._phase, 1.0)
        down = 1 - self._lift
        return np.where(at < down, at / down, (1 - at) / self._lift)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        begin = self._sunk(path.time_s[:1])  # the frame was measured at first
        plane = -strength * (self._sunk(path.time_s) - begin) @ self._plane.T
        turn = np.column_stack([plane[:, 2], -plane[:, 1], np.zeros(len(plane))])
        points_mm = turned(positions(self.rig, values), self._about_mm, turn)
        points_mm[..., 2] += plane[:, :1]
        return moved(self.rig, values, points_mm)
