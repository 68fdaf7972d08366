"""How long settling took: the table of the strategies, and what is proposed against each other one."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from labrig.bench._intervals import bootstrap
from labrig.bench._report import markdown, write_section
from labrig.bench._settle import BATCH, MINUTES, STRATEGIES
from labrig.bench.records import SettleRecord

Tried = dict[str, SettleRecord]
"""The records of one campaign that every strategy has tried, by strategy."""

WITHIN_MIN = (1, 2, 4)
"""Minutes of the rig after which strategies are compared."""
_HEADING = "## Next experiment"
_PROPOSED = STRATEGIES[0]
_DESIGNS = {"one_level": "one level", "one_hold": "one length of hold"}


def tried_by_all(records: Sequence[SettleRecord]) -> list[Tried]:
    """The campaigns that all strategies have tried."""
    by_seed: dict[int, Tried] = {}
    for record in records:
        by_seed.setdefault(record["seed"], {})[record["strategy"]] = record
    return [of for of in by_seed.values() if len(of) == len(STRATEGIES)]


def settle_rows(records: Sequence[SettleRecord]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table: how many were settled, and captures and minutes that it took.

    Medians are over all campaigns, one that was not settled counting as never; means over those that every
    strategy settled. A campaign counts once all strategies have tried it.
    """
    head = [
        "set-points",
        "campaigns",
        "settled",
        *(f"within {minutes} min" for minutes in WITHIN_MIN),
        "named wrongly",
        "captures, median",
        "mean",
        "min, median",
        "mean",
    ]
    whole = tried_by_all(records)
    by_all = [of for of in whole if all(r["settled"] for r in of.values())]
    rows = []
    for strategy in STRATEGIES:
        own = [of[strategy] for of in whole]
        wrong = sum(not r["settled"] and r["verdict"] in {"identified", "multiple"} for r in own)
        row = [strategy, str(len(own)), str(sum(r["settled"] for r in own))]
        row += [str(sum((r["minutes"] or np.inf) <= most for r in own)) for most in WITHIN_MIN]
        row.append(str(wrong))
        for key, form in (("captures", ".0f"), ("minutes", ".1f")):
            each = [r[key] if r["settled"] else np.inf for r in own]
            middle = float(np.median(each)) if each else np.inf
            row.append(format(middle, form) if np.isfinite(middle) else "never")
            row.append(f"{np.mean([of[strategy][key] for of in by_all]):.1f}" if by_all else "")
        rows.append(row)
    return head, rows


def compared_rows(
    records: Sequence[SettleRecord], minutes: float = MINUTES
) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table of what is proposed against each other strategy: its minutes in parts of the other's.

    Medians and means count a campaign that was not settled as the `minutes` after which it was given up; the geometric
    mean is over those that both settled. Each with its 95 % interval, by drawing campaigns again.
    """
    head = ["proposed, in parts of", "campaigns", "median", "mean", "settled by both", "their geometric mean"]
    whole = tried_by_all(records)
    rows = []
    for design, words in (("", ""), *_DESIGNS.items()):
        own = [of for of in whole if not design or of[_PROPOSED]["truth"]["design"] == design]
        for other in STRATEGIES[1:]:
            both = [of for of in own if of[_PROPOSED]["settled"] and of[other]["settled"]]
            row = [f"{other}, {words}" if words else other, str(len(own))]
            row += [_ratio(own, other, minutes, middle) for middle in (np.median, np.mean)]
            rows.append([*row, str(len(both)), _ratio(both, other, minutes, _geometric_mean)])
    return head, rows


def _ratio(
    campaigns: Sequence[Tried], other: str, minutes: float, middle: Callable[[list[float]], float]
) -> str:
    """The middle of the minutes with what is proposed, in parts of that of another strategy, with its interval."""
    if not campaigns:
        return ""

    def figure(drawn: Sequence[Tried]) -> float:
        mine, others = ([_minutes(of[s], minutes) for of in drawn] for s in (_PROPOSED, other))
        return float(middle(mine) / middle(others))

    low, high = bootstrap(campaigns, figure)
    return f"{figure(campaigns):.2f} ({low:.2f} to {high:.2f})"


def _minutes(record: SettleRecord, most: float) -> float:
    return most if record["minutes"] is None else record["minutes"]


def _geometric_mean(values: list[float]) -> float:
    return float(np.exp(np.mean(np.log(values))))


def write_settle(records: Sequence[SettleRecord], path: Path, how: str, minutes: float = MINUTES) -> None:
    """Put both tables into a Markdown file under "Next experiment"; the rest of the file stays as it is."""
    about = (
        "Minutes and captures after which the verdict on a campaign of class `confounded` (one that did not give it "
        f"away by itself) names what is hidden and nothing else, {BATCH} captures at a time, within {minutes:g} min of "
        "the rig: what is proposed is held shorter, so that as many captures are fewer minutes. Medians are "
        "over all campaigns (not settled: never), means over those that all settled. Adapted: what "
        "`labrig next` proposes, in programmes of 5 min at most, and even set-points where it proposes nothing. "
        "Random and even: set-points at random, and Halton points, in holds of 3.5 to 60 s."
    )
    compared = (
        "The minutes with what is proposed, in parts of those of the other set-points on the same campaigns. Not "
        f"settled counts as {minutes:g} min in medians and means. In brackets: 95 % intervals, by drawing campaigns "
        "again. One level: campaigns that only switched between two states; one length of hold: all held alike."
    )
    tables = [*markdown(*settle_rows(records)), "", compared, "", *markdown(*compared_rows(records, minutes))]
    write_section(path, _HEADING, [how, "", about, "", *tables])
