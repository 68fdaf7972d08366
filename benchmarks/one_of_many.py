"""Effects in one chamber of four or eight, and in one sensor of two, by laws that labrig does not have: "One of many".

    python benchmarks/one_of_many.py [--seeds 2] [--first 0] [--workers 2] [--out benchmarks/RESULTS.md]

On the laboratory of the tests. A campaign is right where the effect is named and nothing else; where nothing is hidden,
where nothing is named.
"""

import tempfile
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks._by_hand import options, share
from labrig.bench._report import write_section
from tests.conftest import Lab
from tests.laws import Law, bowed, limited, of_one, orifice, power_law, sliding, stretched, strut
from tests.naming import verdict_of
from tests.sensors import model_of_both, two_sensors

if TYPE_CHECKING:
    from labrig.diagnosis._verdict import Verdict

CHAMBER, SENSOR = "one chamber of four or eight", "one sensor of two"
AT_ONCE, TWICE, LONGER = (3.0,), (3.0, 3.5), (1.0, 3.0, 8.0)
BENT = (0.0, 0.8)
"""Walls that give way in proportion, and walls that level off."""
HIDDEN: dict[str, tuple[str, Law | None]] = {
    "Bouc-Wen loop": ("hysteresis", partial(Lab.looped, size_kpa=5.0)),
    "Dahl's friction": ("friction", sliding),
    "creep by a power law": ("creep", power_law),
    "lag by a stretched exponential": ("delay", stretched),
    "leak through an orifice": ("leak", orifice),
    "bowed sensor": ("regulator", bowed),
    "wall that stiffens": ("stiffening", limited),
    "strut at a third": ("contact", strut),
    "strut at six tenths": ("contact", partial(strut, share=0.6)),
    "nothing": ("", None),
}
"""The effect of each law, and the law."""
SEEN = {
    CHAMBER: tuple(law for law in HIDDEN if law != "lag by a stretched exponential"),
    SENSOR: (*tuple(HIDDEN)[:4], "nothing"),
}
"""What is hidden where; a sensor alone has what a pressure would not have for all."""


@dataclass(frozen=True)
class Case:
    """One campaign of 60 set-points."""

    where: str
    law: str
    chambers: int
    bent: float
    rows_s: tuple[float, ...]
    seed: int


@dataclass(frozen=True)
class Found:
    """What was said of it."""

    case: Case
    verdict: str
    names: frozenset[str]

    @property
    def right(self) -> bool:
        """Whether what is hidden is named, and nothing else."""
        effect, _ = HIDDEN[self.case.law]
        return self.names == {effect} if effect else self.verdict == "nothing_missing"

    @property
    def wrong(self) -> bool:
        """Whether a name is sure that is not there."""
        return bool(self.names - {HIDDEN[self.case.law][0]})

    @property
    def said(self) -> str:
        """The verdict in words."""
        return " ".join([self.verdict, " + ".join(sorted(self.names))]).strip()


def cases(seeds: range) -> list[Case]:
    """All of them."""
    one = product([CHAMBER], SEEN[CHAMBER], (4, 8), BENT, (TWICE, LONGER), seeds)
    two = product([SENSOR], SEEN[SENSOR], (2, 3), BENT, (AT_ONCE, LONGER), seeds)
    every = [Case(*values) for values in (*one, *two)]
    # a lag that is over says nothing at one moment
    return [case for case in every if HIDDEN[case.law][0] != "delay" or case.rows_s != AT_ONCE]


def measured(case: Case) -> Found:
    """What is said of one campaign."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        found = (_in_one_chamber if case.where == CHAMBER else _in_one_sensor)(case, Path(name))
    out = Found(case, found.verdict, frozenset(found.effects))
    print(case, out.said, "" if out.right else "(not right)", flush=True)
    return out


def _in_one_chamber(case: Case, folder: Path) -> "Verdict":
    lab = Lab(
        folder,
        chambers=case.chambers,
        markers=8,
        captures=60,
        rows_s=case.rows_s,
        bent=case.bent,
        seed=case.seed,
    )
    law = HIDDEN[case.law][1]
    values = of_one(lab, law, case.seed % case.chambers) if law else lab.predict(lab.u) + lab.noise()
    return verdict_of(lab.dataset(values), lab.model())


def _in_one_sensor(case: Case, folder: Path) -> "Verdict":
    lab = Lab(
        folder,
        force=True,
        chambers=case.chambers,
        captures=60,
        rows_s=case.rows_s,
        repeats=False,
        bent=case.bent,
        seed=case.seed,
    )
    law = HIDDEN[case.law][1]
    force = lab.predict(law(lab) if law else lab.u) + lab.noise()
    voltage = lab.predict(lab.u) + lab.noise()
    return verdict_of(two_sensors(lab, force, voltage), model_of_both(lab))


def table(rows: list[Found]) -> list[str]:
    """A line for each law and place, and the sums."""
    out = ["| in | law | right | a wrong name sure | said |", "|---|---|---|---|---|"]
    for where, laws in SEEN.items():
        for law in laws:
            own = [row for row in rows if (row.case.where, row.case.law) == (where, law)]
            count = {said: sum(row.said == said for row in own) for said in {row.said for row in own}}
            words = "; ".join(
                f"{n} x {said}" for said, n in sorted(count.items(), key=lambda one: (-one[1], one[0]))
            )
            right, wrong = sum(row.right for row in own), sum(row.wrong for row in own)
            out.append(f"| {where} | {law} | {right} of {len(own)} | {wrong} | {words} |")
    out.append("")
    for where in SEEN:
        own = [row for row in rows if row.case.where == where and HIDDEN[row.case.law][0]]
        right, wrong = (share([getattr(row, a) for row in own]) for a in ("right", "wrong"))
        out.append(f"An effect in {where}: right {right}; a wrong name sure {wrong}.")
    return out


def main() -> None:
    """Measure and write the section."""
    asked = options(seeds=2, first=0)
    with ProcessPoolExecutor(asked.workers) as pool:
        rows = list(pool.map(measured, cases(range(asked.first, asked.first + asked.seeds))))
    how = (
        f"`python benchmarks/one_of_many.py --first {asked.first} --seeds {asked.seeds}`: 60 set-points anywhere. "
        "In a chamber an effect has three times the noise, seen by eight markers; of the two sensors (no repeats) "
        "a force has it and a voltage has none."
    )
    write_section(asked.out, "## One of many", [how, "", *table(rows)])


if __name__ == "__main__":
    main()
