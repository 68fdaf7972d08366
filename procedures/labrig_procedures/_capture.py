"""Captures over the whole range of the rig: actuate, settle, record, at set-points chosen to fill it."""

import itertools
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from labrig._ranges import rounded, within
from labrig.arrays import Floats
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps


class Capture(Procedure):
    """Captures at set-points that fill the range of the chambers, some of them visited several times.

    A repeated set-point is visited `repeats` times after the same companion, so that whatever depends on history is
    the same: what these visits differ by is the noise floor. It is visited once more after another set-point: what
    differs then is history, and so it is for the companions. All visits of one set-point share a repeat label and
    are spread over the session.
    """

    captures: int = Field(40, ge=1, description="captures altogether, repeats included")
    pattern: Literal["halton", "random", "grid", "corners"] = Field(
        "halton", description="how set-points are chosen"
    )
    repeated: int = Field(3, ge=0, description="set-points that are visited again")
    repeats: int = Field(3, ge=1, description="visits of each of them with the same history")
    lowest: float = Field(
        0.0, ge=0.0, le=1.0, description="least set-point, as a share of the way from vented to the limit"
    )
    highest: float = Field(1.0, ge=0.0, le=1.0, description="highest set-point, as such a share")
    settle_s: float = Field(3.0, ge=0.0, description="wait after each actuation, s")
    record_s: float = Field(1.0, gt=0.0, description="length of each recording, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return float(self.captures)

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, settle, record, for every set-point of the programme."""
        for pressure_kpa, repeat in self.programme(rig):
            yield Actuate(pressure_kpa)
            yield Settle(self.settle_s)
            yield Record(self.record_s, repeat=repeat)

    def programme(self, rig: RigInfo) -> list[tuple[tuple[float, ...], str]]:
        """The set-points, kPa, in order, with their repeat labels ("" for none)."""
        groups = self._repeated_groups()
        visits = groups * (2 * self.repeats + 1)
        fresh = self.setpoints(rig, self.captures - visits + 2 * groups)
        pairs = [(fresh[2 * group], fresh[2 * group + 1]) for group in range(groups)]
        return self._woven(pairs, fresh[2 * groups :])

    def _repeated_groups(self) -> int:
        """How many set-points can be repeated within the number of captures."""
        if self.repeats < 2:
            return 0
        return min(self.repeated, self.captures // (2 * self.repeats + 1))

    def _woven(
        self, pairs: list[tuple[Floats, Floats]], others: Floats
    ) -> list[tuple[tuple[float, ...], str]]:
        """Spread the visits evenly among the others: pairs of companion and set-point, then set-points alone."""
        blocks: list[list[tuple[Floats, str]]] = []
        for _ in range(self.repeats if pairs else 0):
            blocks += [
                [(before, f"r{n}-before"), (point, f"r{n}")] for n, (before, point) in enumerate(pairs, 1)
            ]
        blocks += [[(point, f"r{n}")] for n, (_, point) in enumerate(pairs, 1)]
        slots = np.linspace(0, len(others), len(blocks) + 2)[1:-1].round().astype(int)
        programme: list[tuple[Floats, str]] = []
        for index in range(len(others) + 1):
            for block in itertools.compress(blocks, slots == index):
                programme += block
            if index < len(others):
                programme.append((others[index], ""))
        return [(tuple(point.tolist()), label) for point, label in programme]

    def setpoints(self, rig: RigInfo, count: int) -> Floats:
        """`count` different set-points, kPa, shape (count, C)."""
        unit = _PATTERNS[self.pattern](count, len(rig.channels), rig.rng())
        limits = rig.min_kpa, rig.max_kpa
        return rounded(*limits, within(*limits, unit, self.lowest, self.highest))


def _random(count: int, chambers: int, rng: np.random.Generator) -> Floats:
    return rng.random((count, chambers))


def _halton(count: int, chambers: int, rng: np.random.Generator) -> Floats:
    from scipy.stats import qmc

    return qmc.Halton(chambers, scramble=True, rng=rng).random(count)


def _grid(count: int, chambers: int, rng: np.random.Generator) -> Floats:
    """The coarsest full grid with `count` points or more, of which `count` are drawn without repetition."""
    levels = 2
    while levels**chambers < count:
        levels += 1
    total = levels**chambers
    chosen = (
        rng.choice(total, size=count, replace=False) if total < 10**7 else _few_of_many(total, count, rng)
    )
    digits = chosen[:, None] // levels ** np.arange(chambers)[None, :] % levels
    return digits / (levels - 1)


def _corners(count: int, chambers: int, rng: np.random.Generator) -> Floats:
    """Every chamber at one end of its range; corners come again once all have been."""
    total = 2 ** min(chambers, 62)
    rounds = []
    while sum(map(len, rounds)) < count:
        wanted = min(total, count - sum(map(len, rounds)))
        few = total >= 10**7
        rounds.append(
            _few_of_many(total, wanted, rng) if few else rng.choice(total, size=wanted, replace=False)
        )
    chosen = np.concatenate(rounds) if rounds else np.zeros(0, np.int64)
    return (chosen[:, None] >> np.arange(chambers)[None, :] & 1).astype(float)


def _few_of_many(total: int, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """`count` different numbers below `total`, where listing all of them would be too many."""
    chosen: dict[int, None] = {}
    while len(chosen) < count:
        chosen.setdefault(int(rng.integers(total)))
    return np.array(list(chosen), np.int64)


_PATTERNS = {"random": _random, "halton": _halton, "grid": _grid, "corners": _corners}
