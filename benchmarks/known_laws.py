"""What would be named rightly if labrig knew the hidden law exactly: how much of what is wrong is the families'.

    python benchmarks/known_laws.py [--seed 19000000] [--out benchmarks/RESULTS.md] HALF:CLASS:N ...

Each blind campaign is judged as it is, and once more with the families of its hidden effects holding what they truly
change, as one more space of one function, as probable as each other space of its owner. Score, search, noise and all
other families stay. With a law that is known but for its parameters a laboratory would be between the two. Of
`structural` campaigns it is also asked what would be named on a base without its error of form.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from _hidden import at_rows

from labrig.arrays import Floats
from labrig.bench._draw import Campaign, draw
from labrig.bench._files import write_model
from labrig.bench._intervals import wilson
from labrig.bench._judge import is_right, wrongly_sure
from labrig.bench._report import write_section
from labrig.diagnosis._diagnose import laid_out, verdict_on
from labrig.diagnosis._problem import Prepared, prepared, rows_from
from labrig.effects import Context, Effect, Space, field
from labrig.model import Model

AS_IS, KNOWN, EXACT = "as it is", "the law known", "a base of right form"
CLASSES = ("single", "single-1", "static", "pair", "structural")
"""Classes in which what is hidden has a name in the library."""
Judged = dict[str, tuple[bool, bool]]


class Knowing:
    """An effect whose family also holds one change (F, K)."""

    def __init__(self, effect: Effect, change: Floats) -> None:
        self._effect, self._change = effect, change

    def __getattr__(self, name: str) -> Any:
        return getattr(self._effect, name)

    def family(self, context: Context) -> Iterator[Space]:
        """The family, and the truth."""
        yield from self._effect.family(context)
        yield Space("the truth", "the truth", (field("the truth", self._change),))


def judged(campaign: Campaign, ready: Prepared, effects: dict[str, Effect]) -> tuple[bool, bool]:
    """Whether the verdict is right, and whether a wrong name is sure."""
    verdict = verdict_on(*laid_out(ready, effects), effects)
    answer: Any = {
        "verdict": verdict.verdict,
        "effects": list(verdict.effects),
        "rivals": list(verdict.rivals),
        "effects_considered": [
            {"effect": c.effect, "probability": c.probability} for c in verdict.considered
        ],
    }
    return is_right(campaign.truth, answer), bool(wrongly_sure(campaign.truth, answer))


def asked(campaign: Campaign) -> tuple[Prepared, dict[str, Effect]]:
    """A campaign as a diagnosis gets it, and the library that it may use."""
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        ready = prepared(rows_from(campaign.dataset), model)
    return ready, {n: e for n, e in model.library().items() if n not in campaign.truth["without"]}


def one(half: str, name: str, seed: int) -> Judged:
    """Each way of asking about one campaign."""
    campaign = draw(name, seed, half)
    ready, effects = asked(campaign)
    knowing: Any = dict(effects)
    for effect, change in campaign.parts.items():
        knowing[effect] = Knowing(effects[effect], at_rows(campaign, change))
    out = {AS_IS: judged(campaign, ready, effects), KNOWN: judged(campaign, ready, knowing)}
    if campaign.truth["structural"] and campaign.base:
        campaign.base = {**campaign.base, "kind": "exact", "seed": 0}
        out[EXACT] = judged(campaign, *asked(campaign))
    return out


def table(found: dict[str, list[Judged]]) -> list[str]:
    """A line for each class: right, and with a wrong name sure, by how it was asked."""
    out = ["| class | campaigns | | right | a wrong name sure |", "|---|---|---|---|---|"]
    for name, rows in found.items():
        for way in rows[0]:
            right, wrong = (sum(row[way][i] for row in rows) for i in (0, 1))
            low, high = wilson(right, len(rows))
            out.append(f"| {name} | {len(rows)} | {way} | {right} ({low:.0%} to {high:.0%}) | {wrong} |")
    return out


def main() -> None:
    """Draw, judge, print, and write the section."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", nargs="+", metavar="HALF:CLASS:N")
    parser.add_argument("--seed", type=int, default=19_000_000)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    found: dict[str, list[Judged]] = {}
    for what in given.what:
        half, name, count = what.split(":")
        if name not in CLASSES:
            parser.error(f"the laws of class '{name}' can't be made known (choose from {', '.join(CLASSES)})")
        found.setdefault(name, []).extend(
            one(half, name, seed) for seed in range(given.seed, given.seed + int(count))
        )
    how = f"`python benchmarks/known_laws.py --seed {given.seed} {' '.join(given.what)}`"
    lines = [f"{how}: right verdicts with their 95 % intervals, and campaigns with a wrong name sure.", ""]
    lines += table(found)
    print("\n".join(lines))
    if given.out:
        write_section(given.out, "## If each law were known", lines)


if __name__ == "__main__":
    main()
