"""Rest shapes of the sixth portion: printed layers, a rough skin, a swollen spot, sinks over ribs."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import body_mm, direction, long_axis
from labrig.bench.development.rest_shape import Offset


def _seen(setting: Setting) -> Floats:
    """A direction (3,) by chance among those that are measured."""
    axes = sorted({o.axis for o in setting.rig.observables if o.axis >= 0})
    way = np.zeros(3)
    way[axes] = direction(setting.random)[axes]
    return way / np.linalg.norm(way)


class PrintedInLayers(Offset):
    """Stairs: the mould was printed in thick layers; each place lies on the step next to where it should be.

    P. M. Pandey, N. V. Reddy, S. G. Dhande, Slicing procedures in layered manufacturing: a review, Rapid Prototyping J.
    9, 2003. The print also leans a little, layer by layer.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        up = _seen(setting)
        layer = random.uniform(0.15, 0.6)
        high = (self.rig.rest_mm - centre) @ up / radius + random.uniform(0.0, layer)
        off = np.floor(high / layer) * layer + 0.5 * layer - high
        step = np.floor(high / layer)
        return 3.0 * off[:, None] / layer * up + random.uniform(0.0, 0.3) * step[:, None] * _seen(setting)


class RoughSkin(Offset):
    """Weierstrass-Mandelbrot: the skin is rough at all lengths, by waves each shorter and lower than the last.

    M. V. Berry, Z. V. Lewis, On the Weierstrass-Mandelbrot fractal function, Proc. Royal Society A 370, 1980.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        place = (self.rig.rest_mm - centre) / radius
        roughness, shorter = random.uniform(0.2, 0.9), 1.5
        field = np.zeros_like(place)
        for octave in range(9):
            wave = 1.2 * shorter**octave * direction(random)
            phase = place @ wave + random.uniform(0, 2 * np.pi)
            field += shorter ** (-roughness * octave) * np.sin(phase)[:, None] * _seen(setting)
        return field / np.sqrt(np.mean(field**2))


class SwollenSpot(Offset):
    """Eshelby: a spot that oil has swollen grows evenly inside; around it all is pushed away by the square of distance.

    J. D. Eshelby, The determination of the elastic field of an ellipsoidal inclusion, and related problems, Proc. Royal
    Society A 241, 1957. There are one to three spots; some have shrunk instead.
    """

    def _field(self, setting: Setting) -> Floats:
        random, radius = setting.random, body_mm(self.rig)[1]
        rest = self.rig.rest_mm
        assert rest is not None
        field = np.zeros_like(rest)
        for _ in range(int(random.integers(1, 4))):
            spot = rest[int(random.integers(len(rest)))] - 0.3 * radius * _seen(setting)
            ray = (rest - spot) / (radius * random.uniform(0.3, 0.8))
            far = np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-9)
            field += random.choice([1.0, -0.6]) * ray / np.maximum(far, 1.0) ** 3
        return 2.0 * field / max(float(np.sqrt(np.mean(field**2))), 0.3)


class SinksOverRibs(Offset):
    """Sink marks: over each rib a cast is thicker and shrinks more, and has a narrow trough there.

    G. Menges, P. Mohren, How to Make Injection Molds, 3rd ed., Hanser, 2001. Ribs are parallel, and evenly spaced.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        inwards = _seen(setting)
        across = long_axis(self.rig)[0] if random.random() < 0.5 else direction(random)
        spacing, wide = random.uniform(0.5, 1.0), random.uniform(0.1, 0.2)
        at = (self.rig.rest_mm - centre) @ across / radius + random.uniform(0.0, spacing)
        beside = np.mod(at, spacing) - 0.5 * spacing
        depth = random.uniform(0.6, 1.4, 41)[np.clip(np.floor(at / spacing).astype(int) + 20, 0, 40)]
        trough = depth * (np.exp(-0.5 * (beside / (wide * spacing)) ** 2) + random.uniform(0.1, 0.3))
        return -3.0 * trough[:, None] * inwards
