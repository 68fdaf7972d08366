"""What stopping does to a verdict: how right and how sure it is where campaigns end early, beside their end."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.bench._intervals import bootstrap, share_text
from labrig.bench._judge import calibration_error, is_right, wrongly_sure
from labrig.bench._report import markdown, write_section
from labrig.bench.records import Answer, JudgedEffect, StoppingRecord, WatchedLook
from labrig.diagnosis import POSSIBLE, SURE

if TYPE_CHECKING:
    from labrig.live import Look

_HEADING = "## Stopping"
ACTED_FLOORS = 0.5
"""Below this an effect has hardly acted yet: nobody could have seen it."""
HEAD = [
    "the campaign goes on",
    "ended early",
    "captures, median",
    "minutes saved",
    "right",
    "wrong name sure",
    "sure and there",
    "called out",
    "there all the same",
    "had acted by then",
    "calibration error of effects",
]


def _ways() -> list[tuple[str, "Callable[[list[Look], int], bool]"]]:
    from labrig.live import Rule

    rule = Rule.parse("settled")
    return [
        ("to its end", lambda looks, left: False),
        ("until settled", lambda looks, left: _is_settled(rule.stop(looks, left, 0.0, looks[-1].captures))),
        ("until one look is settled", lambda looks, left: rule.is_settled(looks[-1])),
    ]


def _is_settled(why: str | None) -> bool:
    return why is not None and why.startswith("settled")


def ends_at(record: StoppingRecord, stops: "Callable[[list[Look], int], bool]") -> int:
    """The number of the look at which a campaign ends."""
    from labrig.live import Look

    looks = [Look.from_dict(look) for look in record["looks"]]
    last = len(looks) - 1
    return next(
        (k for k in range(last) if stops(looks[: k + 1], looks[-1].captures - looks[k].captures)), last
    )


def probabilities(record: StoppingRecord, look: int, floor: bool) -> list[tuple[float, bool]]:
    """(probability, is there) of every effect at a look; names that the base's own error may go by are left out.

    With `floor`, the probabilities are those that a campaign states where it ends early.
    """
    from labrig.live import Look, Rule

    said = Look.from_dict(record["looks"][look])
    known = Rule().at_a_stop(said) if floor and look < len(record["looks"]) - 1 else said.probability
    truth = record["truth"]
    also = truth.get("also") or []
    return [(p, name in truth["effects"]) for name, p in known.items() if name not in also]


def stopped_rows(records: Sequence[StoppingRecord]) -> list[list[str]]:
    """A row of the table for each way to end a campaign."""
    return [_row(name, records, stops) for name, stops in _ways()]


def _row(
    name: str, records: Sequence[StoppingRecord], stops: "Callable[[list[Look], int], bool]"
) -> list[str]:
    at = [ends_at(record, stops) for record in records]
    ends = [record["looks"][k] for record, k in zip(records, at, strict=True)]
    answers = [_answer(look) for look in ends]
    truths = [record["truth"] for record in records]
    right = sum(is_right(t, a) for t, a in zip(truths, answers, strict=True))
    wrong = sum(bool(wrongly_sure(t, a)) for t, a in zip(truths, answers, strict=True))
    pairs = [probabilities(record, k, floor=True) for record, k in zip(records, at, strict=True)]
    raw = [p for record, k in zip(records, at, strict=True) for p in probabilities(record, k, floor=False)]
    sure = [there for p, there in raw if p >= SURE]
    out = [there for p, there in raw if p < POSSIBLE]
    missed_acted = sum(
        look["acted"].get(effect, 0.0) >= ACTED_FLOORS
        for truth, look in zip(truths, ends, strict=True)
        for effect in truth["effects"]
        if look["probability"].get(effect, 1.0) < POSSIBLE and effect not in (truth.get("also") or [])
    )
    saved = [
        1 - look["minutes"] / record["looks"][-1]["minutes"]
        for look, record in zip(ends, records, strict=True)
    ]
    early = sum(k < len(record["looks"]) - 1 for record, k in zip(records, at, strict=True))
    low, high = bootstrap(pairs, _error)
    return [
        name,
        f"{early} of {len(records)}",
        f"{np.median([look['captures'] for look in ends]):.0f}",
        f"{100 * np.mean(saved):.0f} %",
        share_text(right, len(records)),
        share_text(wrong, len(records)),
        share_text(sum(sure), len(sure)),
        str(len(out)),
        share_text(sum(out), len(out)),
        str(missed_acted),
        f"{_error(pairs):.3f} ({low:.3f} to {high:.3f})",
    ]


def _answer(look: WatchedLook) -> Answer:
    considered: list[JudgedEffect] = [
        {"effect": name, "probability": p} for name, p in look["probability"].items()
    ]
    return {
        "verdict": look["verdict"],
        "effects": look["effects"],
        "rivals": look["rivals"],
        "effects_considered": considered,
    }


def _error(campaigns: Sequence[list[tuple[float, bool]]]) -> float:
    flat = [pair for pairs in campaigns for pair in pairs]
    return calibration_error([p for p, _ in flat], [there for _, there in flat])


def surer_by(records: Sequence[StoppingRecord]) -> tuple[float, float, float]:
    """By how much the calibration error of effects is larger where campaigns are stopped, and its 95 % interval."""
    both = []
    for record in records:
        whole, settled, _ = (ends_at(record, stops) for _, stops in _ways())
        both.append((probabilities(record, whole, floor=True), probabilities(record, settled, floor=True)))

    def more(drawn: list[Any]) -> float:
        return _error([stopped for _, stopped in drawn]) - _error([whole for whole, _ in drawn])

    return more(both), *bootstrap(both, more)


def write_stopping(records: Sequence[StoppingRecord], path: Path, how: str) -> None:
    """Put the table into a Markdown file under "Stopping"; the rest of the file stays as it is."""
    from labrig.live import MISSED, STEADY

    about = (
        f"{len(records)} campaigns of some 60 captures (single effects, pairs, nothing, something outside the library, "
        "a base that is wrong in form), looked at from 12 captures on, each time after 1.3 times as many, and at their "
        "end. Settled: every effect sure or out, or one name all that the evidence leaves, the same while the "
        f"campaign grew by {STEADY:g}. Called out: below {POSSIBLE:g}; some of these effects had not acted yet "
        f"({ACTED_FLOORS:g} floors), and nobody could have seen them. The calibration error is of the probabilities as "
        f"they are stated: at a stop none is below {MISSED:g}. In brackets: 95 % intervals, the last by drawing "
        "campaigns again."
    )
    more, low, high = surer_by(records)
    verdict = (
        f"Calibration error until settled, less that to the end, the same campaigns: {more:+.3f} "
        f"({low:+.3f} to {high:+.3f})."
    )
    table = markdown(HEAD, stopped_rows(records))
    write_section(path, _HEADING, [how, "", about, "", *table, "", verdict])
