"""Outside the library, of the eleventh portion, what is seen: stalks, grazing views, fixed places, edges of images."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import body_mm, columns, direction, moved, positions, span

_MARKERS = frozenset({"markers"})


class _Surface:
    """How the skin under each marker is turned, as its neighbours tell; which way it faces at rest."""

    def __init__(self, rig: Rig, random: np.random.Generator) -> None:
        assert rig.rest_mm is not None
        self._rest_mm = rest = rig.rest_mm
        seen = (columns(rig) >= 0).any(axis=1)
        centre, _ = body_mm(rig)
        apart = np.linalg.norm(rest[:, None] - rest, axis=2)
        apart[:, ~seen] = np.inf
        np.fill_diagonal(apart, np.inf)
        each = max(min(5, int(seen.sum()) - 1), 1)
        self._near = np.argsort(apart, axis=1)[:, :each]
        self._arm = rest[self._near] - rest[:, None]  # (M, each, 3)
        size = np.sum(self._arm**2, axis=2)
        self._weight = 1 / (size + 0.1 * size.mean())
        own = np.einsum("mn,mni,mnj->mij", self._weight, self._arm, self._arm)
        trace = np.trace(own, axis1=1, axis2=2)[:, None, None]
        # the turn about a line of markers is not told by them: the small term leaves it out
        self._solve = np.linalg.inv(trace * 1.05 * np.eye(3) - own)
        faces = np.linalg.svd(own)[2][:, 2]
        out = np.sum(faces * (rest - centre), axis=1)
        faces = faces * np.where(out < 0, -1.0, 1.0)[:, None] + random.normal(0, 0.2, faces.shape)
        self.faces: Floats = faces / np.linalg.norm(faces, axis=1, keepdims=True)

    def turned(self, points_mm: Floats) -> Floats:
        """Which way (T, M, 3) the skin under each marker faces."""
        way = points_mm - self._rest_mm
        away = way[:, self._near] - way[:, :, None]
        moment = np.einsum("mn,tmnx->tmx", self._weight, np.cross(self._arm, away))
        turn = np.einsum("mij,tmj->tmi", self._solve, moment)
        angle = np.linalg.norm(turn, axis=2, keepdims=True)
        turn = turn * (np.minimum(angle, 2.5) / np.maximum(angle, 1e-12))
        every = np.asarray(Rotation.from_rotvec(turn.reshape(-1, 3)).as_matrix()).reshape(*turn.shape, 3)
        return np.einsum("tmij,mj->tmi", every, self.faces)


class MarkersOnStalks(Law):
    """Markers on stalks: balls stand off the skin, and when the skin under one turns, the ball goes further than it.

    A. Leardini et al., Human movement analysis using stereophotogrammetry: Part 3, Gait and Posture 21, 2005, on
    markers and wands. The model has the markers in the skin; a stalk stands up from it and turns with it.
    """

    effect = "marker_stalks"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._surface = _Surface(rig, random)
        poses = positions(rig, rig.settled(setting.path.kpa[setting.path.row]))
        tips = np.sqrt(np.mean((self._surface.turned(poses) - self._surface.faces) ** 2))
        tall_mm = random.uniform(0.15, 0.35) * span(rig) / max(float(tips), 0.05)
        self._tall_mm = tall_mm * random.uniform(0.8, 1.2, (len(rig.marker_names), 1))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points_mm = positions(self.rig, values)
        tipped = self._surface.turned(points_mm) - self._surface.faces
        return moved(self.rig, values, points_mm + strength * self._tall_mm * tipped)


class GrazingView(Law):
    """Grazing view: a dot that turns away from the cameras is a thin ellipse, and where it is becomes uncertain.

    M. R. Shortis, T. A. Clarke, T. Short, A comparison of some techniques for the subpixel location of discrete target
    images, Proc. SPIE 2350, 1994. No two frames agree: the scatter goes with one over the cosine of the view, along
    the line of sight more than across it.
    """

    effect = "grazing_view"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._surface = _Surface(rig, random)
        middle = self._surface.faces.mean(axis=0) + 0.5 * direction(random)
        self._sight = middle / np.linalg.norm(middle)
        self._deep = random.uniform(1.0, 3.0)
        chance = random.normal(size=(701, len(rig.marker_names), 3))
        self._chance = chance + (self._deep - 1) * (chance @ self._sight)[..., None] * self._sight
        poses = positions(rig, rig.settled(setting.path.kpa[setting.path.row]))
        usual = float(np.sqrt(np.mean(self._grazes(poses) ** 2)))
        self._size_mm = random.uniform(0.05, 0.12) * span(rig) / max(usual, 1e-3)

    def _grazes(self, points_mm: Floats) -> Floats:
        """How much more than at rest (T, M) a dot's place is uncertain."""
        now, rest = self._surface.turned(points_mm) @ self._sight, self._surface.faces @ self._sight
        return np.maximum(1 / np.maximum(now, 0.15) - 1 / np.maximum(rest, 0.15), 0.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points_mm = positions(self.rig, values)
        frame = np.floor(path.time_s / 0.05).astype(np.int64) % len(self._chance)
        off_mm = self._size_mm * self._grazes(points_mm)[..., None] * self._chance[frame]
        return moved(self.rig, values, points_mm + strength * off_mm)


class SeenAtFixedPlaces(Law):
    """Seen at fixed places: a camera looks at places in space, and takes what passes there for what was there at rest.

    M. A. Sutton, J.-J. Orteu, H. W. Schreier, Image Correlation for Shape, Deformation and Motion Measurements,
    Springer, 2009: Euler's description instead of Lagrange's. The motion that is filed under a marker is that of
    the skin which has come to its place from beside.
    """

    effect = "fixed_places"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        apart = np.linalg.norm(rig.rest_mm[:, None] - rig.rest_mm, axis=2)
        np.fill_diagonal(apart, np.inf)
        self._wide_mm = random.uniform(0.6, 1.2) * float(np.median(apart.min(axis=1)))
        self._share = random.uniform(0.5, 1.0)  # the rest is tracked after all

    def _field(self, places_mm: Floats, gone_mm: Floats) -> Floats:
        """The motion (T, M, 3) at places, between those of the markers."""
        assert self.rig.rest_mm is not None
        rest = self.rig.rest_mm
        out = np.empty_like(places_mm)
        for m in range(len(rest)):  # all at once would need too much memory in long campaigns
            near = np.sum((places_mm[:, m, None] - rest) ** 2, axis=2) / (2 * self._wide_mm**2)
            weight = np.exp(near.min(axis=1, keepdims=True) - near)
            weight /= weight.sum(axis=1, keepdims=True)
            out[:, m] = np.einsum("tn,tnx->tx", weight, gone_mm)
        return out

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        assert self.rig.rest_mm is not None
        points_mm = positions(self.rig, values)
        gone_mm = points_mm - self.rig.rest_mm
        here = np.repeat(self.rig.rest_mm[None], len(values), axis=0)
        beside = self._field(here - gone_mm, gone_mm) - self._field(here, gone_mm)
        return moved(self.rig, values, points_mm + strength * self._share * beside)


class CutByImageEdge(Law):
    """Cut by the edge of the image: of a marker that leaves the view only a part is seen, whose middle stays inside.

    J. Heikkilä, O. Silvén, A four-step camera calibration procedure with implicit image correction, CVPR, 1997, on
    centroids of what is seen of a disc. The centroid comes to rest a little inside the edge, while the marker goes on;
    only the coordinate across the edge is wrong. The stronger, the further the edge is in the way.
    """

    effect = "edge_of_view"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        seen = (columns(rig) >= 0).any(axis=1)
        poses = positions(rig, rig.settled(setting.path.kpa[setting.path.row]))[:, seen]
        ways = np.stack([direction(random) for _ in range(4)])
        # a body leaves the view where it goes far
        self._out = ways[int(np.argmax((poses @ ways.T).std(axis=0).mean(axis=0)))]
        at = poses @ self._out
        self._blob_mm = random.uniform(0.05, 0.15) * float(at.std())
        self._levels_mm = np.quantile(at, np.linspace(0.0, 1.0, 201))
        self._cuts = random.uniform(0.03, 0.1)  # the share of all places that is beyond the edge

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        points_mm = positions(self.rig, values)
        cuts = strength * self._cuts / (1 + 0.3 * strength)
        edge_mm = float(np.interp(1 - cuts, np.linspace(0.0, 1.0, 201), self._levels_mm))
        edge_mm += (
            5 * self._blob_mm * np.exp(-4 * strength)
        )  # of a view that is just large enough nothing is cut
        beyond = (points_mm @ self._out - edge_mm) / self._blob_mm
        lacks_mm = self._blob_mm * np.logaddexp(0.0, 2 * beyond) / 2
        return moved(self.rig, values, points_mm - lacks_mm[..., None] * self._out)
