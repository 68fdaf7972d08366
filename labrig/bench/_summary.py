"""Figures of a benchmark: by class, effect, law, rig and base, and how the two halves differ; shares with intervals."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from labrig.bench._classes import CLASSES
from labrig.bench._goals import alike, judged
from labrig.bench._halves import DRAWN_FROM, HALVES
from labrig.bench._intervals import bootstrap, newcombe, share
from labrig.bench._judge import brier, calibration_error, called, label, probabilities
from labrig.bench.records import (
    Answer,
    BaselineFigures,
    BenchSummary,
    ClassFigures,
    Figure,
    HalfFigures,
    HalvesDifference,
    Interval,
    Judged,
    PartFigures,
    Record,
    Spread,
    Totals,
    Truth,
)
from labrig.diagnosis import POSSIBLE, SURE

Records = list[Record]
_NAMED = ("identified", "multiple")
_FEW = 29  # of fewer campaigns not even the lowest bounds a tenth percentile with 95 %: 1 - 0.9**29 = 0.95


def summarise(records: Records, reveal: bool = False) -> BenchSummary:
    """All figures of a benchmark, as JSON: for each half, and what differs between them.

    Of the exam nothing is said by law, rig, base or campaign, so that nobody tunes to it, unless `reveal` is set.
    """
    halves = {half: [r for r in records if r["truth"]["half"] == half] for half in DRAWN_FROM}
    out: BenchSummary = {
        "campaigns": len(records),
        "halves": {half: figures(found, reveal or half != "exam") for half, found in halves.items() if found},
    }
    if all(half in out["halves"] for half in HALVES):
        out["difference"] = _differences(halves["development"], halves["exam"])
    return out


def figures(records: Records, whole: bool) -> HalfFigures:
    """The figures of one half; without `whole` only those by class and effect."""
    nameable = [r for r in records if r["truth"]["verdict"] in _NAMED]
    by_class = {name: [r for r in records if r["truth"]["class"] == name] for name in CLASSES}
    out: HalfFigures = {
        "campaigns": len(records),
        "classes": {name: _class(name, found, whole) for name, found in by_class.items() if found},
        "totals": _totals(records),
        "effects": _by_effect(nameable, lambda truth, k: (truth["effects"][k],)),
        "failures": sum(r["answer"]["verdict"] == "error" for r in records),
        "goals": [],
    }
    if whole:
        out["confusion"] = _confusion(records)
        out["laws"] = _by_effect(nameable, lambda truth, k: (truth["effects"][k], truth["laws"][k]))
        outside = [r for r in records if r["truth"]["class"] == "outside"]
        out["laws"] += _by_effect(outside, lambda truth, k: ("outside", truth["laws"][k]))
        out["rigs"] = _by(records, lambda truth: truth["rig"])
        out["bases"] = _by(records, lambda truth: truth["base_kind"])
    out["goals"] = judged(out)
    return out


def _totals(records: Records) -> Totals:
    found = _called(r for r in records if r["truth"]["verdict"] in _NAMED)
    hidden = [r for r in records if r["truth"]["verdict"] == "unknown"]
    verdicts = [(p, r["right"]) for r in records if (p := r["answer"].get("probability")) is not None]
    effects = [trials for r in records if (trials := _trials(r))]
    drops = [d for r in records if r["right"] and _names(r) and (d := _fresh(r)) is not None]
    boxes = [box for r in records if r["truth"]["effects"] and (box := _others(r).get("black box"))]
    return {
        "right": share(sum(r["right"] for r in records), len(records)),
        "true_sure": share(sum(sure for sure, _ in found), len(found)),
        "true_possible": share(sum(possible for _, possible in found), len(found)),
        "wrong_sure": share(sum(bool(r["wrongly_sure"]) for r in records), len(records)),
        "unknown_recall": share(sum(r["answer"]["verdict"] == "unknown" for r in hidden), len(hidden)),
        "verdict_ece": _resampled(verdicts, _ece),
        "verdict_brier": _resampled(verdicts, _brier),
        "effect_ece": _resampled(effects, lambda of: _ece([t for trials in of for t in trials])),
        "effect_brier": _resampled(effects, lambda of: _brier([t for trials in of for t in trials])),
        "fresh_drop_p10": _resampled(drops, lambda of: float(np.percentile(of, 10))),
        "fresh_drop_median": _resampled(drops, lambda of: float(np.median(of))),
        "black_box_fresh_drop": _low([_fresh(b) for b in boxes]),
    }


def _resampled(values: list[Any], figure: Callable[[list[Any]], float]) -> Figure | None:
    """A figure as `share` has it, its interval by resampling campaigns."""
    if not values:
        return None
    low, high = bootstrap(values, figure)
    return {"value": figure(values), "low": low, "high": high, "of": len(values), "few": len(values) < _FEW}


def _ece(trials: list[tuple[float, bool]]) -> float:
    return calibration_error([p for p, _ in trials], [right for _, right in trials])


def _brier(trials: list[tuple[float, bool]]) -> float:
    return brier([p for p, _ in trials], [right for _, right in trials])


def _trials(record: Record) -> list[tuple[float, bool]]:
    """(probability, whether it is there) of each effect considered; names that may stand beside it are left out.

    A crash gives what is there no probability.
    """
    truth, known = record["truth"], probabilities(record["answer"]) or {}
    if record["answer"]["verdict"] == "error":
        known = dict.fromkeys(truth["effects"], 0.0)
    beside = set(truth.get("also") or []) - set(truth["effects"])
    return [(p, name in truth["effects"]) for name, p in known.items() if name not in beside]


def _called(records: Iterable[Record]) -> list[tuple[bool, bool]]:
    """(sure, sure or possible) of each hidden effect, where the answer gives probabilities."""
    out = []
    for record in records:
        sure, possible = called(record["answer"], SURE), called(record["answer"], POSSIBLE)
        if sure is not None and possible is not None:
            out += [(name in sure, name in possible) for name in record["truth"]["effects"]]
    return out


def _class(name: str, records: Records, whole: bool) -> ClassFigures:
    count, alarms = len(records), sum(r["false_alarm"] for r in records)
    verdicts: dict[str, int] = {}
    for record in records:
        verdicts[record["answer"]["verdict"]] = verdicts.get(record["answer"]["verdict"], 0) + 1
    names = sorted({b for r in records for b in _others(r)})
    out: ClassFigures = {
        "campaigns": count,
        "right": share(sum(r["right"] for r in records), count),
        "named_among": share(sum(r["near"] for r in records), count) if CLASSES[name].effects else None,
        "wrong_sure": share(sum(bool(r["wrongly_sure"]) for r in records), count),
        "false_alarms": share(alarms, count) if not CLASSES[name].effects else None,
        "verdicts": verdicts,
        "drop": _low([r.get("drop") for r in records if r["right"]]),
        "fresh_drop": _low([_fresh(r) for r in records if r["right"]]),
        "seconds": float(np.mean([r["seconds"] for r in records])),
        "baselines": {b: _baseline(b, records) for b in names},
    }
    if whole:
        out["wrong"] = [
            {"key": r["key"], "truth": r["truth"]["effects"], "answer": _said(r["answer"])}
            for r in records
            if not r["right"]
        ]
    return out


def _by(records: Records, key: Callable[[Truth], str]) -> list[PartFigures]:
    """Right verdicts and wrong names that were called sure, by a part of the truth."""
    out: list[PartFigures] = []
    for name in sorted({key(r["truth"]) for r in records}):
        own = [r for r in records if key(r["truth"]) == name]
        found = _called(r for r in own if r["truth"]["verdict"] in _NAMED)
        out.append(
            {
                "name": [name],
                "right": share(sum(r["right"] for r in own), len(own)),
                "true_sure": share(sum(sure for sure, _ in found), len(found)),
                "true_possible": share(sum(possible for _, possible in found), len(found)),
                "wrong_sure": share(sum(bool(r["wrongly_sure"]) for r in own), len(own)),
            }
        )
    return out


def _by_effect(records: Records, key: Callable[[Truth, int], tuple[str, ...]]) -> list[PartFigures]:
    """The same by hidden effect; a campaign that hides two counts for both, each by whether it itself is named."""
    found: dict[tuple[str, ...], list[tuple[Record, str]]] = {}
    for record in records:
        for k, effect in enumerate(record["truth"]["effects"]):
            found.setdefault(key(record["truth"], k), []).append((record, effect))
    out: list[PartFigures] = []
    for name, own in sorted(found.items()):
        known = [(r["answer"], e) for r, e in own if probabilities(r["answer"]) is not None]
        sure = sum(e in (called(a, SURE) or ()) for a, e in known)
        possible = sum(e in (called(a, POSSIBLE) or ()) for a, e in known)
        out.append(
            {
                "name": list(name),
                "right": share(sum(r["right"] for r, _ in own), len(own)),
                "true_sure": share(sure, len(known)),
                "true_possible": share(possible, len(known)),
                "wrong_sure": share(sum(bool(r["wrongly_sure"]) for r, _ in own), len(own)),
            }
        )
    return out


def _differences(development: Records, exam: Records) -> list[HalvesDifference]:
    """Right verdicts of the one half minus those of the other, over the classes that both have, and by class."""
    classes = [name for name in CLASSES if _of(development, [name]) and _of(exam, [name])]
    out: list[HalvesDifference] = []
    for name, of in [("all", classes), *((name, [name]) for name in classes)]:
        own, other = _of(development, of), _of(exam, of)
        if not own or not other:
            continue
        counts = (sum(r["right"] for r in own), len(own), sum(r["right"] for r in other), len(other))
        low, high = newcombe(*counts)
        value = counts[0] / counts[1] - counts[2] / counts[3]
        by: Interval = {"value": value, "low": low, "high": high}
        out.append(
            {
                "what": name,
                "development": share(counts[0], counts[1]),
                "exam": share(counts[2], counts[3]),
                "difference": by,
                "status": alike(by),
            }
        )
    return out


def _of(records: Records, classes: list[str]) -> Records:
    return [r for r in records if r["truth"]["class"] in classes]


def _others(record: Record) -> dict[str, Judged]:
    return record.get("baselines", {})


def _said(answer: Answer) -> str:
    names = "+".join(answer["effects"])
    rivals = answer.get("rivals") or []
    others = f" (or {', '.join(map(str, rivals))})" if rivals else ""
    return answer["verdict"] + (f" {names}" if names else "") + others


def _baseline(name: str, records: Records) -> BaselineFigures:
    found = [_others(r)[name] for r in records if name in _others(r)]
    nameless = any(b.get("names_nothing") for b in found)
    return {
        "right": None if nameless else sum(b["right"] for b in found) / len(found),
        "false_alarms": None if nameless else sum(b["false_alarm"] for b in found) / len(found),
        "fresh_drop": _low([_fresh(b) for b in found]),
    }


def _names(record: Record) -> bool:
    """Whether the answer says what is missing: `confounded` says that it does not know yet."""
    return record["answer"]["verdict"] in _NAMED


def _fresh(record: Judged) -> float | None:
    return (record.get("fresh") or {}).get("drop")


def _low(values: list[float | None]) -> Spread | None:
    """Count, median and tenth percentile of what is known."""
    known = [v for v in values if v is not None]
    if not known:
        return None
    return {
        "campaigns": len(known),
        "median": float(np.median(known)),
        "p10": float(np.percentile(known, 10)),
    }


def _confusion(records: Records) -> dict[str, dict[str, int]]:
    """Truth -> answer -> campaigns."""
    table: dict[str, dict[str, int]] = {}
    for record in records:
        truth, answer = record["truth"], record["answer"]
        row = table.setdefault(label(truth["verdict"], truth["effects"]), {})
        column = label(answer["verdict"], answer["effects"])
        row[column] = row.get(column, 0) + 1
    return table
