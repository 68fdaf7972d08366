"""How much a name is to be trusted: what evidence says of names in drawn campaigns, and whether they were there."""

import json
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.bench._draw import draw
from labrig.bench._files import write_model
from labrig.bench._lines import each_once, read_lines
from labrig.diagnosis import Calibration, considered, log_odds
from labrig.model import Model

UNLEARNT = ("eighth", "ninth", "tenth", "eleventh", "twelfth")
"""The portions whose laws are in no spectrum (`labrig bench learn`)."""
MIX = (
    *("single", "pair", "single", "structural", "single", "outside"),
    *("single", "pair", "structural", "deleted", "single", "outside", "null-slow"),
)
"""The classes of campaigns, one after another and again from the first."""
_SPREAD = 1.0
"""Prior sd of what an effect adds to the log odds: of 0.3, 0.5, 1 and 2 the best on portions left out, by little."""
_LOOSE = 10.0
"""Prior sd of all else: none, nearly."""


@dataclass(frozen=True)
class Said:
    """What evidence says of one name in one campaign, and whether it was there."""

    half: str
    effect: str
    by_evidence: float
    share: float
    there: bool


def calibration_plan(count: int, seed: int, halves: Sequence[str] = UNLEARNT) -> list[tuple[str, int, str]]:
    """(class, seed, portion) of `count` campaigns of each portion."""
    return planned(MIX, count, seed, halves)


def planned(mix: Sequence[str], count: int, seed: int, halves: Sequence[str]) -> list[tuple[str, int, str]]:
    """(class, seed, half) of `count` campaigns of each half: the classes of a `mix`, again from the first."""
    return [(mix[i % len(mix)], seed + i, half) for i in range(count) for half in halves]


def run_calibrate(
    todo: Sequence[tuple[str, int, str]], names: Path, jobs: int = 2, resume: bool = False
) -> Iterator[list[Said]]:
    """Draw and weigh each campaign, `jobs` at a time; yield what is said of its names as it is done and written to the
    file of `names`, a line for each campaign.

    With `resume`, campaigns that are in the file already are yielded first, as they were. Raises `LabrigError` if there
    is such a file and `resume` is not set: it may be of another release.
    """
    known = _known(names)
    if known and not resume:
        raise LabrigError(f"{names} holds the names of {len(known)} campaigns: add --resume, or remove it")
    for said in each_once(todo, names, _as_kept, jobs):
        yield [Said(**one) for one in said]


def _as_kept(task: tuple[str, int, str]) -> list[dict[str, Any]]:
    return [asdict(one) for one in said_of(task)]


def _known(names: Path) -> dict[tuple[str, int, str], list[Said]]:
    """What a file says of the names of each campaign; raises `LabrigError` where another release wrote it."""
    try:
        return {
            (name, seed, half): [Said(**one) for one in said]
            for (name, seed, half), said in read_lines(names)
        }
    except (TypeError, ValueError):
        raise LabrigError(f"{names} is of another release: remove it") from None


def said_of(task: tuple[str, int, str]) -> list[Said]:
    """What evidence says of each effect that it does not rule out; names that the base's own error may go by are left
    out.
    """
    campaign = draw(*task)
    truth = campaign.truth
    with tempfile.TemporaryDirectory(prefix="labrig-bench-", ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        found = considered(campaign.dataset, model, truth["without"])
    return [
        Said(task[2], c.effect, c.by_evidence, c.share, c.effect in truth["effects"])
        for c in found
        if c.probability > 0 and c.effect not in (truth.get("also") or ())
    ]


def fitted(said: Sequence[Said]) -> Calibration:
    """The logistic regression of what was there on what was said, with what effects add shrunk towards nothing."""
    effects = sorted({one.effect for one in said})
    common = np.array([[1.0, log_odds(one.by_evidence), one.share] for one in said])
    name = np.array([[float(one.effect == e) for e in effects] for one in said])
    evidence, y = np.array([[one.by_evidence, one.there] for one in said], dtype=float).T
    sd = np.array([_LOOSE] * 3 + [_SPREAD] * len(effects))

    def cost(w: Floats) -> tuple[float, Floats]:
        own = np.where(w[3:] > 0, evidence[:, None], 1.0) * name  # as `Calibration.of_name` has it
        A = np.concatenate([common, own], axis=1)
        z = A @ w
        value = np.sum(np.logaddexp(0, z) - y * z) + 0.5 * np.sum((w / sd) ** 2)
        return float(value), A.T @ (expit(z) - y) + w / sd**2

    w = minimize(cost, np.zeros(len(sd)), jac=True, method="L-BFGS-B").x
    always, odds, share, *own = (round(float(x), 3) for x in w)
    return Calibration(always, odds, share, dict(zip(effects, own, strict=True)))


def surprise(said: Sequence[Said]) -> tuple[float, float]:
    """Minus the log likelihood of what was there: by evidence alone, and calibrated with each portion left out."""
    alone = calibrated = 0.0
    for half in {one.half for one in said}:
        learnt = fitted([one for one in said if one.half != half])
        for one in (one for one in said if one.half == half):
            sign = 1.0 if one.there else -1.0
            alone += float(np.logaddexp(0, -sign * log_odds(one.by_evidence)))
            p = learnt.of_name(one.effect, one.by_evidence, one.share)
            calibrated -= float(np.log(p if one.there else 1 - p))
    return alone, calibrated


def write_calibration(said: Sequence[Said], path: Path, how: str) -> None:
    """Fit and write the file that labrig ships."""
    content = {"how": how, "names": len(said)} | asdict(fitted(said))
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
