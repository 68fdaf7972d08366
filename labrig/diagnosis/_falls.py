"""By how much an effect that was added lowers the held-out error, in the unit in which it lowers it most."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from labrig.diagnosis._amount import amount
from labrig.diagnosis._candidates import Candidate, Fit, fit, mean_square, quoted
from labrig.diagnosis._constants import LEAST_FLOORS
from labrig.diagnosis._score import relative_error

_MUCH_LEFT, _TIMES_NOISE = 0.2, 2.0
"""Of the error before, and of the noise: what is left beside names from which on it is said. It decides words only."""


@dataclass(frozen=True)
class Fall:
    """By how much an effect lowers the held-out error beside the others that were added with it.

    `fall`, its standard error `se`, the `least` that matters and the error `before` are mean squares, in squared
    `units`; of sensors of several units, those of the unit in which the effect acts most.
    """

    effect: str
    fall: float
    se: float
    least: float
    units: str
    before: float

    @property
    def helps(self) -> bool:
        """Whether it is more than its standard error, and than what matters."""
        return self.fall > self.se and self.fall >= self.least

    @property
    def words(self) -> str:
        """By how much the root mean square falls, and by how much it would have to; or how uncertain that is, where
        that matters. The difference of two errors as they are drawn beside it, and not the root of that of squares.
        """
        by = f"by {amount(self._drop(self.fall), self.units)}, "
        if self.fall < self.least:
            return f"{by}needed {amount(self._drop(min(self.least, self.before)), self.units)}"
        left = max(self.before - self.fall, 0.0)
        se = self.se / max(float(np.sqrt(self.before) + np.sqrt(left)), 1e-300)
        return f"{by}with a standard error of {amount(se, self.units)}"

    def _drop(self, fall: float) -> float:
        """What a fall of the mean square is as one of its root, of either sign."""
        return float(np.sqrt(self.before) - np.sqrt(max(self.before - fall, 0.0)))


def falls_of(chosen: Fit | None, names: Collection[str]) -> list[Fall]:
    """The fall of each of these effects that is in a fit, beside all others of that fit."""
    return [fall_of(chosen, i) for i, name in enumerate(chosen.names) if name in names] if chosen else []


def takes_most(found: Mapping[str, Sequence[Candidate]], idle: Collection[str]) -> list[str]:
    """The effect that by itself lowers the held-out error most, in its best form of those `found`; none where none but
    the `idle` ones does.
    """
    falls = [fall_of(forms[0].alone, 0) for name, forms in found.items() if name not in idle]
    helping = [fall for fall in falls if fall.helps]
    return [max(helping, key=lambda f: f.fall / f.least).effect] if helping else []


def fall_of(chosen: Fit, i: int, fit: Callable[[Sequence[Candidate]], Fit] = fit) -> Fall:
    """By how much the i-th effect of a fit lowers the held-out mean square beside the others, which are fitted again by
    `fit`.
    """
    regression = chosen.columns.regression
    rest = [p for j, p in enumerate(chosen.parts) if j != i]
    others = fit(rest) if rest else None
    left = others.left if others else regression.base_left
    gains = regression.gains(left, chosen.left)
    relative_se = relative_error(gains)
    before = mean_square(regression, left)
    fallen = before - mean_square(regression, chosen.left)
    units, noise = regression.context.rows.unit, regression.floor.row**2
    falls = []
    for unit in dict.fromkeys([regression.units, *units]):
        own = np.array([each == unit for each in units]) & np.isfinite(fallen)
        if own.any():
            fall = float(fallen[own].mean())
            falls.append(
                Fall(
                    effect=chosen.parts[i].effect.name,
                    fall=fall,
                    se=abs(fall) * relative_se,
                    least=LEAST_FLOORS**2 * float(noise[own].mean()),
                    units=unit,
                    before=float(before[own].mean()),
                )
            )
    return max(falls, key=lambda f: f.fall / f.least)


def beside_named(chosen: Fit | None, possible: Sequence[Candidate], units: str) -> list[str]:
    """A line for each possible effect that would lower the held-out error beside what is named: what it would be."""
    out: list[str] = []
    if chosen is None:
        return out
    for one in possible:
        both = fit([*chosen.parts, one])
        left, before = f"{quoted(both):.2g}", quoted(chosen)
        if fall_of(both, len(both.parts) - 1).helps and left != f"{before:.2g}":
            out.append(
                f"{one.effect.name} is possible beside {' and '.join(chosen.names)}: with it, too, {left} instead of "
                f"{amount(before, units)} are left on captures that were left out"
            )
    return out


def much_left(names: Sequence[str], base: float, model: float, floor: float, units: str) -> list[str]:
    """A line where the held-out error is far from the noise with all that was named (root mean squares)."""
    if not names or model < max(_MUCH_LEFT * base, _TIMES_NOISE * floor):
        return []
    return [
        f"with {' and '.join(names)} added, {model:.2g} of {amount(base, units)} are left on captures that were left "
        f"out, {model / floor:.2g} times the noise: the law is another one of its kind, or more is missing than was "
        "named"
    ]
