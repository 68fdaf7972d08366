"""The benchmark for people: tables, confusion matrices as pictures, and a section of RESULTS.md."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._durable import put_at
from labrig.bench._classes import FAMILIES
from labrig.bench.records import (
    BenchSummary,
    ClassFigures,
    GoalFigure,
    HalvesDifference,
    Interval,
    PartFigures,
    Spread,
)

if TYPE_CHECKING:
    from rich.table import Table

_VERDICTS = ("nothing_missing", "multiple", "confounded", "unknown", "underpowered", "error")
_HEADING = "## Blind benchmark"
_MOST_WRONG = 40

Rows = list[list[str]]


def _percent(figure: Interval | float | None) -> str:
    if figure is None:
        return ""
    return f"{100.0 * (figure['value'] if isinstance(figure, dict) else figure):.1f} %"


def _interval(figure: Interval | None) -> str:
    return "" if figure is None else f"{100 * figure['low']:.0f}-{100 * figure['high']:.0f}"


def _p10(entry: Spread | None) -> str:
    return "" if entry is None else f"{entry['p10']:.2f}"


def class_rows(classes: dict[str, ClassFigures]) -> tuple[list[str], Rows]:
    """Head and rows of the table of classes."""
    head = [
        "class",
        "n",
        "right",
        "95 %",
        "named",
        "wrong sure",
        "95 %",
        "alarms",
        "95 %",
        "fresh drop p10",
        "s",
    ]
    rows = []
    for name, entry in classes.items():
        row = [name, str(entry["campaigns"]), _percent(entry["right"]), _interval(entry["right"])]
        row += [_percent(entry["named_among"]), _percent(entry["wrong_sure"]), _interval(entry["wrong_sure"])]
        row += [_percent(entry["false_alarms"]), _interval(entry["false_alarms"])]
        rows.append([*row, _p10(entry["fresh_drop"]), f"{entry['seconds']:.1f}"])
    return head, rows


def baseline_rows(classes: dict[str, ClassFigures]) -> tuple[list[str], Rows]:
    """Head and rows of the table of other methods; no rows without them."""
    names = sorted({b for c in classes.values() for b in c["baselines"]})
    boxed = "black box" in names
    names = [name for name in names if name != "black box"]
    head = ["class", *(f"{name}: right" for name in names), *(f"{name}: alarms" for name in names)]
    head += ["black box: drop p10"] if boxed else []
    rows = []
    for name, entry in classes.items():
        others, null = entry["baselines"], entry["false_alarms"] is not None
        row = [name] + [_percent(others.get(b, {}).get("right")) for b in names]
        row += [_percent(others.get(b, {}).get("false_alarms")) if null else "" for b in names]
        row += (["" if null else _p10(others.get("black box", {}).get("fresh_drop"))]) if boxed else []
        rows.append(row)
    return head, rows if len(head) > 1 else []


def goal_rows(goals: list[GoalFigure]) -> tuple[list[str], Rows]:
    """Head and rows of the table of goals."""
    rows = []
    for goal in goals:
        figure, percent = goal["figure"], goal["percent"]
        value = _percent(figure) if percent else f"{figure['value']:.3f}"
        between = _interval(figure) if percent else f"{figure['low']:.3f}-{figure['high']:.3f}"
        rows.append([goal["what"], goal["goal"], value, between, str(figure["of"]), goal["status"]])
    return ["figure", "goal", "value", "95 %", "n", "status"], rows


def part_rows(what: list[str], parts: list[PartFigures]) -> tuple[list[str], Rows]:
    """Head and rows of a table by effect, law, rig or base."""
    head = [*what, "n", "right", "95 %", "sure", "95 %", "sure or possible", "95 %", "wrong sure", "95 %"]
    rows = []
    for part in parts:
        row = [*part["name"], "" if part["right"] is None else str(part["right"]["of"])]
        for key in ("right", "true_sure", "true_possible", "wrong_sure"):
            row += [_percent(part[key]), _interval(part[key])]
        rows.append(row)
    return head, rows


def difference_rows(differences: list[HalvesDifference]) -> tuple[list[str], Rows]:
    """Head and rows of the table that has the halves side by side."""
    head = ["class", "development", "95 %", "exam", "95 %", "difference, points", "95 %", "within 5"]
    rows = []
    for entry in differences:
        own, other, by = entry["development"], entry["exam"], entry["difference"]
        row = [entry["what"], _percent(own), _interval(own), _percent(other), _interval(other)]
        between = f"{100 * by['low']:+.0f} to {100 * by['high']:+.0f}"
        rows.append([*row, f"{100 * by['value']:+.1f}", between, entry["status"]])
    return head, rows


def sections(summary: BenchSummary) -> list[tuple[str, list[str], Rows]]:
    """Title, head and rows of every table that has rows."""
    out = []
    for half, own in summary["halves"].items():
        out += [
            (f"{half}: {own['campaigns']} campaigns", *class_rows(own["classes"])),
            (f"{half}: goals", *goal_rows(own["goals"])),
            (f"{half}: by hidden effect, where it can be named", *part_rows(["effect"], own["effects"])),
        ]
        for key, what in (("laws", ["effect", "law"]), ("rigs", ["rig"]), ("bases", ["base"])):
            if key in own:
                out.append((f"{half}: by {what[-1]}", *part_rows(what, own[key])))
        out.append((f"{half}: the same with other methods", *baseline_rows(own["classes"])))
    if "difference" in summary:
        out.append(("right verdicts: development minus exam", *difference_rows(summary["difference"])))
    return [(title, head, rows) for title, head, rows in out if rows]


def tables(summary: BenchSummary) -> list["Table"]:
    """All figures for a terminal."""
    from rich.table import Table

    out = []
    for title, head, rows in sections(summary):
        table = Table(title=title)
        for column in head:
            left = column in ("class", "figure", "goal", "effect", "law", "rig", "base", "status")
            table.add_column(column, justify="left" if left else "right")
        for row in rows:
            table.add_row(*row)
        out.append(table)
    return out


def lines(summary: BenchSummary) -> list[str]:
    """What is true of a whole half, in a few lines."""
    out = []
    for half, own in summary["halves"].items():
        totals, said = own["totals"], []
        for key, what in (("verdict", "verdicts"), ("effect", "effects")):
            ece, brier = totals[f"{key}_ece"], totals[f"{key}_brier"]
            if ece is not None:
                said.append(
                    f"probability of {what}: ECE {ece['value']:.3f} ({ece['low']:.3f} to {ece['high']:.3f}), "
                    f"Brier {brier['value']:.3f}"
                )
        p10, median, box = (
            totals["fresh_drop_p10"],
            totals["fresh_drop_median"],
            totals["black_box_fresh_drop"],
        )
        if p10 is not None and median is not None:
            beside = "" if box is None else f" (black box: {box['p10']:.2f}, median {box['median']:.2f})"
            said.append(
                "drop of the error on a fresh programme, where the effects were named rightly: tenth percentile "
                f"{p10['value']:.2f} ({p10['low']:.2f} to {p10['high']:.2f}), median {median['value']:.2f} over "
                f"{p10['of']} campaigns{beside}"
            )
        if own["failures"]:
            said.append(f"{own['failures']} campaigns failed to answer")
        out += [f"{half}: {one}." for one in said]
    return out


def wrong_lines(summary: BenchSummary) -> list[str]:
    """The campaigns that were not answered rightly, one to a line, of the halves of which that may be said."""
    wrong = [
        f"{one['key']}: {'+'.join(one['truth']) or 'nothing'} -> {one['answer']}"
        for own in summary["halves"].values()
        for entry in own["classes"].values()
        for one in entry.get("wrong", [])
    ]
    more = len(wrong) - _MOST_WRONG
    return wrong[:_MOST_WRONG] + ([f"and {more} more (summary.json)"] if more > 0 else [])


def write_report(summary: BenchSummary, folder: Path) -> None:
    """Write summary.json, and confusion.png of each half of which it may be said (exam-confusion.png of the exam)."""
    _replace(folder / "summary.json", json.dumps(summary, indent=1) + "\n")
    for half, own in summary["halves"].items():
        if confusion := own.get("confusion"):
            name = "confusion.png" if half == "development" else f"{half}-confusion.png"
            _draw_confusion(confusion, folder / name)


def write_results(summary: BenchSummary, path: Path, how: str) -> None:
    """Put the figures into a Markdown file under "Blind benchmark"; the rest of the file stays as it is."""
    below = [how]
    for title, head, rows in sections(summary):
        below += ["", f"**{title[0].upper()}{title[1:]}**", "", *markdown(head, rows)]
    write_section(path, _HEADING, [*below, "", *lines(summary)])


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
    put_at(partial, path)


def _replace(path: Path, text: str) -> None:
    partial = path.with_name(path.name + ".part")
    partial.write_text(text, encoding="utf-8", newline="\n")
    put_at(partial, path)
