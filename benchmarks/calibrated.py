"""What calibrated probabilities are worth on laws that they were not learnt from, and what each limit of sure gives.

    python benchmarks/calibrated.py [--n 150] [--seed 94000000]

The campaigns of `labrig bench calibrate`. Each portion is judged by what was learnt from the others. The limit was
chosen by what it means (`SURE`); this says what it costs, and what others would.
"""

import argparse
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from labrig.bench import calibration_plan, draw, write_model
from labrig.bench._calibrate import Said, fitted, surprise
from labrig.bench._intervals import wilson
from labrig.bench._judge import calibration_error, is_right
from labrig.bench.records import Answer as Told
from labrig.diagnosis import Calibration, _verdict, prepared, rows_from
from labrig.diagnosis import _constants as k
from labrig.diagnosis._answers import Answer, answers_of
from labrig.diagnosis._diagnose import laid_out, words_of
from labrig.diagnosis._posterior import Search
from labrig.diagnosis._verdict import decide
from labrig.model import Model

LIMITS = (0.6, 0.65, 0.7, 0.75, 0.8, 0.85)


@dataclass(frozen=True)
class Weighed:
    """A campaign: what is hidden, and all explanations as answers."""

    half: str
    truth: dict[str, Any]
    answers: Sequence[Answer]
    effects: tuple[str, ...]
    words: dict[str, str]

    def said(self) -> list[Said]:
        """What the evidence says of each name, and whether it is there."""
        found = decide(self.answers, self.effects, self.words).considered
        also = self.truth.get("also") or ()
        there = self.truth["effects"]
        return [
            Said(self.half, c.effect, c.by_evidence, c.share, c.effect in there)
            for c in found
            if c.probability > 0 and c.effect not in also
        ]


def weighed(name: str, seed: int, half: str) -> Weighed:
    """Draw a campaign, and weigh all explanations."""
    campaign = draw(name, seed, half)
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        effects = {n: e for n, e in model.library().items() if n not in campaign.truth["without"]}
        _, _, design = laid_out(prepared(rows_from(campaign.dataset), model), effects)
        assert design is not None
        answers = answers_of(Search(design).run(), 0.0, {n for n, e in effects.items() if e.remembers})
    return Weighed(half, dict(campaign.truth), answers, tuple(effects), words_of(design))


def judged(campaigns: Iterable[Weighed], learnt: dict[str, Calibration], limit: float) -> Counter:
    """What is right, and what is called sure and is not there, with each portion's calibration and a limit of sure."""
    count: Counter = Counter()
    usual, sure = _verdict.shipped, k.SURE
    k.SURE = limit
    try:
        for one in campaigns:
            _verdict.shipped = lambda one=one: learnt[one.half]
            found = decide(one.answers, one.effects, one.words)
            told: Told = {
                "verdict": found.verdict,
                "effects": list(found.effects),
                "rivals": list(found.rivals),
            }
            hidden, also = set(one.truth["effects"]), set(one.truth.get("also") or ())
            names = {c.effect for c in found.considered if c.call == "sure"}
            right = is_right(one.truth, told)  # pyright: ignore[reportArgumentType]
            for what, value in (
                ("of", 1),
                ("right", right),
                ("wrong", bool(names - hidden - also)),
                ("sure", len(names - also)),
                ("there", len(names & hidden)),
                ("hidden", len(hidden)),
            ):
                count[what] += value
                count[one.truth["class"], what] += value
    finally:
        _verdict.shipped, k.SURE = usual, sure
    return count


def report(campaigns: Sequence[Weighed]) -> list[str]:
    """The lines to print."""
    said = [one for campaign in campaigns for one in campaign.said()]
    halves = sorted({c.half for c in campaigns})
    learnt = {h: fitted([one for one in said if one.half != h]) for h in halves}
    alone, left_out = surprise(said)
    p = np.array([learnt[one.half].of_name(one.effect, one.by_evidence, one.share) for one in said])
    there = [one.there for one in said]
    raw = [one.by_evidence for one in said]
    out = [
        f"{len(campaigns)} campaigns, {len(said)} names; minus log likelihood {alone:.0f} by evidence, {left_out:.0f} "
        f"calibrated on other portions; calibration error {calibration_error(raw, there):.3f}, "
        f"{calibration_error(list(p), there):.3f}"
    ]
    for low in np.arange(0.0, 1.0, 0.1):
        own = [t for q, t in zip(p, there, strict=True) if low <= q < low + 0.1]
        if own:
            a, b = wilson(sum(own), len(own))
            out.append(
                f"  stated {low:.1f} to {low + 0.1:.1f}: {sum(own)} of {len(own)} there ({a:.0%} to {b:.0%})"
            )
    for limit in LIMITS:
        c = judged(campaigns, learnt, limit)
        kinds = [key[0] for key in c if isinstance(key, tuple) and key[1] == "of"]
        each = ", ".join(f"{n} {c[n, 'right']} of {c[n, 'of']} ({c[n, 'wrong']})" for n in kinds)
        out.append(
            f"sure from {limit}: right {c['right']} of {c['of']}, a wrong name sure {c['wrong']}, sure names there "
            f"{c['there']} of {c['sure']}, of hidden {c['hidden']}; {each}"
        )
    return out


def main() -> None:
    """Draw, weigh, and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--n", type=int, default=150)
    parser.add_argument("--seed", type=int, default=94_000_000)
    given = parser.parse_args()
    print("\n".join(report([weighed(*task) for task in calibration_plan(given.n, given.seed)])))


if __name__ == "__main__":
    main()
