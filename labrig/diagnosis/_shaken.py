"""A frame that shakes: what all markers share in each capture as one rigid body, more than the noise of each."""

import numpy as np
from scipy.special import chdtri

from labrig.arrays import Floats
from labrig.diagnosis._constants import FEWEST_OBSERVATIONS, POSSIBLE
from labrig.diagnosis._design import Design
from labrig.diagnosis._noise_scale import along, everything, log_evidence
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._repeats import repeats_of
from labrig.effects import frame_modes

_COORDINATES = 9
"""Of three markers: with fewer every motion is a rigid one."""
_MOST_CAPTURES = 400
"""Captures that are asked, spread over the campaign: it bounds the time."""
_SCALES = np.geomspace(1.0, 100.0, 41)
"""By how many times rigid motions are noisier than each marker: not at all, with a probability of a half."""
_CHANCE = 0.05
"""Probability with which repeats of a frame that does shake are taken for a frame that does not."""
_APART = 0.3
"""Length of what a rigid motion has beside the chambers' own, from which on that says how much it shakes."""
_SHOWS = 0.1
"""Square of what shows, in floors."""
_CLEAR = 2.0
"""How many times noisier a rigid motion has to be: less is another law's misfit as often, and harms nothing."""
_NEW = 0.1
"""Share of its length by which a rigid motion must stand off those before it: markers in a row have not all six."""


def shaken(design: Design) -> Floats:
    """How all markers shake together from capture to capture, (K, m), in the observables' units: see `Floor.shaken`.
    None of its columns where they do not.

    Of each rigid motion, noise is what no space follows, as it is of few observables (`noise_scale`): so a frame that
    creeps, was moved or turns with the load does not shake. It is read off what is left of the motion beside all that
    the chambers do, where a law that no space holds would leave as much. Nor does a frame shake whose motions come back
    with the set-point: repeats with the same history would differ by as much.
    """
    observations = design.observations
    rows, unit, n = observations.context.rows, observations.unit, observations.n_captures
    own = (rows.axis >= 0) & observations.seen
    out = np.zeros((len(unit), 0))
    if own.sum() < _COORDINATES or n < 2:
        return out
    modes = frame_modes(observations.context)[observations.first].mean(axis=0) / unit[:, None] * own[:, None]
    V = design.V.astype(float)
    length = np.linalg.norm(modes, axis=0)
    Q, R = np.linalg.qr(V.T @ (modes[:, length > 0] / length[length > 0]))
    ways = V @ Q[:, np.abs(np.diag(R)) > _NEW]
    driven = _driven(observations)
    beside = ways - driven @ (driven.T @ ways)
    part = np.linalg.norm(beside, axis=0)
    ways, beside, part = ways[:, part > _APART], (beside / part)[:, part > _APART], part[part > _APART]
    asked = np.flatnonzero(observations.whole)  # what fills gaps is no motion of the frame
    if len(asked) < FEWEST_OBSERVATIONS:
        asked = np.arange(n)
    few = asked[np.unique(np.linspace(0, len(asked) - 1, min(len(asked), _MOST_CAPTURES)).astype(int))]
    values = observations.values[:n] @ beside
    scale = np.ones(len(part))
    for j in np.flatnonzero(values[few].std(axis=0) > 1):
        scale[j] = _scale(design, few, beside[:, j])
    moves = scale > _CLEAR
    known = np.where(np.isin(np.arange(n), asked)[:, None], values[:, moves], np.nan)
    repeats = repeats_of(observations.context, known, np.unique(rows.capture))["same history"]
    if not moves.any() or _repeat(np.array(repeats).reshape(-1, int(moves.sum())), scale[moves]):
        return out
    return unit[:, None] * ways[:, moves] * np.sqrt(scale[moves] ** 2 - 1) / part[moves]


def _repeat(differ: Floats, scale: Floats) -> bool:
    """Whether pairs that repeat each other differ by less (P, m) than noise of such a scale (m,) would, but in one
    case of twenty; never without any.
    """
    differ = differ[np.isfinite(differ).all(axis=1)]
    if not differ.size:
        return False
    return bool(np.square(differ / scale).sum() / 2 < chdtri(differ.size, 1 - _CHANCE))


def _driven(observations: Observations) -> Floats:
    """The directions (K, d) in which the chambers move the observables so far that an error of a law would show."""
    slopes = np.moveaxis(observations.slopes, 2, 1).reshape(-1, len(observations.unit)) * observations.seen
    power, ways = np.linalg.eigh(slopes.T @ slopes)
    return ways[:, power * observations.to_explain**2 > _SHOWS * power.sum()]


def _scale(design: Design, captures: np.ndarray, way: Floats) -> float:
    """How noisy the means of some captures are along a unit way (K,), in floors; one where no more than each."""
    values = design.observations.values[captures] @ way
    power, square, rest = along(everything(design, captures, (way @ design.V)[None]), values)
    log = log_evidence(_SCALES, power, square, rest, len(values))
    log[1:] -= np.log(len(log) - 1)
    p = np.exp(log - log.max())
    p /= p.sum()
    return 1.0 if p[0] > POSSIBLE else float(np.exp((p[1:] * np.log(_SCALES[1:])).sum() / p[1:].sum()))
