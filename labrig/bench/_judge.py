"""Was the verdict right? And how good is it to know its probability?"""

from collections.abc import Sequence

import numpy as np

from labrig.bench.records import Answer, Truth
from labrig.diagnosis import SURE


def is_right(truth: Truth, answer: Answer) -> bool:
    """Whether the verdict and its names are those of the truth.

    Identified and multiple need exactly the hidden effects; where the base has a wrong law of its own, `also` has
    the names that this may go by beside them. Confounded must have the hidden effect among those that it cannot
    tell apart. For nothing_missing underpowered will do too, which claims no effect.
    """
    hidden, verdict = set(truth["effects"]), answer["verdict"]
    if truth["verdict"] == "nothing_missing":
        return verdict in ("nothing_missing", "underpowered")
    if truth["verdict"] == "confounded":
        return verdict == "confounded" and hidden <= named(answer)
    if truth["verdict"] == "unknown":
        return verdict == "unknown"
    if truth.get("also"):
        effects = set(answer["effects"])
        return verdict in ("identified", "multiple") and hidden <= effects <= hidden | set(truth["also"])
    return verdict == truth["verdict"] and set(answer["effects"]) == hidden


def is_near(truth: Truth, answer: Answer) -> bool:
    """Whether everything hidden is among the names in the answer, rivals and surplus ones included."""
    return bool(truth["effects"]) and set(truth["effects"]) <= named(answer)


def is_false_alarm(truth: Truth, answer: Answer) -> bool:
    """Whether something is claimed where nothing is hidden."""
    return not truth["effects"] and answer["verdict"] not in ("nothing_missing", "underpowered")


def named(answer: Answer) -> set[str]:
    """All effects that an answer names, rivals included."""
    names = set(answer["effects"])
    for rival in answer.get("rivals") or []:
        if isinstance(rival, str):
            names.add(rival)
        elif isinstance(rival, dict):
            names |= {rival["effect"]} if "effect" in rival else set(rival.get("effects", []))
        else:
            names |= set(rival)
    return names


def probabilities(answer: Answer) -> dict[str, float] | None:
    """The probability of each effect that was considered; none of a crash, None where an answer does not give any."""
    entries = answer.get("effects_considered", [] if answer["verdict"] == "error" else None)
    if entries is None:
        return None
    return {entry["effect"]: float(entry["probability"]) for entry in entries}


def called(answer: Answer, least: float) -> set[str] | None:
    """Effects that an answer gives at least that probability; None where it does not give any."""
    known = probabilities(answer)
    return None if known is None else {name for name, probability in known.items() if probability >= least}


def wrongly_sure(truth: Truth, answer: Answer) -> set[str]:
    """Effects that an answer calls sure, by its verdict or by their probability, and that are not there.

    `confounded` names what is possible, so its names are not called sure.
    """
    by_verdict = set(answer["effects"]) if answer["verdict"] in ("identified", "multiple") else set()
    sure = by_verdict | (called(answer, SURE) or set())
    return sure - set(truth["effects"]) - set(truth.get("also") or [])


def brier(probability: Sequence[float], right: Sequence[bool]) -> float:
    """Mean square of (probability - outcome)."""
    return float(np.mean((np.asarray(probability) - np.asarray(right, dtype=float)) ** 2))


def calibration_error(probability: Sequence[float], right: Sequence[bool], bins: int = 10) -> float:
    """Expected calibration error: |mean probability - share right| over `bins` equal bins, weighted by their
    size.
    """
    p, y = np.asarray(probability, dtype=float), np.asarray(right, dtype=float)
    which = np.minimum((p * bins).astype(int), bins - 1)
    gaps = [np.sum(which == k) * abs(p[which == k].mean() - y[which == k].mean()) for k in np.unique(which)]
    return float(np.sum(gaps) / len(p))


def label(verdict: str, effects: Sequence[str]) -> str:
    """How a truth or an answer appears in the confusion matrix: the effect if one is identified, else the
    verdict.
    """
    return effects[0] if verdict == "identified" and len(effects) == 1 else verdict
