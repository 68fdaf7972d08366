"""On which day a rig's ageing is noticed by the morning's check, and what is noticed that is not there.

    python benchmarks/ageing.py [--rigs 20] [--days 60] [--workers 2] [--out benchmarks/RESULTS.md]
    python benchmarks/ageing.py --wander 200

Simulated rigs (the mannequin's reduced surface, nine chambers, 34 markers) that are checked every morning for 60 days.
Creep doubles between day 15 and the last day, by another formula than the library's; one chamber begins to leak on day
31; one marker slips on some day between. Besides, every day is a little different: temperature softens the membrane by
some 0.5 %, the cameras are off by some 0.1 mm, sensors' zeros by some 0.05 kPa. Every morning's history is made of the
runs up to it alone. Writes the section "A rig that ages" of the results.

`--wander` prints instead how often a drawn quantity that is today much as it was yesterday is taken for one that
changed, and how many days after a step or a growth of so many scatters from day 20 on it is noticed.
"""

import argparse
import os
import platform
import statistics
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import yaml

import labrig
from labrig import age
from labrig.age._known import Known
from labrig.age._read import model_key, read_run
from labrig.bench._report import write_section
from labrig.campaign import Procedure, run
from labrig.physics import reduced_surface
from labrig.rig import Rig, parse_rig
from labrig.view._history_picture import write_history_picture
from labrig_drivers import PressureSample, SimulatedClock
from labrig_drivers.simulated import SimulatedMocap, SimulatedPlant, SimulatedPressure
from labrig_drivers.simulated._observer import Observer
from labrig_drivers.simulated.hidden import EFFECTS, Hidden, Setting
from labrig_procedures import Capture, Check

