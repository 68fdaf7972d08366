"""What measurements are like in a laboratory, with nothing missing and with an effect: section "Conditions".

    python benchmarks/conditions.py [--seeds 3] [--first 0] [--workers 2] [--out benchmarks/RESULTS.md]

On the laboratory of the tests, by laws that labrig does not have: noise that is another for each axis or marker, a
frame that trembles, markers out of sight, that stand still or have others' names, chambers that miss set-points,
captures that were interchanged, rows few and far apart, sensors beside markers. A campaign is right where the effect is
named and nothing else; where nothing is hidden, where nothing is said to be missing, or what single captures were left
out for.
"""

import tempfile
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks._by_hand import options, share
from labrig.bench._report import write_section
from labrig.diagnosis._problem import ASTRAY
from tests.conftest import Lab
from tests.laws import Law, limited, orifice, power_law, sliding
from tests.naming import verdict_of
from tests.sensors import beside_markers

if TYPE_CHECKING:
    from xarray import Dataset

    from labrig.arrays import Floats
    from labrig.model import Model

MARKERS = 12
HIDDEN: dict[str, Law | None] = {
    "": None,
    "creep": power_law,
    "friction": sliding,
    "leak": orifice,
    "stiffening": limited,
}
"""What is hidden: nothing, or a law of an effect."""
Measured = Callable[[Lab, "Floats", "Floats", np.random.Generator], tuple["Dataset", "Model"]]


def _with_noise(times: "Floats | float" = 1.0) -> Measured:
    """Measured with so many times the usual noise of each coordinate (K,)."""

    def seen(
        lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator
    ) -> tuple["Dataset", "Model"]:
        return lab.dataset(lab.predict(u) + times * noise), lab.model()

    return seen


def _each(of_axis: "Floats | float" = 1.0, of_marker: "Floats | float" = 1.0) -> "Floats":
    """Times (K,) of each coordinate."""
    return (np.ones((MARKERS, 3)) * np.reshape(of_axis, (1, -1)) * np.reshape(of_marker, (-1, 1))).ravel()


def _trembling(
    lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator
) -> tuple["Dataset", "Model"]:
    """The frame is a third of a millimetre and a third of a degree elsewhere in each capture."""
    n, away = len(u), lab.rest_mm - lab.rest_mm.mean(axis=0)
    shift, turn = 0.3 * random.normal(size=(n, 1, 3)), 0.005 * random.normal(size=(n, 1, 3))
    moved = shift + np.cross(turn, away[None])
    return lab.dataset(lab.predict(u) + noise + moved.reshape(n, 1, -1)), lab.model()


def _shaken(lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator) -> tuple["Dataset", "Model"]:
    """The table stands 0.4 mm higher or lower in each capture."""
    up = np.zeros((len(u), 1, MARKERS, 3))
    up[..., 2] = 0.4 * random.normal(size=(len(u), 1, 1))
    return lab.dataset(lab.predict(u) + noise + up.reshape(len(u), 1, -1)), lab.model()


def _hidden(lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator) -> tuple["Dataset", "Model"]:
    """Every third marker is out of sight at high pressures, nine rows of ten."""
    values, load = lab.predict(u) + noise, lab.u.mean(axis=2)
    for m in range(0, MARKERS, 3):
        gone = (load > np.quantile(load, 0.6)) & (random.random(load.shape) < 0.9)
        values[gone, 3 * m : 3 * m + 3] = np.nan
    return lab.dataset(values), lab.model()


