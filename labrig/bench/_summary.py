"""Figures of a benchmark: per class, per baseline, and how well probabilities are calibrated."""

from typing import Any

import numpy as np

from labrig.bench._classes import CLASSES
from labrig.bench._judge import brier, calibration_error, label, wilson

GOALS: dict[str, tuple[str, float]] = {
    "null": ("false alarms <=", 0.02),
    "null-slow": ("false alarms <=", 0.05),
    "null-static": ("false alarms <=", 0.05),
    "single-1": ("right >=", 0.95),
    "single-2": ("right >=", 0.98),
    "static": ("right >=", 0.95),
    "pair": ("right >=", 0.85),
    "structural": ("right >=", 0.90),
    "unlisted": ("right >=", 0.80),
    "deleted": ("right >=", 0.80),
}


def summarise(records: list[dict[str, Any]]) -> dict[str, Any]:
    """All figures of a benchmark, as JSON; `classes` has one entry per class, in the order of `CLASSES`."""
    by_class = {name: [r for r in records if r["truth"]["class"] == name] for name in CLASSES}
    known = [r for r in records if r["answer"].get("probability") is not None]
    probability = [r["answer"]["probability"] for r in known]
    right = [r["right"] for r in known]
    return {
        "campaigns": len(records),
        "classes": {name: _class(name, found) for name, found in by_class.items() if found},
        "calibration": {
            "campaigns": len(known),
            "brier": brier(probability, right) if known else None,
            "ece": calibration_error(probability, right) if known else None,
        },
        "fresh_drop": _low([_fresh(r) for r in records if r["right"] and _names(r)]),
        "black_box_fresh_drop": _low(
            [_fresh(r["baselines"]["black box"]) for r in records if _boxed(r) and r["truth"]["effects"]]
        ),
        "confusion": _confusion(records),
        "failures": [r["key"] for r in records if r["answer"]["verdict"] == "error"],
    }


def _boxed(record: dict[str, Any]) -> bool:
    return "black box" in record.get("baselines", {})


def _class(name: str, records: list[dict[str, Any]]) -> dict[str, Any]:
    count, right = len(records), sum(r["right"] for r in records)
    alarms = sum(r["false_alarm"] for r in records)
    low, high = wilson(right, count)
    verdicts: dict[str, int] = {}
    for record in records:
        verdicts[record["answer"]["verdict"]] = verdicts.get(record["answer"]["verdict"], 0) + 1
    goal = GOALS.get(name)
    reached = None
    if goal is not None:
        share = alarms / count if "alarms" in goal[0] else right / count
        reached = share <= goal[1] if "alarms" in goal[0] else share >= goal[1]
    names = sorted({b for r in records for b in r.get("baselines", {})})
    return {
        "campaigns": count,
        "right": right / count,
        "right_interval": [low, high],
        "named_among": sum(r["near"] for r in records) / count,
        "false_alarms": alarms / count if not CLASSES[name].effects else None,
        "goal": None if goal is None else f"{goal[0]} {goal[1]:.0%}",
        "reached": reached,
        "verdicts": verdicts,
        "drop": _low([r.get("drop") for r in records if r["right"]]),
        "fresh_drop": _low([_fresh(r) for r in records if r["right"]]),
        "seconds": float(np.mean([r["seconds"] for r in records])),
        "baselines": {b: _baseline(b, records) for b in names},
        "wrong": [
            {"key": r["key"], "truth": r["truth"]["effects"], "answer": _said(r["answer"])}
            for r in records
            if not r["right"]
        ],
    }


def _said(answer: dict[str, Any]) -> str:
    names = "+".join(answer["effects"])
    rivals = answer.get("rivals") or []
    others = f" (or {', '.join(map(str, rivals))})" if rivals else ""
    return answer["verdict"] + (f" {names}" if names else "") + others


def _baseline(name: str, records: list[dict[str, Any]]) -> dict[str, Any]:
    found = [r["baselines"][name] for r in records if name in r.get("baselines", {})]
    nameless = any(b.get("names_nothing") for b in found)
    return {
        "right": None if nameless else sum(b["right"] for b in found) / len(found),
        "false_alarms": None if nameless else sum(b["false_alarm"] for b in found) / len(found),
        "fresh_drop": _low([_fresh(b) for b in found]),
    }


def _names(record: dict[str, Any]) -> bool:
    """Whether the answer says what is missing: `confounded` says that it does not know yet."""
    return record["answer"]["verdict"] in ("identified", "multiple")


def _fresh(record: dict[str, Any]) -> float | None:
    return (record.get("fresh") or {}).get("drop")


def _low(values: list[float | None]) -> dict[str, float] | None:
    """Count, median and tenth percentile of what is known."""
    known = [v for v in values if v is not None]
    if not known:
        return None
    return {
        "campaigns": len(known),
        "median": float(np.median(known)),
        "p10": float(np.percentile(known, 10)),
    }


def _confusion(records: list[dict[str, Any]]) -> dict[str, dict[str, int]]:
    """Truth -> answer -> campaigns."""
    table: dict[str, dict[str, int]] = {}
    for record in records:
        truth, answer = record["truth"], record["answer"]
        row = table.setdefault(label(truth["verdict"], truth["effects"]), {})
        column = label(answer["verdict"], answer["effects"])
        row[column] = row.get(column, 0) + 1
    return table
