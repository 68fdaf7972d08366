"""The segments of an input that nobody cut into captures: plateaus, ramps, cycles, and stretches of anything else.

All thresholds are fractions of the range of each input; noise of a measured input is told by its second differences.
Everything but the search for turning points, which visits each local extreme once, is done on whole arrays.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints

Kind = Literal["plateau", "ramp", "cycle", "stretch"]

_FLAT = 0.02
"""How far an input may wander on a plateau."""
_JUMP = 0.015
"""What is more than this from one row to the next is a step, not a slow motion."""
_TURN = 0.05
"""How far an input has to go back to have turned."""
_CALM, _LONG = 0.5, 0.5
"""A plateau between steps wanders by less than half a step, and is longer than half of the motion beside it."""
_WINDOW, _QUIET = 0.08, 0.004
"""Within such a part of the rows that one way over the range takes, a plateau in a slow motion moves by no more."""
_BENDS, _GOES_ON = 0.95, 0.98
"""Share of what an input does on a crest, and there and as far beside it, that a parabola says."""
_SHORTEST = 3
_EXACTLY = 1 / 3
"""Share of the rows that are exactly as the row before from which on an input is a command that is held."""
_ALIKE = 0.15
_BACK = 0.5
"""Share of its range over which something goes back and forth that is driven."""
_PIECES = 12


@dataclass(frozen=True)
class Segment:
    """Rows `begin` to `end` (not included) of one kind, and what they are called."""

    begin: int
    end: int
    kind: Kind
    name: str


def find_segments(u: Floats, time_s: Floats, unit: str) -> list[Segment]:
    """Cut an input (n, C) at times (n,) into segments, in order, that cover all rows."""
    n = len(u)
    low, span = u.min(axis=0), np.ptp(u, axis=0)
    active = span > 1e-9 * np.maximum(np.abs(u).max(axis=0), 1e-300)
    if n < _SHORTEST or not active.any():
        return _named([(0, n, "plateau", 0)], u, time_s, unit)
    x = (u[:, active] - low[active]) / span[active]
    noise = _noise(x)
    main = x[:, int(np.argmax(np.maximum(np.abs(np.diff(x, axis=0)) - 3 * noise, 0).sum(axis=0)))]
    level = max(_TURN, 8 * noise)
    pieces: list[tuple[int, int, str, int]] = []
    at = 0
    for begin, end in _plateaus(x, noise, main, level):
        if begin > at:
            pieces += _moving(main, time_s, at, begin, level)
        pieces.append((begin, end, "plateau", 0))
        at = end
    if at < n:
        pieces += _moving(main, time_s, at, n, level)
    return _named(pieces, u, time_s, unit)


def held_share(segments: Sequence[Segment]) -> float:
    """The share of rows that are on plateaus."""
    total = sum(s.end - s.begin for s in segments)
    return sum(s.end - s.begin for s in segments if s.kind == "plateau") / max(total, 1)


def _noise(x: Floats) -> float:
    """Standard deviation of an input's own noise; 0 for a command."""
    if len(x) < 5 or _exact(x):
        return 0.0
    second = np.abs(np.diff(x, n=2, axis=0))
    return float(np.median(second, axis=0).max() * 1.4826 / np.sqrt(6))


def is_set(u: Floats) -> bool:
    """Whether an input (n, C) is a command that is set, and holds for several rows, however few."""
    span = np.ptp(u, axis=0)
    active = span > 0
    return len(u) > 1 and bool(active.any()) and _exact(u[:, active] / span[active])


def _exact(x: Floats) -> bool:
    """Whether an input is a command that is held, however short its holds: in many rows it is exactly what it was, and
    where it is not, it makes a step that no rounding of a slow motion makes.
    """
    step = np.abs(np.diff(x, axis=0)).max(axis=1)
    return bool((step == 0).mean() >= _EXACTLY) and bool(np.median(step[step > 0]) > 2 * _JUMP)


def _plateaus(x: Floats, noise: float, main: Floats, level: float) -> list[tuple[int, int]]:
    """Where all inputs stand still: between steps, or within a slow motion."""
    flat = min(_FLAT + 6 * noise, 0.2)
    least = 2 if _exact(x) else _SHORTEST
    jump = np.abs(np.diff(x, axis=0)).max(axis=1)
    edges = np.flatnonzero(jump > max(_JUMP, 6 * noise)) + 1
    edges = np.r_[0, np.union1d(edges, _small_steps(jump)) if _exact(x) else edges, len(x)]
    starts, lengths = edges[:-1], np.diff(edges)
    spread = (np.maximum.reduceat(x, starts) - np.minimum.reduceat(x, starts)).max(axis=1)
    ends = np.r_[0.0, jump[edges[1:-1] - 1], 0.0]
    beside = np.maximum(ends[:-1], ends[1:]) if len(starts) > 1 else np.array([np.inf])
    still = (spread <= np.minimum(flat, _CALM * beside)) & (
        lengths >= (least if noise == 0 else 2 * _SHORTEST)
    )
    still &= lengths >= _LONG * _moving_beside(lengths, least)
    if _exact(x):
        still |= _brief_holds(x[starts], lengths, still)
    out = [(int(s), int(s + k)) for s, k in zip(starts[still], lengths[still], strict=True)]
    at = 0
    for begin, end in [*out, (len(x), len(x))]:
        if begin - at >= 10:
            out += _slow(x[at:begin], main[at:begin], noise, level, at)
        at = end
    return sorted(out)