def _exchanged(
    lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator
) -> tuple["Dataset", "Model"]:
    """In a tenth of the captures two markers have each other's names, others each time."""
    values = (lab.predict(u) + noise).reshape(*u.shape[:2], MARKERS, 3)
    for i in random.choice(len(u), len(u) // 10, replace=False):
        a, b = random.choice(MARKERS, 2, replace=False)
        values[i][:, [a, b]] = values[i][:, [b, a]]
    return lab.dataset(values.reshape(*u.shape[:2], -1)), lab.model()


def _taken(lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator) -> tuple["Dataset", "Model"]:
    """In every fifth capture a marker is out of sight, and its neighbour goes by its name."""
    values = (lab.predict(u) + noise).reshape(*u.shape[:2], MARKERS, 3)
    values[::5, :, 4], values[::5, :, 5] = values[::5, :, 5].copy(), np.nan
    return lab.dataset(values.reshape(*u.shape[:2], -1)), lab.model()


def _frozen(lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator) -> tuple["Dataset", "Model"]:
    """From the 25th capture on the tracker repeats where it saw one marker last."""
    values = (lab.predict(u) + noise).reshape(*u.shape[:2], MARKERS, 3)
    values[25:, :, 3] = values[25, 0, 3]
    return lab.dataset(values.reshape(*u.shape[:2], -1)), lab.model()


def _missed(lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator) -> tuple["Dataset", "Model"]:
    """In four captures the first chamber is vented, whatever it was told."""
    u = u.copy()
    u[random.choice(len(u), 4, replace=False), :, 0] = 0.0
    return lab.dataset(lab.predict(u) + noise), lab.model()


def _renamed(
    lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator
) -> tuple["Dataset", "Model"]:
    """Three captures have the measurements of the one behind, and that one has theirs."""
    values = lab.predict(u) + noise
    for i in random.choice(len(u) // 2, 3, replace=False) * 2:
        values[[i, i + 1]] = values[[i + 1, i]]
    return lab.dataset(values), lab.model()


def _sensors(
    lab: Lab, u: "Floats", noise: "Floats", random: np.random.Generator
) -> tuple["Dataset", "Model"]:
    """A force and a voltage beside the markers."""
    return beside_markers(lab, lab.predict(u) + noise, u)


USUAL: dict[str, Any] = {"rows_s": (3.0, 3.5, 4.0)}
CONDITIONS: dict[str, tuple[dict[str, Any], Measured]] = {
    "even noise": (USUAL, _with_noise()),
    "one axis with four times the noise": (USUAL, _with_noise(_each(of_axis=np.array([1.0, 1.0, 4.0])))),
    "the same, one row a set-point": (
        {"rows_s": (3.0,)},
        _with_noise(_each(of_axis=np.array([1.0, 1.0, 4.0]))),
    ),
    "one marker with five times the noise": (
        USUAL,
        _with_noise(_each(of_marker=np.array([1.0, 5.0, *np.ones(MARKERS - 2)]))),
    ),
    "each marker with another noise": (
        USUAL,
        _with_noise(_each(of_marker=np.exp(np.random.default_rng(5).normal(0.0, 0.5, MARKERS)))),
    ),
    "frame that trembles": (USUAL, _trembling),
    "table that shakes up and down": (USUAL, _shaken),
    "markers out of sight": (USUAL, _hidden),
    "exchanged names": (USUAL, _exchanged),
    "rows at 1, 3 and 8 s": ({"rows_s": (1.0, 3.0, 8.0)}, _with_noise()),
    "a name taken from a marker out of sight": (USUAL, _taken),
    "a marker that stands still": (USUAL, _frozen),
    "four set-points missed": (USUAL, _missed),
    "three pairs of captures interchanged": (USUAL, _renamed),
    "two sensors beside": ({"rows_s": (1.0, 3.0, 8.0)}, _sensors),
}


@dataclass(frozen=True)
class Found:
    """What was said of one campaign."""

    condition: str
    effect: str
    verdict: str
    names: frozenset[str]
    carried_by: str = ""

    @property
    def right(self) -> bool:
        """Whether what is hidden is named, and nothing else: of nothing, what single captures were left out for."""
        if self.effect:
            return self.names == {self.effect}
        return self.verdict == "nothing_missing" or self.carried_by in ASTRAY

    @property
    def wrong(self) -> bool:
        """Whether a name is sure that is not there."""
        return bool(self.names - {self.effect})


def measured(case: tuple[str, str, int]) -> Found:
    """What is said of one campaign of 60 set-points."""
    warnings.simplefilter("ignore")
    condition, effect, seed = case
    settings, seen = CONDITIONS[condition]
    law = HIDDEN[effect]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        lab = Lab(Path(name), chambers=3, markers=MARKERS, captures=60, seed=seed, **settings)
        data, model = seen(lab, law(lab) if law else lab.u, lab.noise(), np.random.default_rng([50, seed]))
        found = verdict_of(data, model)
    out = Found(condition, effect, found.verdict, frozenset(found.effects), found.carried_by)
    print(*case, out.verdict, *sorted(out.names), "" if out.right else "(not right)", flush=True)
    return out


def table(rows: list[Found]) -> list[str]:
    """A line for each condition, and the sums."""
    out = [
        "| measured with | nothing missing: right | an effect: right | a wrong name sure | not right |",
        "|---|---|---|---|---|",
    ]
    for condition in CONDITIONS:
        own = [row for row in rows if row.condition == condition]
        said = [
            f"{row.effect or 'nothing'}: {' '.join([row.verdict, *sorted(row.names)])}"
            for row in own
            if not row.right
        ]
        count = "; ".join(f"{said.count(words)} x {words}" for words in dict.fromkeys(said))
        parts = [[row.right for row in own if bool(row.effect) == there] for there in (False, True)]
        shares = " | ".join(f"{sum(part)} of {len(part)}" for part in parts)
        out.append(f"| {condition} | {shares} | {sum(row.wrong for row in own)} | {count} |")
    none, some = ([row for row in rows if bool(row.effect) == there] for there in (False, True))
    sums = [share([row.right for row in part]) for part in (none, some)]
    wrong = share([row.wrong for row in rows])
    return [
        *out,
        "",
        f"Nothing missing, right: {sums[0]}. An effect, right: {sums[1]}. A wrong name sure: {wrong}.",
    ]


def main() -> None:
    """Measure and write the section."""
    asked = options(seeds=3, first=0)
    cases = list(product(CONDITIONS, HIDDEN, range(asked.first, asked.first + asked.seeds)))
    with ProcessPoolExecutor(asked.workers) as pool:
        rows = list(pool.map(measured, cases))
    how = (
        f"`python benchmarks/conditions.py --first {asked.first} --seeds {asked.seeds}`: 60 set-points anywhere, three "
        f"chambers, {MARKERS} markers; creep by a power law, Dahl's friction, a leak through an orifice, a wall that "
        "stiffens."
    )
    write_section(asked.out, "## Conditions", [how, "", *table(rows)])


if __name__ == "__main__":
    main()
