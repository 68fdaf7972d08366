"""Prior spectra: how large which member of a family is, as learnt from the laws of the benchmark's development half."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from labrig.arrays import Floats
from labrig.effects import Space

FILE = Path(__file__).with_name("spectra.json")
BLOCKS = ("shared", "own", "pattern")
"""The parts of a prior, see `Prior`."""


@dataclass(frozen=True)
class Prior:
    """Covariances of a space's coefficients: `shared` over its pressure and field features, `own` over its pressure
    features, alike for each chamber, `pattern` over its pattern features, alike for each observable.
    """

    shared: Floats
    own: Floats
    pattern: Floats


def features_of(space: Space, block: str) -> list[str]:
    """The names of the features that a block of the prior is about, in the order of its covariance."""
    pressures = [f.name for f in space.features if f.kind == "pressure"]
    if block == "own":
        return pressures
    if block == "shared":
        return pressures + [f.name for f in space.features if f.kind == "field"]
    return [f.name for f in space.features if f.kind == "pattern"]


def prior_of(space: Space, spectra: dict | None = None) -> Prior:
    """The learnt prior of a space, or, of one that nothing was learnt about, its features' own weights.

    So it is with single features, beside those that were learnt: no campaign that was learnt from logged a temperature.
    """
    known = (shipped() if spectra is None else spectra).get(space.spectrum)
    plain = unlearnt(space)
    if known is None:
        return plain
    out = {}
    for block in BLOCKS:
        names = features_of(space, block)
        learnt = known.get(block, {"features": [], "covariance": []})
        at = {name: i for i, name in enumerate(learnt["features"])}
        inside = [i for i, name in enumerate(names) if name in at]
        covariance = np.zeros((len(names), len(names)))
        if inside:
            own = [at[names[i]] for i in inside]
            covariance[np.ix_(inside, inside)] = np.asarray(learnt["covariance"])[np.ix_(own, own)]
            weight = np.diag(getattr(plain, block))
            given = weight[inside].sum()
            usual = np.trace(covariance) / given if given > 0 else 0.0
            new = np.setdiff1d(np.arange(len(names)), inside)
            covariance[new, new] = usual * weight[new]
        out[block] = covariance
    if sum(np.trace(c) for c in out.values()) <= 0:
        return plain
    return Prior(**out)


def unlearnt(space: Space) -> Prior:
    """A diagonal prior from the features' weights; pressures alike in all chambers by the space's share."""
    weight = {f.name: f.weight for f in space.features}
    several = any(f.kind == "pressure" and f.values.shape[1] > 1 for f in space.features)
    alike = space.alike if several else 1.0
    shared = [
        weight[f.name] * (alike if f.kind == "pressure" else 1.0)
        for kind in ("pressure", "field")
        for f in space.features
        if f.kind == kind
    ]
    own = [weight[n] * (1 - alike) for n in features_of(space, "own")]
    free = [weight[n] for n in features_of(space, "pattern")]
    return Prior(np.diag(shared), np.diag(own), np.diag(free))


@cache
def shipped() -> dict:
    """What was learnt (`labrig bench learn`), by spectrum."""
    return json.loads(FILE.read_text(encoding="utf-8"))["spectra"] if FILE.is_file() else {}


def factor(covariance: Floats, tolerance: float = 1e-10) -> Floats:
    """L with L L' = covariance, only for the directions that carry more than `tolerance` of its trace."""
    if covariance.size == 0:
        return covariance
    power, U = np.linalg.eigh((covariance + covariance.T) / 2)
    keep = power > tolerance * max(power.sum(), 1e-300)
    return U[:, keep] * np.sqrt(power[keep])
