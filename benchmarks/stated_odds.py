"""What each power of the odds at which probabilities are stated makes of the same explanations.

    python benchmarks/stated_odds.py [--half eighth ...] [--n 100] [--seed 90000000]

Campaigns of laws that are in no spectrum. Of each class there are as many as stands in CLASSES, for each hundred. The
power was chosen so, on every second pair, every third structural one, and so forth, of the same seeds.
"""

import argparse
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from labrig.bench._draw import draw
from labrig.bench._files import write_model
from labrig.bench._judge import SURE, is_right, wrongly_sure
from labrig.bench.records import Answer as Told
from labrig.diagnosis import _constants as k
from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._diagnose import laid_out, words_of
from labrig.diagnosis._posterior import Search
from labrig.diagnosis._verdict import answers_of, decide
from labrig.model import Model

CLASSES = {"single": 100, "pair": 50, "structural": 33, "outside": 25, "deleted": 25}
POWERS = (1.0, 0.7, 0.5)
_CERTAIN = 0.997
"""No statement counts as surer than this: one that is wrong would outweigh all others."""


def told(name: str, seed: int, half: str) -> tuple[dict, dict[float, Told]]:
    """What is hidden in a campaign, and what is said of it with each power."""
    campaign = draw(name, seed, half)
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        effects = {n: e for n, e in model.library().items() if n not in campaign.truth["without"]}
        _, _, design = laid_out(prepared(rows_from(campaign.dataset), model), effects)
        assert design is not None
        remembering = {n for n, e in effects.items() if e.remembers}
        answers = answers_of(Search(design).run(), 0.0, remembering)
    out: dict[float, Told] = {}
    for power in POWERS:
        k.ODDS_POWER = power
        found = decide(answers, tuple(effects), words_of(design))
        out[power] = {
            "verdict": found.verdict,
            "effects": list(found.effects),
            "rivals": list(found.rivals),
            "effects_considered": [
                {"effect": c.effect, "probability": c.probability} for c in found.considered
            ],
        }
    return dict(campaign.truth), out


def main() -> None:
    """Draw, diagnose, and print a table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--half", nargs="*", default=["eighth", "ninth", "tenth"])
    parser.add_argument("--n", type=int, default=100)
    parser.add_argument("--seed", type=int, default=90_000_000)
    given = parser.parse_args()
    counts, surprise = Counter(), dict.fromkeys(POWERS, 0.0)
    for half in given.half:
        for at, (name, share) in enumerate(CLASSES.items()):
            for i in range(round(given.n * share / 100)):
                truth, said = told(name, given.seed + 100 * at + i, half)
                hidden = set(truth["effects"])
                counts["campaigns"] += 1
                for power, answer in said.items():
                    counts[power, "right"] += is_right(truth, answer)  # pyright: ignore[reportArgumentType]
                    counts[power, "wrong"] += bool(wrongly_sure(truth, answer))  # pyright: ignore[reportArgumentType]
                    for entry in answer["effects_considered"]:
                        p, name_ = np.clip(entry["probability"], 1 - _CERTAIN, _CERTAIN), entry["effect"]
                        if name_ not in (truth.get("also") or ()):
                            surprise[power] -= float(np.log(p if name_ in hidden else 1 - p))
                        counts[power, "sure"] += name_ in hidden and entry["probability"] >= SURE
    print(f"{counts['campaigns']} campaigns")
    for power in POWERS:
        print(
            f"power {power}: right {counts[power, 'right']}, wrong name sure {counts[power, 'wrong']}, true effects "
            f"sure {counts[power, 'sure']}, minus log likelihood {surprise[power]:.0f}"
        )


if __name__ == "__main__":
    main()
