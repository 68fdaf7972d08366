"""Rest shape: the body was made or mounted otherwise than modelled; each point is off by a constant of its own."""

from abc import abstractmethod

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, smooth_field, span, spread


class Offset(Law):
    """What the laws below share: a constant change (K,) of the markers, in mm."""

    effect = "rest_shape"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._offset_mm = spread(
            self.rig, self._field(setting) * span(self.rig) * setting.random.uniform(0.08, 0.25)
        )

    @abstractmethod
    def _field(self, setting: Setting) -> Floats:
        """Where each marker goes, (M, 3), in natural units."""

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._offset_mm


class ScatteredMarkers(Offset):
    """Scattered landmarks: each marker was set beside its place, independently of the others.

    C. Goodall, Procrustes methods in the statistical analysis of shape, J. Royal Statistical Society B 53, 1991.
    """

    def _field(self, setting: Setting) -> Floats:
        return setting.random.normal(size=(len(self.rig.marker_names), 3))


class SmoothWarp(Offset):
    """Warp: the whole body is bent smoothly, as a cast comes out of its mould.

    F. L. Bookstein, Principal warps: thin-plate splines and the decomposition of deformations, IEEE Trans. Pattern
    Analysis and Machine Intelligence 11, 1989.
    """

    def _field(self, setting: Setting) -> Floats:
        return smooth_field(setting)


class CurledSide(Offset):
    """Curl: beyond a line the body curls up or down with the square of the distance, like a bimetal strip.

    S. Timoshenko, Analysis of bi-metal thermostats, J. Optical Society of America 11, 1925.
    """

    def _field(self, setting: Setting) -> Floats:
        rig = self.rig
        assert rig.rest_mm is not None
        centre, radius = body_mm(rig)
        place = (rig.rest_mm - centre) / radius
        axes = np.linalg.svd(place, full_matrices=False)[2][:2]
        angle = setting.random.uniform(0, 2 * np.pi)
        along = place @ (np.cos(angle) * axes[0] + np.sin(angle) * axes[1])
        line = np.quantile(along, setting.random.uniform(0.3, 0.6))
        return 2 * (np.maximum(along - line, 0.0) ** 2)[:, None] * direction(setting.random)
