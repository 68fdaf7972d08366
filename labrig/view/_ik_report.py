"""The report of inverse kinematics: pressures, error maps, and what stays out of reach, in one HTML file."""

from collections.abc import Sequence
from datetime import datetime
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from labrig._durable import write_whole
from labrig._text import counted, number
from labrig.view._page import Page, bar, table
from labrig.view._shape_figures import histogram, signed_map

if TYPE_CHECKING:
    from labrig.ik import Solved

REPORT_NAME = "report.html"
SHOWN = 12
"""Targets that get a map: those that fit worst."""
_LEAST_MM = 0.5


def write_ik_report(solved: Sequence["Solved"], model: str, folder: str | Path) -> Path:
    """Write `report.html` into `folder` (made if it is missing), in one piece, and return its path."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    return write_page(ik_page(solved, model), folder / REPORT_NAME)


def write_page(page: Page, path: Path) -> Path:
    """Write a page under another name first, so that a report is never half a report."""
    write_whole(path, page.html())
    return path


def ik_page(solved: Sequence["Solved"], model: str) -> Page:
    """The page, figures included."""
    good = [one for one in solved if one.result is not None]
    means = [one.summary["mean_mm"] for one in good if one.summary is not None]
    page = Page("labrig: inverse kinematics")
    when = datetime.now().astimezone().strftime("%d %B %Y, %H:%M")
    about = f"labrig ik · {counted(len(solved), 'target')} · {Path(model).name} · {when}"
    page.add(f'<div class="over"><span>{escape(about)}</span></div>')
    page.add(f"<h1>{escape(_headline(solved, means))}</h1>")
    page.add(
        '<p class="lead">Pressures within the limits and the pose that bring the model’s surface closest to each '
        "target. Distances are signed: positive where the surface stands out of the target, negative where it stays "
        "inside.</p>"
    )
    _summary_table(page, solved)
    shown = sorted(good, key=lambda one: -(one.summary or {}).get("mean_mm", 0.0))[:SHOWN]
    if len(good) > SHOWN:
        page.add(f'<p class="about">Maps of the {SHOWN} that fit worst.</p>')
    for one in shown:
        _target(page, one)
    return page


def _headline(solved: Sequence["Solved"], means: list[float]) -> str:
    if not means:
        return "No target could be solved"
    failed = len(solved) - len(means)
    lost = f"; {counted(failed, 'target')} could not be solved" if failed else ""
    if len(means) == 1:
        return f"The surface comes within {number(means[0])} mm of the target on average{lost}"
    return (
        f"The surface comes within {number(float(np.median(means)))} mm of the median target on average{lost}"
    )


def _summary_table(page: Page, solved: Sequence["Solved"]) -> None:
    top = max((one.summary["mean_mm"] for one in solved if one.summary is not None), default=1.0) or 1.0
    rows = []
    for one in solved:
        name = escape(Path(one.job.target).name)
        if one.result is None or one.summary is None:
            rows.append([name, "", "–", "–", "–", "–", escape(one.error), "–"])
            continue
        summary, result = one.summary, one.result
        rows.append(
            [
                name,
                bar(summary["mean_mm"] / top, 90),
                number(summary["mean_mm"]),
                number(summary["p95_mm"]),
                number(summary["max_mm"]),
                f"{100 * summary['share']:.0f} %",
                escape(", ".join(result.limited) or "none"),
                number(1e3 * (result.time_s + result.prepare_s)),
            ]
        )
    header = ["target", "", "mean, mm", "95 %, mm", "max, mm", "compared", "at a limit", "time, ms"]
    classes = ["", "bars", "number", "number", "number", "number", "", "number"]
    page.section(
        "Every target",
        "Distance between the model’s surface and the target, where they lie opposite each other; ‘compared’ is how "
        "much of the surface that is.",
    )
    page.add(table(header, rows, classes))


def _target(page: Page, one: "Solved") -> None:
    result = one.result
    if result is None or one.signed_mm is None or one.surface_mm is None or one.triangles is None:
        return
    page.section(Path(one.job.target).name, _about(one))
    known = np.abs(one.signed_mm[np.isfinite(one.signed_mm)])
    top = max(_LEAST_MM, float(np.quantile(known, 0.98))) if len(known) else 1.0
    map_ = page.plot(signed_map(one.surface_mm, one.triangles, one.signed_mm, top))
    spread = page.plot(histogram([("predicted", one.signed_mm)], top * 1.3))
    page.add(
        f'<div class="plots"><div class="plot">{map_}</div><div class="plot">{_pressures(one)}{spread}</div></div>'
    )
    if result.gaps:
        lines = "".join(f"<p>The surface {escape(gap.words)}.</p>" for gap in result.gaps)
        page.add(f'<div class="warnings"><h3>Out of reach</h3>{lines}</div>')


def _about(one: "Solved") -> str:
    result = one.result
    assert result is not None
    notes = "".join(f"; {note}" for note in result.notes)
    starts = f" from {result.starts} starts" if result.starts > 1 else ""
    return f"{counted(result.iterations, 'step')}{starts}{notes}. Turn it with the mouse."


def _pressures(one: "Solved") -> str:
    result = one.result
    assert result is not None
    top = max(float(result.pressure_kpa.max()), 1e-9)
    rows = [
        [
            escape(name),
            bar(value / top, 110),
            number(float(value)),
            "limit" if name in result.limited else f"± {number(float(sd))}",
        ]
        for name, value, sd in zip(result.chamber_names, result.pressure_kpa, result.sd_kpa, strict=True)
    ]
    return table(["chamber", "", "kPa", ""], rows, ["", "bars", "number", "number"])