DAY_S = 86_400.0
START_S = 1_767_252_600.0
CREEP_DAY, LEAK_DAY = 15, 31
BEGINS = 20
"""The day of the change in `--wander`."""
RIG = {
    "name": "mannequin",
    "chambers": [{"name": f"c{n}", "max_kpa": 60, "slew_kpa_s": 2000} for n in range(1, 10)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated"},
    "simulated": {"surface": "mannequin"},
    "follow": {"tolerance_kpa": 20, "tolerance_share": 0.5},
}
KEPT_HZ = 4.0
"""Of frames and pressures: fewer than of real devices, so that 1,200 checks are soon run."""


class CoarseClock(SimulatedClock):
    """A simulated clock on which the devices are asked twice a second."""

    def sleep(self, duration_s: float) -> None:
        super().sleep(max(duration_s, 0.5))


class Today(Hidden):
    """What is different every day: how soft the membrane is, and where the cameras think they are."""

    name = "today"

    def prepare(self) -> None:
        random = self.setting.random
        self.softer = 1.0 + 0.005 * random.normal()
        self.shift_mm = 0.1 * random.normal(size=3)

    def deflect(self, time_s: Any, step_s: Any, deflection_mm: Any) -> Any:
        return self.softer * deflection_mm

    def see(self, time_s: Any, tilt_deg: Any, deflection_mm: Any, position_mm: Any) -> Any:
        return position_mm + self.shift_mm


class WanderingPressure(SimulatedPressure):
    """Sensors whose zeros are a little off, every day otherwise."""

    def __init__(self, *arguments: Any, zero_kpa: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._zero_kpa = zero_kpa

    def samples(self) -> list[PressureSample]:
        return [PressureSample(s.time_s, s.pressure_kpa + self._zero_kpa) for s in super().samples()]


@dataclass(frozen=True)
class Fate:
    """What happens to one rig; `leak` is the share of the highest pressure that is lost in 10 s."""

    seed: int
    days: int
    creep: float = field(init=False)
    chamber: int = field(init=False)
    leak: float = field(init=False)
    marker: int = field(init=False)
    slip_day: int = field(init=False)
    slip_mm: float = field(init=False)

    def __post_init__(self) -> None:
        random = np.random.default_rng([self.seed, 11])
        drawn = {
            "creep": random.uniform(0.02, 0.04),
            "chamber": int(random.integers(9)),
            "leak": float(np.exp(random.uniform(np.log(0.001), np.log(0.01)))),
            "marker": int(random.integers(34)),
            "slip_day": int(random.integers(18, 50)),
            "slip_mm": random.uniform(0.8, 2.5),
        }
        for name, value in drawn.items():
            object.__setattr__(self, name, value)

    def strength(self, day: int) -> float:
        """Creep on a day: twice the first on the last."""
        return self.creep * (1.0 + max(day - CREEP_DAY, 0) / (self.days - 1 - CREEP_DAY))

    def hidden(self, body: Any, day: int) -> list[Hidden]:
        """All that is in the rig on a day."""
        high = np.full(9, 60.0)

        def setting(*numbers: int) -> Setting:
            return Setting(body, high, 240.0, np.random.default_rng([self.seed, *numbers]))

        creep = EFFECTS["creep"](setting(1))
        creep.strength = self.strength(day)
        parts: list[Hidden] = [creep, Today(setting(2, day))]
        if day >= LEAK_DAY:
            leak = EFFECTS["leak"](setting(3))
            leak.strength = self.leak
            leak.share = np.eye(9)[self.chamber]  # type: ignore[attr-defined]
            parts.append(leak)
        if day >= self.slip_day:
            slip = EFFECTS["marker_slip"](setting(4))
            slip.strength, slip.moment_s, slip.marker = self.slip_mm, -1e9, self.marker  # type: ignore[attr-defined]
            normal = body.normal[self.marker]
            way = slip.way - (slip.way @ normal) * normal  # type: ignore[attr-defined]
            slip.way = way / np.linalg.norm(way)  # type: ignore[attr-defined]
            parts.append(slip)
        return parts


def connected(fate: Fate, day: int, clock: SimulatedClock, number: int) -> Rig:
    """The rig as it is on a day."""
    config = parse_rig(RIG, "rig", Path())
    body = reduced_surface(RIG)
    seed = int(np.random.default_rng([fate.seed, 5, day, number]).integers(2**31))
    plant = SimulatedPlant(body, config.channels, Observer(34, seed, 0.1, 0.1, 0.03), fate.hidden(body, day))
    zero_kpa = 0.05 * np.random.default_rng([fate.seed, 6, day]).normal(size=9)
    pressure = WanderingPressure(plant, clock, rate_hz=KEPT_HZ, seed=seed, zero_kpa=zero_kpa)
    mocap = SimulatedMocap(plant, clock, rate_hz=KEPT_HZ)
    for device in (pressure, mocap):
        device.connect()
    config = config.model_copy(update={"markers": tuple(plant.marker_names)})
    identity = {"pressure": pressure.identify(), "mocap": mocap.identify()}
    return Rig(config, clock, pressure, mocap, None, identity, plant.rest_mm)


def measured(fate: Fate, day: int, procedure: Procedure, folder: Path, number: int = 0) -> Path:
    """A run of a day, in the morning."""
    clock = CoarseClock(START_S + DAY_S * day + 3600.0 * number)
    with mock.patch("os.fsync"), connected(fate, day, clock, number) as rig:
        return run(procedure, rig, folder, clock=clock, seed=number)


def first_noticed(fate: Fate, folder: Path, picture: Path | None = None) -> dict[tuple[str, str], int]:
    """The rig's life in a folder: for everything that its histories ever name, the day on which they first do.

    The last of these histories is drawn into `picture`.
    """
    (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    (folder / "base.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n", encoding="utf-8")
    campaign = measured(fate, 0, Capture(captures=40, highest=0.8), folder / "campaign", 1)
    hold = measured(fate, 0, Check(), folder / "first-check", 2)
    better = labrig.improve([campaign, hold], folder / "base.yaml", "creep")
    better.model.save(folder / "model.yaml")
    model = labrig.Model.load(folder / "model.yaml")
    known, key = Known(model), model_key(model)
    readings: list[age.RunReadings] = []
    noticed: dict[tuple[str, str], int] = {}
    for day in range(fate.days):
        path = measured(fate, day, Check(), folder / "runs" / f"{day:03d}-check")
        readings.append(read_run(path, path.name, known, key))
        summary = age.summary_of("mannequin", model, readings)
        for change in summary["changes"]:
            noticed.setdefault((change["group"], change["name"]), day)
    if picture is not None:
        write_history_picture(summary, picture)
    return noticed


def life(seed: int, days: int, picture: Path | None = None) -> dict[str, Any]:
    """One rig's life, and what came of it: when each thing was noticed, and what was named that was not there."""
    began = time.perf_counter()
    fate = Fate(seed, days)
    with tempfile.TemporaryDirectory() as name:
        noticed = first_noticed(fate, Path(name), picture)
    marker = reduced_surface(RIG).marker_names[fate.marker]
    true = {
        "creep": (("effect", "creep"), CREEP_DAY),
        "leak": (("leak", f"c{fate.chamber + 1}"), LEAK_DAY),
        "slip": (("marker", marker), fate.slip_day),
    }
    late = {
        what: noticed[key] - day if noticed.get(key, -1) >= day else None for what, (key, day) in true.items()
    }
    real = dict(true.values()) | {("error", "error"): CREEP_DAY, ("gain", "displacement"): CREEP_DAY}
    false = [
        f"{group} {name} on day {day}"
        for (group, name), day in noticed.items()
        if day < real.get((group, name), days)
    ]
    return {"fate": fate, "late": late, "false": false, "took_s": time.perf_counter() - began}


def _cell(values: list[int | None], days: list[int]) -> str:
    """A row's figures: how many noticed, and after how many days (median, worst)."""
    known = [value for value in values if value is not None]
    if not known:
        return "0 | | |"
    first = statistics.median(day + late for day, late in zip(days, values, strict=True) if late is not None)
    return f"{len(known)} of {len(values)} | {first:g} | {statistics.median(known):g} | {max(known)} |"


def section(lives: list[dict[str, Any]], days: int) -> list[str]:
    """The lines of the results."""
    rows = {
        f"creep, which doubles from day {CREEP_DAY} to day {days - 1}": ("creep", [CREEP_DAY] * len(lives)),
        f"one chamber's leak from day {LEAK_DAY}, 0.1 to 1 % in 10 s": ("leak", [LEAK_DAY] * len(lives)),
        "one marker's slip of 0.8 to 2.5 mm, on some day": (
            "slip",
            [each["fate"].slip_day for each in lives],
        ),
    }
    before = [line for each in lives for line in each["false"]]
    table = [
        f"| {what} | {_cell([each['late'][name] for each in lives], at)}" for what, (name, at) in rows.items()
    ]
    took_s = statistics.median(each["took_s"] for each in lives) / days
    named = f": {', '.join(before)}" if before else ""
    return [
        f"`python benchmarks/ageing.py --rigs {len(lives)} --days {days}` on {platform.machine()}, {os.cpu_count()} "
        f"cores. {len(lives)} simulated rigs (nine chambers, 34 markers), one check each morning; each day differs a "
        "little besides (softness 0.5 %, cameras 0.1 mm, zeros 0.05 kPa).",
        "",
        "| what happens | noticed | on day, median | days after it, median | worst |",
        "|---|---|---|---|---|",
        *table,
        "",
        f"False warnings (of something that had not happened by then): **{len(before)}** in {len(lives) * days:,} "
        f"mornings{named}. The method promises that at most one rig in {1 / age.ALPHA:.0f} ever has one. A change is "
        "believed from its second run on, so that one day after it is the earliest. That the model's error and the "
        "softness rise once creep grows counts as true (its shortest lags, 0.4 s, are softness to a check). "
        "Simulating, measuring, logging and reading a day, and the history of all days "
        f"before, took {took_s:.1f} s.",
    ]


def quantity(seed: int, correlation: float, size: float, growth: bool) -> age.Series:
    """60 days of a quantity of unit scatter that is alike from day to day, with a step, or a growth in 30 days."""
    random, day = np.random.default_rng(seed), np.arange(60.0)
    value = random.normal(size=60)
    for today in range(1, 60):
        value[today] = correlation * value[today - 1] + np.sqrt(1 - correlation**2) * value[today]
    value += size * (np.maximum(day - BEGINS + 1, 0) / 30 if growth else day >= BEGINS)
    return age.Series(day, value[:, None], np.full(60, np.nan), np.array(["check"] * 60))


def late(correlation: float, size: float, growth: bool, count: int) -> list[int]:
    """After how many days each of these is noticed that is noticed at all; of no change, that one is named."""
    found = [
        age.changes(quantity(n, correlation, size, growth), age.ALPHA / 60).changes for n in range(count)
    ]
    first = [next((c.noticed for c in each if not size or c.noticed >= BEGINS), None) for each in found]
    return [day - BEGINS for day in first if day is not None]


def wandering(count: int) -> list[str]:
    """The table of `--wander`: each cell the median days, and in how many of `count` series."""
    sizes = [
        (0.0, False),
        *((size, False) for size in (3.0, 4.0, 6.0, 10.0)),
        *((s, True) for s in (5.0, 10.0, 20.0)),
    ]
    heads = [
        f"{'growth' if growth else 'step'} of {size:g}" if size else "no change" for size, growth in sizes
    ]
    lines = [f"| lag-1 correlation | {' | '.join(heads)} |", "|---" * (len(sizes) + 1) + "|"]
    for correlation in (0.0, 0.5, 0.7, 0.8, 0.9):
        days = [late(correlation, size, growth, count) for size, growth in sizes]
        cells = [f"{len(days[0])} named", *(f"{statistics.median(d or [60]):g} ({len(d)})" for d in days[1:])]
        lines.append(f"| {correlation:g} | {' | '.join(cells)} |")
    return lines


def main() -> None:
    """Let the rigs live, print and write the section."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rigs", type=int, default=20)
    parser.add_argument("--days", type=int, default=60)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    parser.add_argument("--picture", type=Path, help="draw the history of the first rig, and of no other")
    parser.add_argument("--wander", type=int, default=0, help="draw so many quantities, and let no rigs live")
    options = parser.parse_args()
    if options.wander:
        print("\n".join(wandering(options.wander)))
        return
    if options.picture is not None:
        print(life(0, options.days, options.picture)["late"])
        return
    with ProcessPoolExecutor(options.workers) as pool:
        lives = []
        for each in pool.map(life, range(options.rigs), [options.days] * options.rigs):
            lives.append(each)
            print(each["fate"].seed, each["late"], each["false"], f"{each['took_s']:.0f} s", flush=True)
    lines = section(lives, options.days)
    print("\n".join(lines))
    if (options.rigs, options.days) == (20, 60):
        write_section(options.out, "## A rig that ages", lines)


if __name__ == "__main__":
    main()
