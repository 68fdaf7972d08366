"""How long it takes to settle a confounded pair: with set-points chosen, at random, and spread out evenly."""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from labrig.arrays import Floats
from labrig.bench._draw import Campaign, draw
from labrig.bench._files import write_model
from labrig.bench._judge import is_right
from labrig.bench._lines import adding_lines, read_lines
from labrig.bench._programmes import Plan
from labrig.bench.records import SettleRecord, SettleTruth, Settling, WholeTruth
from labrig.contents import Summary

if TYPE_CHECKING:
    import xarray as xr

    from labrig.model import Model

Strategy = Literal["adapted", "random", "even"]
STRATEGIES: tuple[Strategy, ...] = ("adapted", "random", "even")

MINUTES = 10.0
"""Minutes of the rig after which a campaign is given up: holds of one strategy are shorter than those of another."""
BATCH = 4
HIGHEST = 0.9
RECORDS = "settle.jsonl"
_DRAWN = 64
"""Set-points that are drawn at a time, at random or spread evenly."""
_SHORTEST_S, _LONGEST_S = 3.5, 60.0


def unsettled_campaigns(first_seed: int, count: int, most: int = 400) -> Iterator[tuple[int, Campaign]]:
    """Campaigns of class `confounded`, of seeds from `first_seed` on, that do not give what is hidden away."""
    from labrig.diagnosis import diagnose

    found = 0
    for seed in range(first_seed, first_seed + most):
        if found >= count:
            return
        campaign = draw("confounded", seed)
        with tempfile.TemporaryDirectory(prefix="labrig-bench-") as folder:
            summary = diagnose(campaign.dataset, _model(campaign, Path(folder))).summary
        if not _names_it(campaign, summary):
            found += 1
            yield seed, campaign


def settle(campaign: Campaign, strategy: Strategy, seed: int, minutes: float = MINUTES) -> Settling:
    """Measure on, `BATCH` captures at a time, until the verdict names what is hidden and nothing else.

    Returns captures and minutes that it took (None if `minutes` of the rig were not enough), and the last verdict.
    """
    from labrig.diagnosis import diagnose

    with tempfile.TemporaryDirectory(prefix="labrig-bench-") as folder:
        model = _model(campaign, Path(folder))
        summary = diagnose(campaign.dataset, model).summary
        done: list[xr.Dataset] = []
        taken, used = 0, 0.0
        while used < minutes:
            holds = _holds(strategy, campaign, [campaign.dataset, *done], model, summary, seed, taken)
            if not holds:
                break
            for end in range(BATCH, len(holds) + BATCH, BATCH):
                part = holds[:end]
                measured = _measured(campaign, part, seed + taken)
                summary = diagnose([campaign.dataset, *done, measured], model).summary
                now = used + sum(hold_s for _, hold_s in part) / 60
                if now > minutes:
                    return _answer(summary, strategy, taken, used, settled=False)
                if _names_it(campaign, summary):
                    return _answer(summary, strategy, taken + len(part), now, settled=True)
                if end >= len(holds):
                    taken, used = taken + len(part), now
                    done.append(measured)
    return _answer(summary, strategy, taken, used, settled=False)


def _names_it(campaign: Campaign, summary: Summary) -> bool:
    """Whether a diagnosis identifies what is hidden, and nothing else."""
    truth: WholeTruth = {**campaign.truth, "verdict": "identified"}
    return is_right(truth, {"verdict": summary["verdict"], "effects": summary["effects"]})


def _answer(summary: Summary, strategy: str, captures: int, minutes: float, settled: bool) -> Settling:
    return {
        "strategy": strategy,
        "settled": settled,
        "captures": captures if settled else None,
        "minutes": minutes if settled else None,
        "verdict": summary["verdict"],
        "effects": summary["effects"],
        "rivals": summary["rivals"],
    }


def _holds(
    strategy: Strategy,
    campaign: Campaign,
    runs: "list[xr.Dataset]",
    model: "Model",
    summary: Summary,
    seed: int,
    taken: int,
) -> list[tuple[Floats, float]]:
    """The next set-points, kPa, and how long each is held, s."""
    from labrig import LabrigError
    from labrig.experiment import propose_experiment
    from labrig.live import MINUTES as MINUTES_AT_A_TIME

    if strategy == "adapted":  # as a live campaign does
        try:
            experiment = propose_experiment(runs, model, summary=summary, minutes=MINUTES_AT_A_TIME)
        except LabrigError:  # it is sure, of something wrong, or sees nothing that would tell
            return _spread("even", campaign, seed, taken)[:BATCH]
        return [(experiment.limits.actuation(p.share), p.hold_s) for p in experiment.points]
    return _spread(strategy, campaign, seed, taken)


def _spread(strategy: Strategy, campaign: Campaign, seed: int, taken: int) -> list[tuple[Floats, float]]:
    """Set-points at random, or Halton points, in holds of very different length."""
    high = campaign.dataset["chamber_max"].values
    random = np.random.default_rng([seed, taken, len(strategy)])
    if strategy == "random":
        unit = random.random((_DRAWN, len(high) + 1))
    else:
        from scipy.stats import qmc

        unit = qmc.Halton(len(high) + 1, scramble=True, rng=random).random(_DRAWN)
    hold_s = _SHORTEST_S * (_LONGEST_S / _SHORTEST_S) ** unit[:, -1]
    return [(HIGHEST * high * u[:-1], float(h)) for u, h in zip(unit, hold_s, strict=True)]


def _measured(campaign: Campaign, holds: list[tuple[Floats, float]], seed: int) -> "xr.Dataset":
    plan = Plan(np.random.default_rng(seed), campaign.dataset["chamber_max"].values)
    for pressure, hold_s in holds:
        plan.capture(pressure, max(hold_s, 2.5), 6 if hold_s > 15 else 4)
    assert campaign.later is not None
    return campaign.later(plan, seed)


def _model(campaign: Campaign, folder: Path) -> "Model":
    from labrig.model import Model

    return Model.load(write_model(campaign, folder))


def run_settle(folder: Path, first_seed: int, count: int, minutes: float = MINUTES) -> Iterator[SettleRecord]:
    """Every strategy on `count` campaigns that leave a doubt; each record is written as it is done, and skipped if
    it is there already."""
    done = {(r["seed"], r["strategy"]) for r in settle_records(folder)}
    with adding_lines(folder / RECORDS) as add:
        for seed, campaign in unsettled_campaigns(first_seed, count):
            for strategy in STRATEGIES:
                if (seed, strategy) in done:
                    continue
                truth: SettleTruth = {
                    "effects": campaign.truth["effects"],
                    "design": campaign.truth["design"],
                    "captures": campaign.truth["captures"],
                }
                found = settle(campaign, strategy, seed, minutes)
                record: SettleRecord = {"seed": seed, "truth": truth, **found}
                add(record)
                yield record


def settle_records(folder: Path) -> list[SettleRecord]:
    """The records that are done; a last line that was cut is left out."""
    return read_lines(folder / RECORDS)
