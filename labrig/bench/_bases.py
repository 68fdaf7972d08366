"""Base models of blind campaigns: what a laboratory believes of its rig before it has measured.

A recipe is plain data: {half, rig, rig_seed, linear, kind, seed, scale, points, form}. Kinds:

    exact    the rig itself, with nothing hidden
    clipped  the same, at pressures clipped to the limits: a difference across a limit sees half a slope
    learnt   interpolated between `points` settled states of the rig
    wrong    wrong in `form` (one of its half's), by `scale`
"""

from collections.abc import Callable

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.bench._halves import half_of, make_rig
from labrig.bench._nature import Rig
from labrig.bench._size import strength_for
from labrig.bench.records import BaseRecipe, RigRecipe

Predict = Callable[[Floats], Floats]

KINDS = {"exact": 0.6, "clipped": 0.25, "learnt": 0.15}
"""How often a base is of which kind."""
LEARNT_FLOORS = 0.5
"""A learnt base is off by less than this, in floors: it gets more points until it is."""
_MOST_POINTS = 400
_MOST_WRONG = 50.0


def make_base(recipe: BaseRecipe) -> Predict:
    """The base model (F, C) -> (F, K) of a recipe."""
    rig = make_rig(recipe)
    high, kind = np.asarray(rig.high_kpa, dtype=float), recipe["kind"]
    if kind == "exact":
        return lambda actuation: rig.settled(np.asarray(actuation, dtype=float))
    if kind == "clipped":
        return lambda actuation: rig.settled(np.clip(np.asarray(actuation, dtype=float), rig.low_kpa, high))
    if kind == "learnt" and "points" in recipe:
        return _learnt(rig, recipe["points"], recipe["seed"])
    if kind == "wrong" and "form" in recipe and "scale" in recipe:
        wrong, scale = _wrong(rig, recipe["half"], recipe["form"], recipe["seed"]), recipe["scale"]
        return lambda actuation: wrong(np.asarray(actuation, dtype=float), scale)
    raise LabrigError(f"bench: there is no base '{kind}' (exact, clipped, learnt or wrong)")


def own_error(recipe: BaseRecipe, pressure: Floats) -> float:
    """Root mean square of what a recipe's base itself has wrong at pressures (F, C), which no effect takes away.

    Each observable counts by how noisy it is.
    """
    pressure = np.asarray(pressure, dtype=float)
    if recipe["kind"] == "exact":
        return 0.0
    rig = make_rig(recipe)
    return _rms((make_base(recipe)(pressure) - rig.settled(pressure)) / rig.noisier)


def draw_base(
    rig_recipe: RigRecipe, pressure: Floats, floor: float, random: np.random.Generator, structural: float
) -> BaseRecipe:
    """A recipe of a base for a rig; with `structural`, wrong in form by that many floors at pressures (F, C)."""
    recipe: BaseRecipe = {**rig_recipe, "kind": "exact", "seed": int(random.integers(2**31))}
    if structural:
        return _draw_wrong(recipe, pressure, structural * floor, random)
    kind = str(random.choice(list(KINDS), p=list(KINDS.values())))
    if kind == "learnt":
        points = int(random.integers(40, 81))
        while points <= _MOST_POINTS:
            learnt: BaseRecipe = {**recipe, "kind": kind, "points": points}
            if own_error(learnt, pressure) < LEARNT_FLOORS * floor:
                return learnt
            points = int(1.5 * points)
        return recipe  # nobody would have learnt this rig from so few points
    return {**recipe, "kind": kind}


def _draw_wrong(
    recipe: BaseRecipe, pressure: Floats, wanted: float, random: np.random.Generator
) -> BaseRecipe:
    half = recipe["half"]
    rig = make_rig(recipe)
    right = rig.settled(pressure)
    for _ in range(8):
        form, seed = str(random.choice(list(half_of(half).wrong))), int(random.integers(2**31))
        predict = _wrong(rig, half, form, seed)

        def error(scale: float, predict: Callable[[Floats, float], Floats] = predict) -> float:
            return _rms((predict(pressure, scale) - right) / rig.noisier)

        scale = strength_for(error, wanted, _MOST_WRONG)
        if scale is not None:
            return {**recipe, "kind": "wrong", "form": form, "seed": seed, "scale": scale}
    raise LabrigError(f"bench: no base of the rig {recipe['rig']} can be wrong by {wanted:.3g}")


def chambers_own_law(recipe: BaseRecipe, pressure: Floats) -> bool:
    """Whether most of what a base has wrong is a function of each chamber's own pressure, acting where it acts.

    An effect of the pressures (regulator, tension, stiffening) or of a limit may then rightly be named for it.
    """
    rig = make_rig(recipe)
    pressure = np.asarray(pressure, dtype=float)
    left = (make_base(recipe)(pressure) - rig.settled(pressure)) / rig.noisier
    high = np.asarray(rig.high_kpa, dtype=float)
    columns = []
    for c, step in enumerate(np.diag(1e-3 * high)):
        slope = (rig.settled(pressure + step) - rig.settled(pressure - step)) / 2e-3 / rig.noisier
        x = pressure[:, c] / high[c]
        columns += [(slope * (x**k)[:, None]).ravel() for k in (1, 2, 3, 4)]
    X = np.stack(columns, axis=1)
    fit = X @ np.linalg.lstsq(X, left.ravel(), rcond=None)[0]
    return bool(np.sum((left.ravel() - fit) ** 2) < 0.3 * np.sum(left**2))


def _wrong(rig: Rig, half: str, form: str, seed: int) -> Callable[[Floats, float], Floats]:
    return half_of(half).wrong[form](rig, np.random.default_rng(seed))


def _learnt(rig: Rig, points: int, seed: int) -> Predict:
    """A cubic spline through settled states, which are spread as a Latin hypercube over all pressures."""
    from scipy.interpolate import RBFInterpolator
    from scipy.stats import qmc

    high = np.asarray(rig.high_kpa, dtype=float)
    low = rig.low_kpa / high
    share = low + (1.0 - low) * qmc.LatinHypercube(len(high), rng=np.random.default_rng(seed)).random(points)
    spline = RBFInterpolator(share, rig.settled(share * high), kernel="cubic", degree=1)
    return lambda actuation: spline(np.asarray(actuation, dtype=float) / high)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
