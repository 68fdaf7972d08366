"""Where a rig's markers are, how far it moves, and which chambers move the same places."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Path, Rig, Setting


def columns(rig: Rig) -> Ints:
    """The column (M, 3) of each marker's x, y, z among the observables, -1 where it is not measured."""
    out = np.full((len(rig.marker_names), 3), -1)
    for column, observable in enumerate(rig.observables):
        if observable.marker >= 0:
            out[observable.marker, observable.axis] = column
    return out


def positions(rig: Rig, values: Floats) -> Floats:
    """The markers (T, M, 3) in mm of observables (T, K): at rest along an axis that is not measured."""
    assert rig.rest_mm is not None
    where = columns(rig)
    out = np.broadcast_to(rig.rest_mm, (len(values), *rig.rest_mm.shape)).copy()
    out[:, where >= 0] = values[:, where[where >= 0]]
    return out


def moved(rig: Rig, values: Floats, points_mm: Floats) -> Floats:
    """The observables (T, K) with the markers at `points_mm` (T, M, 3)."""
    where = columns(rig)
    out = values.copy()
    out[:, where[where >= 0]] = points_mm[:, where >= 0]
    return out


def shift(rig: Rig, vector: Floats) -> Floats:
    """A shift of everything by `vector` (..., 3), as a change (..., K); what is no marker's moves by its length."""
    along = np.where(vector[..., :1] < 0, -1.0, 1.0) * np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([vector, along], axis=-1)[..., [o.axis for o in rig.observables]]


def spread(rig: Rig, field_mm: Floats) -> Floats:
    """A field of vectors (M, 3) at the markers as a change (K,) of the observables."""
    return moved(rig, np.zeros((1, len(rig.observables))), field_mm[None])[0]


def alone(rig: Rig) -> Floats:
    """What each chamber does alone at full deflection, (C, K)."""
    return rig.shape(np.eye(len(rig.chambers))) - rig.at_rest


def span(rig: Rig) -> float:
    """How far the observables move at full pressure: the root mean square over them and over the chambers."""
    return float(np.sqrt(np.mean(alone(rig) ** 2)))


def compliance(rig: Rig) -> Floats:
    """How easily each marker moves, (M,): 1 for the most mobile one."""
    where = columns(rig)
    each = np.where(where >= 0, alone(rig)[:, where], 0.0)
    size = np.sqrt(np.sum(each**2, axis=(0, 2)))
    return size / size.max()


def overlap(rig: Rig) -> Floats:
    """How much two chambers move the same observables, (C, C): 1 if all the same, 0 on the diagonal."""
    size = np.abs(alone(rig))
    size /= np.linalg.norm(size, axis=1, keepdims=True)
    out = size @ size.T
    np.fill_diagonal(out, 0.0)
    return out


def body_mm(rig: Rig) -> tuple[Floats, float]:
    """The centre (3,) of the markers at rest, and the root mean square of their distance from it."""
    assert rig.rest_mm is not None
    centre = rig.rest_mm.mean(axis=0)
    return centre, float(np.sqrt(np.mean(np.sum((rig.rest_mm - centre) ** 2, axis=1))))


def turned(points_mm: Floats, about_mm: Floats, turn_rad: Floats) -> Floats:
    """Points (T, M, 3) turned about a point by a rotation vector (3,), or one for each moment (T, 3)."""
    matrix = np.asarray(Rotation.from_rotvec(np.array(turn_rad)).as_matrix())
    return (points_mm - about_mm) @ np.swapaxes(matrix, -1, -2) + about_mm


def smooth_field(setting: Setting) -> Floats:
    """A smooth field of vectors (M, 3) over the markers, drawn by chance: root mean square 1 over its numbers."""
    rig, random = setting.rig, setting.random
    centre, radius = body_mm(rig)
    assert rig.rest_mm is not None
    phase = (rig.rest_mm - centre) / radius @ random.normal(0, 1.2, (3, 4)) + random.uniform(0, 2 * np.pi, 4)
    field = np.sin(phase) @ random.normal(size=(4, 3))
    return field / np.sqrt(np.mean(field**2))


def down(tilt_deg: Floats) -> Floats:
    """The direction (T, 3) of gravity, seen from a base turned about x."""
    turn = np.deg2rad(tilt_deg)
    return np.stack([np.zeros_like(turn), -np.sin(turn), -np.cos(turn)], axis=1)


def long_axis(rig: Rig) -> tuple[Floats, Floats]:
    """The direction (3,) in which the body is longest, and each marker's place (M,) along it, from 0 to 1."""
    assert rig.rest_mm is not None
    axis = np.linalg.svd(rig.rest_mm - rig.rest_mm.mean(axis=0), full_matrices=False)[2][0]
    along = rig.rest_mm @ axis
    return axis, (along - along.min()) / np.ptp(along)


def pattern(rig: Rig) -> Floats:
    """How the observables (K,) move when all chambers fill at once, as a direction of length 1."""
    every = rig.shape(np.ones((1, len(rig.chambers))))[0] - rig.at_rest
    most = alone(rig)[0]
    way = every if np.linalg.norm(every) > 0.3 * np.linalg.norm(most) else most
    return way / np.linalg.norm(way)


def direction(random: np.random.Generator) -> Floats:
    """A direction (3,) drawn by chance."""
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def full(rig: Rig, kpa: Floats) -> Floats:
    """Pressures as shares (T, C) of the upper limits."""
    return kpa / rig.high_kpa


def reached(rig: Rig, path: Path) -> Floats:
    """The largest deflection (C,) of each chamber on a path, at least a tenth."""
    return np.maximum(rig.deflection(path.kpa).max(axis=0), 0.1)


def either_way(setting: Setting, low: float, high: float, share: float = 1.0) -> Floats:
    """Errors (C,) of either sign, their sizes between low and high."""
    count = len(setting.rig.chambers)
    return some(setting.random, count, low, high, share) * setting.random.choice([-1.0, 1.0], count)


def some(random: np.random.Generator, count: int, low: float, high: float, share: float = 1.0) -> Floats:
    """Sizes (count,) between low and high; of several, each is zero with probability 1 - share, but never all."""
    on = random.random(count) < share
    on[random.integers(count)] = True
    return np.where(on, random.uniform(low, high, count), 0.0)
