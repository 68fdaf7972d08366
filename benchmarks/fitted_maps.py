"""Campaigns of the blind benchmark beside a polynomial that is fitted to the run, as of a rig without a model: section
"Fitted maps".

    python benchmarks/fitted_maps.py [--seeds 3] [--first 88000010] [--workers 2] [--out benchmarks/RESULTS.md]

Of each portion from the third on: two campaigns with one effect that is no curve of the set-points, where one is drawn,
and one without any. The degree is two or three, as high as a third of the captures allows (else one).
"""

import tempfile
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from math import comb
from pathlib import Path

from benchmarks._by_hand import options, share
from labrig._errors import LabrigError
from labrig.bench._draw import draw
from labrig.bench._report import write_section
from labrig.model import Model
from tests.naming import verdict_of

PORTIONS = ("third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")
OF_MORE = {
    "creep",
    "delay",
    "drift",
    "frame",
    "friction",
    "gravity",
    "hysteresis",
    "leak",
    "marker_slip",
}
"""Effects that are no curves of the set-points."""
Case = tuple[str, int, str]


@dataclass(frozen=True)
class Found:
    """What was said of one campaign beside a map of a degree."""

    case: Case
    degree: int
    effects: frozenset[str]
    verdict: str
    names: frozenset[str]


def cases(first: int, seeds: int) -> list[Case]:
    """Classes, seeds and portions."""
    return [
        (kind, first + i + more, portion)
        for i in range(seeds)
        for kind, more in (("single", 0), ("single", 1000), ("null", 500))
        for portion in PORTIONS
    ]


def measured(case: Case) -> Found | None:
    """What is said of one campaign; nothing of an effect that a map could be."""
    warnings.simplefilter("ignore")
    try:
        campaign = draw(*case)
    except LabrigError:  # a portion without such a class
        return None
    effects = frozenset(campaign.truth["effects"])
    if not effects <= OF_MORE:
        return None
    C, n = campaign.dataset.sizes["chamber"], campaign.dataset.sizes["capture"]
    degree = max((d for d in (2, 3) if comb(C + d, d) <= n / 3), default=1)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        path = Path(name) / "model.yaml"
        path.write_text(f"base: {{kind: static, degree: {degree}}}\n")
        found = verdict_of(campaign.dataset, Model.load(path))
    print(*case, degree, *sorted(effects), "|", found.verdict, *found.effects, flush=True)
    return Found(case, degree, effects, found.verdict, frozenset(found.effects))


def table(rows: list[Found]) -> list[str]:
    """A line for each degree, and the sums."""
    out = [
        "| degree | campaigns | the effect is sure | another name sure beside it | nothing hidden: a name sure |",
        "|---|---|---|---|---|",
    ]
    for degree in ("1", "2", "3", "all"):
        own = [row for row in rows if degree in (str(row.degree), "all")]
        some, none = [row for row in own if row.effects], [row for row in own if not row.effects]
        there, wrong = (
            [row.effects <= row.names for row in some],
            [bool(row.names - row.effects) for row in some],
        )
        alarms = [bool(row.names) for row in none]
        shares = " | ".join(share(each) if each else "" for each in (there, wrong, alarms))
        out.append(f"| {degree} | {len(own)} | {shares} |")
    return out


def main() -> None:
    """Measure and write the section."""
    asked = options(seeds=3, first=88000010)
    with ProcessPoolExecutor(asked.workers) as pool:
        rows = [row for row in pool.map(measured, cases(asked.first, asked.seeds)) if row]
    how = (
        f"`python benchmarks/fitted_maps.py --first {asked.first} --seeds {asked.seeds}`: campaigns of the third to "
        "tenth portion beside a polynomial that is fitted to the run, as high in degree as a third of the captures "
        "allows; hidden is an effect of two to four floors beside the rig's own model, or nothing."
    )
    write_section(asked.out, "## Fitted maps", [how, "", *table(rows)])


if __name__ == "__main__":
    main()
