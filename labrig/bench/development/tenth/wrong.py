"""Wrong bases of the tenth portion: too few modes, poses, neurons or tangents; half a body; lengths that are kept."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig, WrongForm
from labrig.bench.development._places import alone, moved, positions, span

_Base = Callable[[Floats, float], Floats]


def _towards(rig: Rig, other: Callable[[Floats, Floats], Floats]) -> _Base:
    """A base that goes from the rig to another model of it, which is told the pressures and what the rig does.

    Whoever made the model had it begin where the rig rests.
    """
    off = other(np.zeros((1, len(rig.chambers))), rig.at_rest[None]) - rig.at_rest

    def base(kpa: Floats, wrong: float) -> Floats:
        values = rig.settled(kpa)
        return values + wrong * (other(np.asarray(kpa, dtype=float), values) - off - values)

    return base


def _tried(rig: Rig, random: np.random.Generator, count: int) -> Floats:
    """Pressures (N, C) anywhere between the limits, a quarter of them zero."""
    kpa = random.uniform(rig.low_kpa, rig.high_kpa, (count, len(rig.chambers)))
    kpa[random.random(kpa.shape) < 0.25] = 0.0
    return kpa


def few_modes(rig: Rig, random: np.random.Generator) -> _Base:
    """Too few modes: a reduced model knows only the first shapes of a decomposition, and leaves out all others.

    Where a single shape is the whole of it, its amount is taken for a polynomial of the pressures, too low.
    """
    kpa = _tried(rig, random, 40 + 5 * len(rig.chambers))
    way = rig.settled(kpa) - rig.at_rest
    _, size, mode = np.linalg.svd(way, full_matrices=False)
    left = np.sqrt(np.maximum(1 - np.cumsum(size**2) / np.sum(size**2), 0.0))
    keep = int(np.sum(left > random.uniform(0.06, 0.15)))
    mode = mode[: max(keep, 1)]
    if keep > 0:
        return _towards(rig, lambda kpa, values: rig.at_rest + (values - rig.at_rest) @ mode.T @ mode)
    fit = np.linalg.lstsq(kpa / rig.high_kpa, way @ mode.T, rcond=None)[0]
    return _towards(rig, lambda kpa, values: rig.at_rest + kpa / rig.high_kpa @ fit @ mode)


def few_poses(rig: Rig, random: np.random.Generator) -> _Base:
    """Too few poses: between those that were tried it takes their mean, the nearer the more; flat at each of them."""
    count = len(rig.chambers)
    tried = np.concatenate([np.zeros((1, count)), _tried(rig, random, 6 + 6 * count)])
    told = rig.settled(tried)
    power = random.uniform(2.5, 4.0) + 0.4 * count  # far ones must not count in many dimensions

    def mean(kpa: Floats, values: Floats) -> Floats:
        apart = np.linalg.norm((kpa[:, None] - tried) / rig.high_kpa, axis=2) + 1e-6
        weight = (apart.min(axis=1, keepdims=True) / apart) ** power
        return weight @ told / weight.sum(axis=1, keepdims=True)

    return _towards(rig, mean)


def few_neurons(rig: Rig, random: np.random.Generator) -> _Base:
    """Too few neurons: a small network was trained on the rig, whose hidden layer is of chance and too narrow."""
    count = len(rig.chambers)
    hidden = int(random.integers(2, 4)) + count
    into = random.normal(0, 2.0 / np.sqrt(count), (count, hidden))
    bias = random.uniform(-1.5, 1.5, hidden)

    def layer(kpa: Floats) -> Floats:
        return np.tanh(kpa / rig.high_kpa @ into + bias) - np.tanh(bias)

    kpa = _tried(rig, random, 60 + 10 * hidden)
    first = layer(kpa)
    decay = 1e-3 * len(kpa) * np.eye(hidden)
    out = np.linalg.solve(first.T @ first + decay, first.T @ (rig.settled(kpa) - rig.at_rest))
    return _towards(rig, lambda kpa, values: rig.at_rest + layer(kpa) @ out)


def few_tangents(rig: Rig, random: np.random.Generator) -> _Base:
    """Too few tangents: linear models at rest and at some working points, one handing over to the next.

    M. Rewienski and J. White, A trajectory piecewise-linear approach to model order reduction, IEEE Transactions
    on Computer-Aided Design 22, 2003. Far from its point each model is straight where the body is not.
    """
    count, points = len(rig.chambers), int(random.integers(1, 4))
    chosen = random.uniform(0.3, 0.9, (points, count)) * (random.random((points, count)) < 0.7)
    at = np.concatenate([np.zeros((1, count)), chosen]) * rig.high_kpa
    there = rig.settled(at)
    step = 0.08 * np.diag(rig.high_kpa)  # as one would measure it
    slope = np.stack([(rig.settled(a + step) - rig.settled(a - step)) / 0.16 for a in at])
    wide = random.uniform(0.2, 0.4) * np.sqrt(count)

    def mixed(kpa: Floats, values: Floats) -> Floats:
        way = (kpa[:, None] - at) / rig.high_kpa
        near = np.sum(way**2, axis=2) / (2 * wide**2)
        weight = np.exp(near.min(axis=1, keepdims=True) - near)
        weight /= weight.sum(axis=1, keepdims=True)
        return np.einsum("tp,tpk->tk", weight, there + np.einsum("tpc,pck->tpk", way, slope))

    return _towards(rig, mixed)


def half_computed(rig: Rig, random: np.random.Generator) -> _Base:
    """Half of it is computed: the other half is taken for its mirror image, whatever the chambers there do.

    Numbers that are no markers' take the place of those at the other end; a single one, whose curve is taken for
    symmetric about its middle, goes on from half pressure as it came.
    """
    if rig.rest_mm is None:
        return _half_of_the_numbers(rig, random)
    rest = rig.rest_mm
    arms = rest - rest.mean(axis=0)
    _, size, axes = np.linalg.svd(arms, full_matrices=False)
    wide = np.flatnonzero(size > 0.2 * size[0])
    normal = axes[int(random.choice(wide))] * random.choice([-1.0, 1.0])
    mirror = np.eye(3) - 2 * np.outer(normal, normal)
    other_half = arms @ normal > 0
    apart = np.linalg.norm((arms @ mirror)[:, None] - arms, axis=2)
    apart[:, other_half] = np.inf  # only places of the computed half are known
    near = np.exp(
        -0.5 * ((apart - apart.min(axis=1, keepdims=True)) / (0.15 * size[0] / len(arms) ** 0.5)) ** 2
    )
    weight = near / near.sum(axis=1, keepdims=True)

    def mirrored(kpa: Floats, values: Floats) -> Floats:
        points = positions(rig, values)
        way = points - rest
        image = np.einsum("mn,tnx->tmx", weight, way) @ mirror
        return moved(rig, values, points + other_half[:, None] * (image - way))

    return _towards(rig, mirrored)


def _half_of_the_numbers(rig: Rig, random: np.random.Generator) -> _Base:
    count = len(rig.observables)
    if count == 1:
        # a smooth change at the middle, over a few per cent of the range
        def goes_on(kpa: Floats, values: Floats) -> Floats:
            load = kpa / rig.high_kpa
            beyond = (1 + np.tanh((load - 0.5) / 0.05)) / 2
            wall = rig.deflection(kpa)
            image = 2 * rig.deflection(0.5 * rig.high_kpa[None]) - rig.deflection((1 - load) * rig.high_kpa)
            return rig.shape(wall + beyond * (image - wall))

        return _towards(rig, goes_on)
    size = np.sqrt(np.mean(alone(rig) ** 2, axis=0)) + 1e-6 * span(rig)
    sign = random.choice([-1.0, 1.0])
    other_half = np.arange(count) >= (count + 1) // 2

    def swapped(kpa: Floats, values: Floats) -> Floats:
        way = (values - rig.at_rest) / size
        return rig.at_rest + size * np.where(other_half, sign * way[:, ::-1], way)

    return _towards(rig, swapped)


def keeps_lengths(rig: Rig, random: np.random.Generator) -> _Base:
    """Lengths are kept: markers beside each other hold their distance, as if the skin did not stretch at all.

    M. Mueller et al., Position based dynamics, J. Visual Communication and Image Representation 18, 2007. Of
    numbers that are no markers' the mean is held, as of a body full of water; a single one is a chord of its arc.
    """
    if rig.rest_mm is None:
        return _mean_is_held(rig, random)
    rest, sweeps = rig.rest_mm, int(random.integers(5, 12))
    apart = np.linalg.norm(rest[:, None] - rest, axis=2)
    each = min(int(random.integers(2, 5)), len(rest) - 1)
    nearest = np.argsort(apart, axis=1)[:, 1 : each + 1]
    pairs = np.unique(
        np.sort(np.stack([np.repeat(np.arange(len(rest)), each), nearest.ravel()], axis=1)), axis=0
    )
    one, other = pairs.T
    length = np.maximum(apart[one, other], 1e-9)
    ends = np.zeros((len(rest), len(pairs)))
    ends[one, np.arange(len(pairs))], ends[other, np.arange(len(pairs))] = 0.5, -0.5
    ends /= np.maximum(np.sum(ends != 0, axis=1, keepdims=True), 1) / 2

    def held(kpa: Floats, values: Floats) -> Floats:
        points = positions(rig, values)
        for _ in range(sweeps):
            edge = points[:, other] - points[:, one]
            now = np.linalg.norm(edge, axis=2, keepdims=True)
            points = points + np.einsum(
                "me,tex->tmx", ends, edge * (1 - length[:, None] / np.maximum(now, 1e-9))
            )
        return moved(rig, values, points)

    return _towards(rig, held)


def _mean_is_held(rig: Rig, random: np.random.Generator) -> _Base:
    count = len(rig.observables)
    arc = span(rig) * random.uniform(1.2, 2.0)
    if count == 1:
        return _towards(
            rig,
            lambda kpa, values: rig.at_rest + arc * np.sin(np.clip((values - rig.at_rest) / arc, -1.5, 1.5)),
        )
    size = np.sqrt(np.mean(alone(rig) ** 2, axis=0)) + 1e-6 * span(rig)
    share = random.dirichlet(np.full(count, 8.0))
    return _towards(
        rig, lambda kpa, values: values - size * (((values - rig.at_rest) / size) @ share)[:, None]
    )


WRONG: dict[str, WrongForm] = {
    "few_modes": few_modes,
    "few_poses": few_poses,
    "few_neurons": few_neurons,
    "few_tangents": few_tangents,
    "half_computed": half_computed,
    "keeps_lengths": keeps_lengths,
}
