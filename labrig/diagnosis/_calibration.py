"""How probable a name is, given what the evidence says: learnt from campaigns whose laws are in no spectrum.

Evidence takes for granted that each law is of one of the families, which no law quite is, so it says too much, and of
some names more than of others: what holds many functions holds other effects' laws too, and a small part of what there
is to explain is often what is left of another part. Both were counted, and a logistic regression says what they make of
the odds (J. Platt 1999; with an intercept for each effect, shrunk towards a common one, as in A. Gelman, J. Hill, Data
Analysis Using Regression and Multilevel/Hierarchical Models, 2007, ch. 14).
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.special import expit, logit

from labrig.diagnosis._constants import NEGLIGIBLE

FILE = Path(__file__).with_name("calibration.json")


@dataclass(frozen=True)
class Calibration:
    """The log odds of a name: `always`, `effects` more, `odds` times those by evidence, `share` times its share.

    What speaks for an effect counts as far as evidence says that it is there: a name that was right each time it had
    evidence is no likelier than others where it has none.
    """

    always: float
    odds: float
    share: float
    effects: Mapping[str, float]
    """What is added for each effect; nothing for one that was not counted, such as one's own."""

    def of_name(self, effect: str, by_evidence: float, share: float, gone: float = 0.5) -> float:
        """Probability that an effect is there to which evidence gives a probability, and which would be missed by a
        share (root mean square) of what there is to explain; zero where evidence is negligible, and never more than a
        half where evidence says less, nor more than evidence where that says more.

        `gone`: how probable it is, by evidence, that what it explains is gone where it was ruled out, and not something
        else that stays; a half where nothing says so. Its odds multiply those of the name.
        """
        if by_evidence < NEGLIGIBLE:
            return 0.0
        own = self.effects.get(effect, 0.0)
        own = self.always + min(own, own * by_evidence)
        found = expit(own + self.odds * log_odds(by_evidence) + self.share * share + log_odds(gone))
        return min(float(found), max(by_evidence, 0.5))

    def at_most(self, effect: str) -> float:
        """How probable a name can be at all, whatever the evidence, where nothing else is there."""
        return self.of_name(effect, 1 - NEGLIGIBLE, 1.0)

    def stated(self, probability: float) -> float:
        """A probability of anything else as it is stated: its odds count as much as those of a name do."""
        return 0.0 if probability < NEGLIGIBLE else float(expit(self.odds * log_odds(probability)))


def log_odds(probability: float) -> float:
    """The logarithm of the odds, of what the sums over explanations can tell from zero and one."""
    return float(logit(np.clip(probability, NEGLIGIBLE, 1 - NEGLIGIBLE)))


@cache
def shipped() -> Calibration:
    """What was learnt (`labrig bench calibrate`)."""
    content = json.loads(FILE.read_text(encoding="utf-8"))
    return Calibration(**{name: content[name] for name in ("always", "odds", "share", "effects")})
