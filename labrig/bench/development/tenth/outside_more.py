"""Outside the library, of the tenth portion, what is seen: panes, depth, gaps, priors, files, ambiguous poses."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span


class WavyPane(Law):
    """Wavy pane: the camera looks through a sheet of acrylic whose thickness waves, and straight rays are bent.

    ASTM D637, Standard test method for surface irregularities of flat transparent plastic sheets, 1990. A place
    is seen aside by the slope of the sheet before it; the vented pose was seen through the same sheet.
    """

    effect = "wavy_pane"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, waves = setting.random, 5
        axis = direction(random)
        way = np.stack([direction(random) for _ in range(waves)])
        way -= (way @ axis)[:, None] * axis
        self._way = way / np.linalg.norm(way, axis=1, keepdims=True)
        self._long_mm = span(self.rig) * random.uniform(2.5, 7.0, waves)
        self._phase = random.uniform(0, 2 * np.pi, waves)
        self._deep = random.uniform(0.5, 1.5, waves)
        self._centre = body_mm(self.rig)[0]
        poses = positions(self.rig, self.rig.settled(setting.path.kpa[setting.path.row]))
        size = np.sqrt(np.mean(self._aside(poses) ** 2))
        self._scale = span(self.rig) * random.uniform(0.06, 0.15) / size

    def _slope(self, points_mm: Floats) -> Floats:
        phase = 2 * np.pi * (points_mm - self._centre) @ self._way.T / self._long_mm + self._phase
        return (np.sin(phase) * self._deep) @ self._way

    def _aside(self, points_mm: Floats) -> Floats:
        assert self.rig.rest_mm is not None
        return self._slope(points_mm) - self._slope(self.rig.rest_mm)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points_mm = positions(self.rig, values)
        return moved(self.rig, values, points_mm + strength * self._scale * self._aside(points_mm))


class OutOfPlane(Law):
    """Out of plane: a single camera holds what comes nearer for larger, and shifts it away from its axis.

    M. A. Sutton et al., The effect of out-of-plane motion on 2D and 3D digital image correlation measurements,
    Optics and Lasers in Engineering 46, 2008. The shift is the product of depth and distance from the axis.
    """

    effect = "out_of_plane"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        centre, radius = body_mm(self.rig)
        poses = positions(self.rig, self.rig.settled(setting.path.kpa[setting.path.row]))
        axes = np.stack([direction(random) for _ in range(4)])
        # the camera that sees the body well is seldom the one that its depth does not trouble
        nearer = ((poses - poses.mean(axis=0)) @ axes.T).std(axis=(0, 1))
        self._axis = axes[int(np.argmax(nearer))]
        self._middle = centre + radius * random.normal(0, 0.5, 3)
        self._away_mm = (radius + 2 * span(self.rig)) * random.uniform(3.5, 8.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        assert self.rig.rest_mm is not None
        points_mm = positions(self.rig, values)
        nearer = (points_mm - self.rig.rest_mm) @ self._axis
        arm = points_mm - self._middle
        across = arm - (arm @ self._axis)[..., None] * self._axis
        ratio = np.clip(strength * nearer / self._away_mm, -5.0, 0.7)
        return moved(self.rig, values, points_mm + (ratio / (1 - ratio))[..., None] * across)


class GapsFilled(Law):
    """Gaps filled: markers that turn out of sight in some poses are made up by the software from those beside.

    S. J. Howarth and J. P. Callaghan, Quantitative assessment of the accuracy for three interpolation techniques
    in kinematic analysis of human movement, Computer Methods in Biomechanics 13, 2010. Nothing tells in the log.
    """

    effect = "gaps_filled"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rest = setting.random, self.rig.rest_mm
        assert rest is not None
        self._away = direction(random)
        poses = positions(self.rig, self.rig.settled(setting.path.kpa[setting.path.row]))
        gone = (poses - rest) @ self._away
        self._at = np.quantile(gone, random.uniform(0.45, 0.75, len(rest)), axis=0).diagonal()
        self._wide = 0.1 * gone.std(axis=0) + 1e-9 * span(self.rig)
        hidden = random.random(len(rest)) < random.uniform(0.1, 0.4)
        hidden[np.argsort(gone.std(axis=0))[-2:]] = True
        self._hidden = hidden
        apart = np.linalg.norm(rest[:, None] - rest, axis=2)
        np.fill_diagonal(apart, np.inf)
        weight = (apart.min(axis=1, keepdims=True) / apart) ** 3 * np.where(hidden, 0.2, 1.0)
        self._weight = weight / weight.sum(axis=1, keepdims=True)
        self._moves = 1e-3 * span(self.rig) < gone.std(axis=0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        assert self.rig.rest_mm is not None
        points_mm = positions(self.rig, values)
        way = points_mm - self.rig.rest_mm
        behind = (1 + np.tanh(((way @ self._away) - self._at) / self._wide)) / 2 * self._hidden * self._moves
        made_up = np.einsum("mn,tnx->tmx", self._weight, way)
        return moved(self.rig, values, points_mm + strength * behind[..., None] * (made_up - way))


class ShapePrior(Law):
    """Shape prior: the software believes only in shapes that it was trained on, and draws all others to them.

    T. F. Cootes et al., Active shape models: their training and application, Computer Vision and Image
    Understanding 61, 1995. It was trained while some of the chambers were hardly used.
    """

    effect = "shape_prior"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        count = len(rig.chambers)
        used = np.where(random.random(count) < 0.5, 1.0, random.uniform(0.1, 0.3, count))
        load = random.uniform(0, 1, (30, count)) * used
        way = rig.settled(load * rig.high_kpa) - rig.at_rest
        _, size, mode = np.linalg.svd(way, full_matrices=False)
        keep = max(1, round(count * random.uniform(0.4, 0.8)))
        self._mode, size = mode[:keep], size[:keep]
        self._believed = size**2 / (size**2 + (random.uniform(0.15, 0.3) * size[0]) ** 2)
        self._pull = random.uniform(0.25, 0.45)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        way = values - self.rig.at_rest
        believed = (way @ self._mode.T * self._believed) @ self._mode
        return values - np.expm1(-strength * self._pull) * (believed - way)


class InterchangedCaptures(Law):
    """Interchanged captures: files were renamed by hand, and here and there two that follow each other changed places.

    R. R. Panko, What we know about spreadsheet errors, J. End User Computing 10, 1998. What was seen in the one
    actuation is filed under the other, moment by moment; all other captures are as they should be.
    """

    effect = "interchanged_captures"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._often = random.uniform(0.03, 0.06)
        self._first = int(random.integers(2))
        pairs, path = self._pairs(setting.path), setting.path
        self._turn = np.zeros(1, dtype=np.int64)
        if len(pairs) == 0:
            return
        # those that look alike come last: nobody would notice
        last = np.searchsorted(path.event, pairs, side="right") - 1
        shown = self.rig.settled(path.commanded_kpa[last.ravel()]).reshape(*last.shape, -1)
        apart = np.sqrt(np.mean((shown[:, 1] - shown[:, 0]) ** 2, axis=1))
        late = random.random(len(pairs)) + (apart < 0.5 * np.mean(apart))
        self._turn = np.argsort(np.argsort(late))

    def _pairs(self, path: Path) -> Ints:
        """The actuations (P, 2) that are filed beside each other."""
        captures = np.unique(path.event[path.row])[self._first :]
        return captures[: len(captures) // 2 * 2].reshape(-1, 2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pairs = self._pairs(path)
        wanted = strength * self._often * len(pairs)
        out = values.copy()
        for number, (one, other) in enumerate(pairs):
            # the last one is mistaken for a part of its frames
            share = min(max(wanted - self._turn[number % len(self._turn)], 0.0), 1.0)
            if share > 0:
                here, there = np.flatnonzero(path.event == one), np.flatnonzero(path.event == other)
                out[here] += share * (values[_alike(path, here, there)] - values[here])
                out[there] += share * (values[_alike(path, there, here)] - values[there])
        return out


def _alike(path: Path, here: Ints, there: Ints) -> Ints:
    """For moments of one actuation those of another that are as long after its beginning, or its last one."""
    return there[np.minimum(np.searchsorted(path.hold_s[there], path.hold_s[here]), len(there) - 1)]


class PoseFlips(Law):
    """Pose flips: seen from the front a flat body tilted to and one tilted fro look alike, and the tracker mixes them.

    G. Schweighofer and A. Pinz, Robust pose estimation from a planar target, IEEE Transactions on Pattern
    Analysis and Machine Intelligence 28(12), 2006. In some frames, mostly of small tilts, depth is mirrored.
    """

    effect = "pose_flips"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        poses = positions(self.rig, self.rig.settled(setting.path.kpa[setting.path.row]))
        axes = np.stack([direction(random) for _ in range(5)])
        usual = np.array([np.sqrt(np.mean(self._relief(poses, axis) ** 2)) for axis in axes])
        self._axis, self._small = axes[int(np.argmax(usual))], random.uniform(0.9, 1.5) * usual.max() + 1e-9
        self._often = random.uniform(0.1, 0.25)
        self._chance = random.random(4099)

    def _relief(self, points_mm: Floats, axis: Floats) -> Floats:
        """How much nearer (T, M) each marker came than all of them together."""
        assert self.rig.rest_mm is not None
        nearer = (points_mm - self.rig.rest_mm) @ axis
        return nearer - nearer.mean(axis=1, keepdims=True)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points_mm = positions(self.rig, values)
        relief = self._relief(points_mm, self._axis)
        tilt = np.mean(relief**2, axis=1) / self._small**2
        chance = self._chance[np.floor(path.time_s / 0.2).astype(np.int64) % len(self._chance)]
        often = strength * self._often / (1 + tilt)
        flipped = np.clip((often - chance) / self._often, 0.0, 1.0)
        return moved(self.rig, values, points_mm - 2 * (flipped[:, None] * relief)[..., None] * self._axis)
