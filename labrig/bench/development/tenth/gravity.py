"""Gravity of the tenth portion: virtual work along the chambers' own motions, and skins that sag where air is short."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    alone,
    body_mm,
    columns,
    compliance,
    down,
    moved,
    positions,
    span,
)

_MARKERS = frozenset({"markers"})


class VirtualWork(Law):
    """Virtual work: weight and payload push each wall by what they would gain from its motion, and not otherwise.

    J.-L. Lagrange, Mécanique analytique, 1788. The force on a wall is the weight times how far down the mass goes with
    it; the mass is spread over the places, and the payload hangs at one of them. A tilted base pushes otherwise.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        where = columns(rig)
        each = np.where(where >= 0, alone(rig)[:, where], 0.0)  # (C, M, 3)
        mass = random.dirichlet(np.full(each.shape[1], 8.0))
        self._of_body = np.einsum("m,cmx->cx", mass, each)
        self._of_load = each[:, int(random.choice(np.flatnonzero(compliance(rig) > 0.5)))]
        most = np.linalg.norm(self._of_body, axis=1).max()
        self._gives = random.uniform(0.08, 0.18) / most * random.uniform(0.9, 1.1, len(each))
        self._load_kg = random.uniform(0.15, 0.5)  # as heavy as the body itself

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        way = down(path.tilt_deg)
        hangs = (path.payload_kg / self._load_kg)[:, None] * (way @ self._of_load.T) * 0.5
        return deflection + strength * self._gives * (way @ self._of_body.T + hangs)


class SagsWhereAirIsShort(Law):
    """Air-supported skin: each place sags by its weight over the pressure of the chambers that hold it, not of others.

    T. Herzog, Pneumatic Structures, Oxford University Press, 1976; F. Otto, Tensile Structures, MIT Press, 1962. Empty
    skin hangs on its seams, which let it down so far only; a payload adds to the weight of the few places under it.
    """

    effect = "gravity"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        where = columns(rig)
        each = np.linalg.norm(np.where(where >= 0, alone(rig)[:, where], 0.0), axis=2).T  # (M, C)
        self._held_by = each**2 / np.maximum(np.sum(each**2, axis=1, keepdims=True), 1e-12)
        self._soft = np.sqrt(compliance(rig))
        self._seams = random.uniform(0.15, 0.4)  # the share of full air that they are worth
        self._sag_mm = random.uniform(0.25, 0.5) * span(rig)
        _, radius_mm = body_mm(rig)
        under = rig.rest_mm[int(random.choice(np.flatnonzero(self._soft > 0.6)))]
        near = np.sum((rig.rest_mm - under) ** 2, axis=1) / (0.5 * radius_mm) ** 2
        self._under = np.exp(-0.5 * near) / random.uniform(0.05, 0.15)  # per kg, as shares of the weight

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        air = np.maximum(deflection, 0.0) @ self._held_by.T
        weight = 1 + path.payload_kg[:, None] * self._under
        sag = strength * self._sag_mm * self._soft * weight * self._seams / (self._seams + air)
        points = positions(self.rig, values) + sag[..., None] * down(path.tilt_deg)[:, None]
        return moved(self.rig, values, points)
