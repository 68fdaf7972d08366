"""When a campaign has said enough: settled, near enough, out of time, or not going to say it within its plan.

Probabilities of an exact Bayesian model stay calibrated whenever one stops (Berger and Wolpert, The Likelihood
Principle, 1988); ours are approximate, so that what must hold for a stop is measured (`labrig bench stopping`).
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from labrig._errors import LabrigError
from labrig._text import listed, word
from labrig.diagnosis import POSSIBLE, SURE
from labrig.live._look import Look
from labrig.tables import factor

STEADY = 2.0
"""A settled verdict must have stood while the campaign grew by this factor.

One settled look is not enough: on blind campaigns it misses effects that only later captures bring out. Factors from
1.25 to 4 were tried on the first 60 development campaigns of `labrig bench stopping`: from 1.7 on nothing is gained.
"""
MISSED = 0.01
"""At a stop no effect is less probable than this: the share of effects called out there that were hidden all the same
(4 of 564, same campaigns). They act later, or at pressures that were still to come, and no probability that is made
of what was measured knows of that."""
IN_A_ROW = 2
"""Looks in a row that must say the same for any other stop."""
_TREND = 4
"""Looks from which it is read how fast the verdict moves."""
_CLIP = 1e-3
_STILL = f"each of them {100 * MISSED:g} % for what was not seen yet"
_AMOUNT = re.compile(r"\s*([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*([A-Za-zµμ]*)\s*")


@dataclass(frozen=True)
class Rule:
    """What ends a campaign before its plan does.

    `settled`: once every effect is sure or ruled out, or one alone is left, or the rest of the plan would not settle
    it. `error`: at this held-out error, in `units`. `budget_s`: after this time of the rig, s.
    """

    settled: bool = False
    error: float | None = None
    units: str = ""
    budget_s: float | None = None
    steady: float = STEADY
    sure: float = SURE
    possible: float = POSSIBLE

    @classmethod
    def parse(cls, until: str = "", budget: str = "") -> "Rule":
        """The rule of `--until` (settled, or error=0.2mm) and `--budget` (45min); raises `LabrigError` otherwise."""
        budget_s = None
        if budget:
            amount, unit = _amount(budget, "--budget", "45min")
            budget_s = amount * factor(unit or "min", "s", "--budget")
        if until in ("", "settled"):
            return cls(until == "settled", budget_s=budget_s)
        name, _, value = until.partition("=")
        if name.strip() != "error" or not value:
            raise LabrigError(f"--until {until}: write settled, or an error such as error=0.2mm")
        amount, unit = _amount(value, "--until error", "error=0.2mm")
        if not unit:
            raise LabrigError(f"--until {until}: say the unit too, such as error=0.2mm")
        factor(unit, unit, "--until error")
        return cls(False, amount, unit, budget_s)

    def stop(self, looks: Sequence[Look], captures_left: int, spent_s: float, captures: int) -> str | None:
        """Why to end now, in words; None to go on.

        `spent_s` is the time that `captures` took, `captures_left` what the plan has still to come.
        """
        if self.budget_s is not None and captures and spent_s * (1 + 1 / captures) > self.budget_s:
            return f"out of time: the next capture would end after {self.budget_s / 60:.3g} min"
        if len(looks) < IN_A_ROW or captures_left <= 0:
            return None
        if self.error is not None:
            return self._near_enough(looks[-IN_A_ROW:])
        if not self.settled:
            return None
        if self._stands(looks):
            return f"settled: {self._settled_words(looks[-1])}"
        return self._hopeless(looks, captures_left)

    def _stands(self, looks: Sequence[Look]) -> bool:
        """Whether all looks since the campaign was shorter by the factor `steady` settle on the same."""
        began = sum(look.captures * self.steady <= looks[-1].captures for look in looks) - 1
        last = looks[began:]
        if began < 0 or len(last) < IN_A_ROW:
            return False
        return all(self.is_settled(look) for look in last) and len({self._said(look) for look in last}) == 1

    def at_a_stop(self, look: Look) -> dict[str, float]:
        """The probability of each effect where a campaign ended early: none is as sure to be out as it would be."""
        return {name: max(p, MISSED) for name, p in look.probability.items()}

    def _near_enough(self, last: Sequence[Look]) -> str | None:
        if self.error is None:
            return None
        wanted = self.error * factor(self.units, last[-1].units, "--until error")
        if all(look.error <= wanted for look in last):
            look = last[-1]
            return f"near enough: the held-out error is {look.error:.3g} {look.units}"
        return None

    def is_settled(self, look: Look) -> bool:
        """Whether every effect is sure or out, or only one name is left that no further evidence would make surer."""
        if not look.probability or look.verdict == "underpowered":
            return False
        left = self._open(look)
        return left == self._only(look) if left else look.verdict != "confounded"

    def _only(self, look: Look) -> list[str]:
        """The only name that is left, where the evidence is sure of it; else none."""
        named = [name for name, p in look.probability.items() if p >= self.possible]
        return named if len(named) == 1 and look.by_evidence.get(named[0], 0.0) > 1 - self.possible else []

    def _open(self, look: Look) -> list[str]:
        return [name for name, p in look.probability.items() if self.possible <= p < self.sure]

    def _said(self, look: Look) -> tuple[object, ...]:
        return look.verdict, frozenset(name for name, p in look.probability.items() if p >= self.possible)

    def _settled_words(self, look: Look) -> str:
        sure = [f"{word(name)} {p:.2f}" for name, p in look.probability.items() if p >= self.sure]
        if sure:
            return f"sure of {', '.join(sure)}; all other effects are out ({_STILL})"
        for name in self._only(look):
            perhaps = (
                f"perhaps {word(name)} ({look.probability[name]:.2f}, or an effect that labrig does not know)"
            )
            return f"{perhaps}; all other effects are out ({_STILL})"
        if look.verdict == "unknown":
            return f"something is missing, and all effects with a name are out ({_STILL})"
        return f"all effects are out ({_STILL})"

    def _hopeless(self, looks: Sequence[Look], captures_left: int) -> str | None:
        """Even at the fastest pace seen lately, the slowest open effect would take longer than the plan does."""
        needs = [self._needs(looks[: len(looks) - back]) for back in range(IN_A_ROW)]
        if any(need is None or need < captures_left for need in needs):
            return None
        left = self._open(looks[-1]) or ["the rest"]
        names = listed(left)
        need = needs[0]
        known = need is not None and math.isfinite(need)
        more = f"may take {need:.0f} captures more" if known else "no longer move" + "s" * (len(left) == 1)
        return (
            f"not worth the minutes: {names} {more}, the plan has {captures_left}; "
            "labrig next proposes other set-points"
        )

    def _needs(self, looks: Sequence[Look]) -> float | None:
        """Captures until the slowest open effect is sure or out, at its fastest pace lately; None: not known yet."""
        if len(looks) < _TREND or looks[-1].verdict == "underpowered" or self.is_settled(looks[-1]):
            return None
        needs = []
        for name in self._open(looks[-1]):
            odds = [_log_odds(look.probability.get(name, 0.0)) for look in looks[-_TREND:]]
            at = [look.captures for look in looks[-_TREND:]]
            pace = max(abs(odds[k + 1] - odds[k]) / max(at[k + 1] - at[k], 1) for k in range(_TREND - 1))
            way = min(_log_odds(self.sure) - odds[-1], odds[-1] - _log_odds(self.possible))
            needs.append(way / pace if pace > 0 else math.inf)
        return max(needs, default=None)


def _log_odds(p: float) -> float:
    p = min(max(p, _CLIP), 1 - _CLIP)
    return math.log(p / (1 - p))


def _amount(text: str, option: str, example: str) -> tuple[float, str]:
    found = _AMOUNT.fullmatch(text)
    if found is None or not float(found[1]) > 0:
        raise LabrigError(f"{option} {text}: write an amount with its unit, such as {example}")
    return float(found[1]), found[2]