def _brief_holds(x: Floats, lengths: Ints, still: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which single rows between two holds of a command, all (k, C), are holds, too, as a vent between two set-points:
    one that is on the way from hold to hold, in every input that changes, is none.
    """
    beside = np.r_[True, still[:-1]] & np.r_[still[1:], True]
    before, after = x[np.r_[0, : len(x) - 1]], x[np.r_[1 : len(x), len(x) - 1]]
    on_the_way = (((x - before) * (after - x) > 0) | (before == after)).all(axis=1)
    return ~still & (lengths == 1) & beside & ~on_the_way


def _small_steps(jump: Floats) -> Ints:
    """Where a command that is held exactly changes by however little, between holds as long as most rows' are."""
    changes = np.flatnonzero(jump > 0) + 1
    lengths = np.diff(np.r_[0, changes, len(jump) + 1])
    usual = np.median(np.repeat(lengths, lengths))
    return changes[np.minimum(lengths[:-1], lengths[1:]) >= usual / 2]


def _moving_beside(lengths: Ints, least: int) -> Ints:
    """For each run of rows without a step, how many rows of steps lie on its longer side."""
    short = lengths < least
    block = np.cumsum(np.r_[True, short[1:] != short[:-1]]) - 1
    rows = np.bincount(block, weights=np.where(short, lengths, 0)).astype(np.int64)
    before = np.r_[0, rows][block]
    after = np.r_[rows, 0][block + 1]
    return np.where(short, 0, np.maximum(before, after))


def _slow(x: Floats, main: Floats, noise: float, level: float, offset: int) -> list[tuple[int, int]]:
    """Plateaus between slow ramps: long, by the rows that one way over the range takes, and flatter than a crest.

    The input is smoothed over half a window against its noise; what that takes from a plateau's ends is given back.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d  # only records need them

    turns = np.r_[0, turning_points(main, level), len(main) - 1]
    travel = float(np.abs(np.diff(main[turns])).sum())
    way = len(main) / max(travel, 0.5)
    window = int(np.clip(_WINDOW * way, 3, len(x)))
    over = max(window // 2, 1)
    smooth = uniform_filter1d(x, over, axis=0, mode="nearest")
    high, low = (
        np.asarray(f(smooth, window, axis=0, mode="nearest")) for f in (maximum_filter1d, minimum_filter1d)
    )
    still = np.asarray((high - low).max(axis=1) <= _QUIET + 6 * noise / np.sqrt(over))
    runs = np.flatnonzero(np.diff(np.r_[False, still, False].astype(np.int8))).reshape(-1, 2)
    apart = runs[1:, 0] - runs[:-1, 1] >= window
    begins, ends = runs[np.r_[True, apart][: len(runs)], 0], runs[np.r_[apart, True][: len(runs)], 1]
    out: list[tuple[int, int]] = []
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        exact = bool((np.ptp(x[begin:end], axis=0) == 0).all())
        if end - begin < max(_SHORTEST, (0.05 if exact else 0.15) * way):
            continue
        middle = np.median(x[begin:end], axis=0)
        first, last = max(begin - window - over, 0), min(end + window + over, len(x))
        near = np.asarray((np.abs(x[first:last] - middle) <= _QUIET + 4 * noise).all(axis=1))
        before, after = near[: begin - first][::-1], near[end - first :]
        begin -= int(np.argmin(np.r_[before, False]))
        end += int(np.argmin(np.r_[after, False]))
        if _is_crest(x, begin, end):
            continue
        if out and begin + offset < out[-1][1]:
            begin = out[-1][1] - offset
        out.append((begin + offset, end + offset))
    return out


def _is_crest(x: Floats, begin: int, end: int) -> bool:
    """Whether some rows of an input (n, C) are the top or the bottom of a swing: they bend all through, and go on as
    they bend for as long again. A plateau is flat, and left by a kink.
    """
    half = (end - begin) // 2
    if half < _SHORTEST or begin < half or end + half > len(x):
        return False
    return _bends(x[begin:end], _BENDS) and _bends(x[begin - half : end + half], _GOES_ON)


def _bends(x: Floats, share: float) -> bool:
    """Whether a parabola says at least such a share of what rows (n, C) do."""
    row = np.linspace(-1, 1, len(x))
    curve = np.column_stack([np.ones(len(x)), row, row**2])
    left = x - curve @ np.linalg.lstsq(curve, x, rcond=None)[0]
    moved = float(((x - x.mean(axis=0)) ** 2).sum())
    return moved > 0 and bool((left**2).sum() <= (1 - share) * moved)


def turning_points(values: Floats, level: float) -> Ints:
    """Rows at which values turn, having gone at least `level` since the last turn and going back as far."""
    change = np.sign(np.diff(values))
    moving = np.flatnonzero(change)
    if len(moving) < 2:
        return np.zeros(0, dtype=np.int64)
    turned = np.flatnonzero(change[moving[1:]] != change[moving[:-1]])
    extremes = np.r_[0, moving[turned] + 1, len(values) - 1]
    out: list[int] = []
    best_high = best_low = float(values[0])
    at_high = at_low = 0
    way = 0
    for row, v in zip(extremes.tolist(), values[extremes].tolist(), strict=True):
        if v > best_high:
            best_high, at_high = v, row
        if v < best_low:
            best_low, at_low = v, row
        if way >= 0 and best_high - v >= level:
            if way > 0:
                out.append(at_high)
            way, best_low, at_low = -1, v, row
            best_high, at_high = v, row
        elif way <= 0 and v - best_low >= level:
            if way < 0:
                out.append(at_low)
            way, best_high, at_high = 1, v, row
            best_low, at_low = v, row
    return np.array(out, dtype=np.int64)


def goes_back_and_forth(values: Floats) -> bool:
    """Whether something that was measured (n,) still turns twice and more in its later half, each time by more than
    half of all it does, and by more than its noise.
    """
    span = float(np.ptp(values)) if len(values) else 0.0
    if span == 0:
        return False
    x = (values - values.min()) / span
    return len(turning_points(x[len(x) // 2 :], max(_BACK, 8 * _noise(x[:, None])))) >= 2


def _moving(
    main: Floats, time_s: Floats, begin: int, end: int, level: float
) -> list[tuple[int, int, str, int]]:
    """Ramps, cycles or stretches between two plateaus; with the way that a ramp goes."""
    own = main[max(begin - 1, 0) : end + 1]
    shift = max(begin - 1, 0)
    turns = turning_points(own, level) + shift
    turns = turns[(turns > begin) & (turns < end)]
    if len(turns) <= 2:
        cuts = [begin, *turns.tolist(), end]
        out = []
        for a, b in itertools.pairwise(cuts):
            go = main[min(b, len(main) - 1)] - main[max(a - 1, 0)]
            out.append((a, b, "ramp", int(np.sign(go))))
        return out
    if (cuts := _cycles(main, turns)) is not None:
        inner = [c for c in cuts if begin < c < end]
        cuts = [begin, *inner, end]
        return [(a, b, "cycle", 0) for a, b in itertools.pairwise(cuts)]
    count = int(np.clip(len(turns) // 6, 1, _PIECES))
    edges = np.unique(np.linspace(begin, end, count + 1).astype(int))
    return [(int(a), int(b), "stretch", 0) for a, b in itertools.pairwise(edges)]


def _cycles(main: Floats, turns: Ints) -> list[int] | None:
    """Where whole cycles begin, if the turns come regularly and at the same heights; else None."""
    if len(turns) < 4:
        return None
    even, odd = turns[::2], turns[1::2]
    periods = np.r_[np.diff(even), np.diff(odd)]
    heights = max(float(np.std(main[even])), float(np.std(main[odd])))
    if np.std(periods) > _ALIKE * np.mean(periods) or heights > _ALIKE / 1.5:
        return None
    low = even if main[even].mean() < main[odd].mean() else odd
    return low.tolist()


def _named(pieces: list[tuple[int, int, str, int]], u: Floats, time_s: Floats, unit: str) -> list[Segment]:
    count: dict[str, int] = {}
    out = []
    unit = "" if unit == "1" else f" {unit}"
    for begin, end, kind, way in pieces:
        count[kind] = count.get(kind, 0) + 1
        own = u[begin:end]
        if kind == "plateau":
            at = f" at {', '.join(f'{v:.3g}' for v in np.median(own, axis=0)[:4])}{unit}"
        elif kind == "ramp":
            after = u[min(end, len(u) - 1)]
            c = int(np.argmax(np.abs(after - own[0])))
            at = f" {'up' if way >= 0 else 'down'} to {after[c]:.3g}{unit}"
        else:
            at = f" ({time_s[begin] - time_s[0]:.4g}-{time_s[end - 1] - time_s[0]:.4g} s)"
        out.append(Segment(begin, end, kind, f"{kind} {count[kind]}{at}"))  # type: ignore[arg-type]
    return out
