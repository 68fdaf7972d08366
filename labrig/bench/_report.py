"""The benchmark for people: a table, a confusion matrix as a picture, and a section of RESULTS.md."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.bench._classes import FAMILIES

if TYPE_CHECKING:
    from rich.table import Table

_VERDICTS = ("nothing_missing", "multiple", "confounded", "unknown", "underpowered", "error")
_HEADING = "## Blind benchmark"


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100.0 * share:.1f} %"


def _p10(entry: dict[str, float] | None) -> str:
    return "" if entry is None else f"{entry['p10']:.2f}"


def rows_of_table(summary: dict[str, Any]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table of classes."""
    names = sorted({b for c in summary["classes"].values() for b in c["baselines"]})
    boxed = "black box" in names
    names = [name for name in names if name != "black box"]
    head = ["class", "n", "right", "95 %", "named", "alarms", "goal", "fresh drop p10", "s"]
    head += [f"{name}: right" for name in names] + [f"{name}: alarms" for name in names]
    head += ["black box: drop p10"] if boxed else []
    rows = []
    for name, entry in summary["classes"].items():
        low, high = entry["right_interval"]
        others = entry["baselines"]
        null = entry["false_alarms"] is not None
        goal = "" if entry["goal"] is None else f"{entry['goal']}{'' if entry['reached'] else ' (missed)'}"
        rows.append(
            [name, str(entry["campaigns"]), _percent(entry["right"]), f"{100 * low:.0f}-{100 * high:.0f}"]
            + ["" if null else _percent(entry["named_among"]), _percent(entry["false_alarms"]), goal]
            + [_p10(entry["fresh_drop"]), f"{entry['seconds']:.1f}"]
            + [_percent(others.get(b, {}).get("right")) for b in names]
            + [_percent(others.get(b, {}).get("false_alarms")) if null else "" for b in names]
            + (["" if null else _p10(others.get("black box", {}).get("fresh_drop"))] if boxed else [])
        )
    return head, rows


def tables(summary: dict[str, Any]) -> list["Table"]:
    """The figures of all classes, and those of the baselines, for a terminal."""
    from rich.table import Table

    head, rows = rows_of_table(summary)
    own = head.index("s") + 1
    parts = [
        (f"{summary['campaigns']} blind campaigns", list(range(own))),
        ("The same with other methods", [0, *range(own, len(head))]),
    ]
    out = []
    for title, columns in parts:
        if len(columns) == 1:
            continue
        part = Table(title=title)
        for column in columns:
            part.add_column(head[column], justify="left" if head[column] in ("class", "goal") else "right")
        for row in rows:
            part.add_row(*(row[column] for column in columns))
        out.append(part)
    return out


def lines(summary: dict[str, Any]) -> list[str]:
    """What is true of the whole benchmark, in a few lines."""
    calibration, fresh = summary["calibration"], summary["fresh_drop"]
    out = []
    if calibration["ece"] is not None:
        out.append(
            f"Probability of the verdict: ECE {calibration['ece']:.3f}, Brier {calibration['brier']:.3f} "
            f"over {calibration['campaigns']} campaigns."
        )
    if fresh is not None:
        box = summary["black_box_fresh_drop"]
        beside = "" if box is None else f" (black box: {box['p10']:.2f}, median {box['median']:.2f})"
        out.append(
            "Drop of the error on a fresh programme, where the effects were named rightly: tenth percentile "
            f"{fresh['p10']:.2f}, median {fresh['median']:.2f} over {fresh['campaigns']} campaigns{beside}."
        )
    if summary["failures"]:
        out.append(f"Failed to answer: {', '.join(summary['failures'])}.")
    return out


def write_report(summary: dict[str, Any], folder: Path) -> None:
    """Write summary.json and confusion.png."""
    _replace(folder / "summary.json", json.dumps(summary, indent=1) + "\n")
    _draw_confusion(summary["confusion"], folder / "confusion.png")


def write_results(summary: dict[str, Any], path: Path, how: str) -> None:
    """Put the figures into a Markdown file under "Blind benchmark"; the rest of the file stays as it is."""
    head, rows = rows_of_table(summary)
    write_section(path, _HEADING, [how, "", *markdown(head, rows), "", *lines(summary)])


def markdown(head: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a Markdown table."""
    return ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]


def write_section(path: Path, heading: str, below: list[str]) -> None:
    """Put lines under a heading of a Markdown file, in place of what was there."""
    text = path.read_text(encoding="utf-8") if path.exists() else "# Measured results\n"
    before, found, rest = text.partition(heading + "\n")
    after = rest[rest.find("\n## ") + 1 :] if found and "\n## " in rest else ""
    section = "\n".join([heading, "", *below, ""])
    joined = before.rstrip("\n") + "\n\n" + section + ("\n" + after if after else "")
    path.parent.mkdir(parents=True, exist_ok=True)
    _replace(path, joined)


def _draw_confusion(confusion: dict[str, dict[str, int]], path: Path) -> None:
    """Truth down, answer across; shares of a row in colour, campaigns as numbers."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    order = [*(e for family in FAMILIES.values() for e in family), *_VERDICTS]
    answers = [name for name in order if any(name in row for row in confusion.values()) or name in confusion]
    truths = [name for name in order if name in confusion]
    count = np.array([[confusion[t].get(a, 0) for a in answers] for t in truths])
    share = count / np.maximum(count.sum(axis=1, keepdims=True), 1)
    figure, axes = plt.subplots(
        figsize=(1.5 + 0.5 * len(answers), 1.8 + 0.42 * len(truths)), layout="constrained"
    )
    axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for (i, j), n in np.ndenumerate(count):
        if n:
            axes.text(
                j, i, str(n), ha="center", va="center", color="white" if share[i, j] > 0.55 else "black"
            )
    axes.set_xticks(range(len(answers)), [a.replace("_", " ") for a in answers], rotation=60, ha="right")
    axes.set_yticks(range(len(truths)), [t.replace("_", " ") for t in truths])
    axes.set_xlabel("verdict")
    axes.set_ylabel("hidden")
    partial = path.with_name(path.name + ".part")
    figure.savefig(partial, format="png", dpi=130)
    plt.close(figure)
    partial.replace(path)


def _replace(path: Path, text: str) -> None:
    partial = path.with_name(path.name + ".part")
    partial.write_text(text, encoding="utf-8", newline="\n")
    partial.replace(path)
