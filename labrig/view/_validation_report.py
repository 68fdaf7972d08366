"""The report of a validation: predicted, realised and asked for, side by side, target by target."""

from collections.abc import Sequence
from datetime import datetime
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from labrig._text import counted, number
from labrig.shape_contents import Distances, Realisation
from labrig.view._ik_report import REPORT_NAME, write_page
from labrig.view._page import Page, table
from labrig.view._shape_figures import histogram, signed_map

if TYPE_CHECKING:
    from labrig.ik import Outcome

_LEAST_MM = 0.5
SHOWN = 16


def write_validation(outcomes: Sequence["Outcome"], run: str | Path, folder: str | Path) -> Path:
    """Write `report.html` into `folder` (made if it is missing), in one piece, and return its path."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    return write_page(validation_page(outcomes, run), folder / REPORT_NAME)


def validation_page(outcomes: Sequence["Outcome"], run: str | Path) -> Page:
    """The page, figures included."""
    summaries = [outcome.summary() for outcome in outcomes]
    page = Page("labrig: validation")
    scans = sum(one["scans"] for one in summaries if one["realised_mm"] is not None)
    when = datetime.now().astimezone().strftime("%d %B %Y, %H:%M")
    about = f"labrig validate · {Path(run).name} · {counted(len(outcomes), 'realisation')}, {counted(scans, 'scan')}"
    page.add(f'<div class="over"><span>{escape(about)} · {when}</span></div>')
    page.add(f"<h1>{escape(_headline(summaries))}</h1>")
    page.add(
        '<p class="lead">Each target was brought about on the rig by inverse kinematics, held, scanned, and the scan '
        "registered to the target. <b>Predicted</b>: the model’s surface against the target. <b>Realised</b>: the scan "
        "against the target. What the model itself leaves is out of the hardware’s reach, or so it believes; what "
        "realised and predicted differ by is the model’s error.</p>"
    )
    _table(page, summaries)
    _forms(page, summaries)
    order = sorted(range(len(outcomes)), key=lambda n: (outcomes[n].trial.name, outcomes[n].trial.number))
    for n in order[:SHOWN]:
        _outcome(page, outcomes[n], summaries[n])
    return page


def _headline(summaries: Sequence[Realisation]) -> str:
    from labrig.ik import WHOLE

    whole = [one for one in summaries if one["model"] == WHOLE]
    realised = [found["mean"] for one in whole if (found := one["realised_mm"])]
    differ = [found["mean"] for one in whole if (found := one["realised_against_predicted_mm"])]
    if not realised:
        markers = [
            one["markers_against_predicted_mm"]["mean"]
            for one in whole
            if one["markers_against_predicted_mm"]
        ]
        if not markers:
            return "Nothing was measured"
        return f"The markers come within {number(float(np.mean(markers)))} mm of where the model expects them"
    return (
        f"Realised to {number(float(np.mean(realised)))} mm on average; "
        f"the model is off by {number(float(np.mean(differ)))} mm"
    )


def _table(page: Page, summaries: Sequence[Realisation]) -> None:
    page.section(
        "Every realisation",
        "Absolute distances, mm: mean / 95 % / maximum over the target’s points that have the surface opposite. "
        "Markers: distance from where the model expects them, in the rig’s frame.",
    )
    best_known = any(one["hardware_mm"] for one in summaries)
    rows = []
    for one in summaries:
        refined = [again["realised_mm"]["mean"] for again in one["refined"] if again["realised_mm"]]
        first = one["realised_mm"]
        closest = min([*refined, *([first["mean"]] if first else [])]) if refined else 0.0
        refining = f"{number(closest)} with {counted(len(refined), 'scan')} more" if refined else "–"
        rows.append(
            [
                escape(one["target"]),
                escape(one["model"]),
                *([_three(one["hardware_mm"])] if best_known else []),
                _three(one["predicted_mm"]),
                _three(one["realised_mm"]),
                _three(one["realised_against_predicted_mm"]),
                number((one["markers_against_predicted_mm"] or {}).get("mean")),
                refining,
            ]
        )
    best = ["hardware’s best"] if best_known else []
    distances = ["predicted", "realised", "realised – predicted", "markers"]
    header = ["target", "model", *best, *distances, "refined on the rig"]
    page.add(table(header, rows, ["", "", *["number"] * (len(header) - 3), ""]))
    if best_known:
        page.add(
            '<p class="about">The hardware’s best is the best that was found on the simulated plant itself, to the '
            "accuracy of that search: what is left there is not the model’s.</p>"
        )


def _three(values: Distances | None) -> str:
    return "–" if values is None else " / ".join(number(values[key]) for key in ("mean", "p95", "max"))


def _forms(page: Page, summaries: Sequence[Realisation]) -> None:
    """With and without: means over the targets that were realised with every form."""
    forms = list(dict.fromkeys(one["model"] for one in summaries))
    if len(forms) < 2:
        return
    page.section("With and without", "The same targets with less of the model; means over the targets, mm.")
    rows = []
    for form in forms:
        own = [one for one in summaries if one["model"] == form]
        rows.append(
            [escape(form), *(_mean(own, key) for key in ("realised_mm", "realised_against_predicted_mm"))]
        )
    page.add(table(["model", "realised", "realised – predicted"], rows, ["", "number", "number"]))


def _mean(summaries: Sequence[Realisation], key: str) -> str:
    known = [one[key]["mean"] for one in summaries if one[key]]
    return number(float(np.mean(known))) if known else "–"


def _outcome(page: Page, outcome: "Outcome", summary: Realisation) -> None:
    trial, mesh = outcome.trial, outcome.trial.target.mesh
    realised = outcome.attempts[0].height_mm
    page.section(
        f"{trial.name}, {trial.form}",
        f"{trial.approach.name}, {trial.approach.duration_s:g} s. {_scan(summary)}",
    )
    shown = [("predicted", outcome.predicted_mm)]
    if realised is not None:
        shown.append(("realised", realised))
    if len(outcome.attempts) > 1 and outcome.best.height_mm is not None:
        shown.append((f"refined, {counted(len(outcome.attempts) - 1, 'scan')} more", outcome.best.height_mm))
    known = np.concatenate([np.abs(height[np.isfinite(height)]) for _, height in shown])
    top = max(_LEAST_MM, float(np.quantile(known, 0.98))) if len(known) else 1.0
    maps = [(name, height, top) for name, height in shown]
    if outcome.hardware_mm is not None:
        maps.insert(0, ("hardware’s best", outcome.hardware_mm, top))
    if realised is not None:
        between = realised - outcome.predicted_mm
        spread = np.abs(between[np.isfinite(between)])
        own = max(_LEAST_MM, float(np.quantile(spread, 0.98))) if len(spread) else 1.0
        maps.append(("realised – predicted", between, own))
    if not mesh.is_cloud:
        drawn = "".join(
            f'<div class="plot"><h3>{escape(name)}</h3>'
            f"{page.plot(signed_map(mesh.vertices_mm, mesh.triangles, height, limit))}</div>"
            for name, height, limit in maps
        )
        columns = 3 if len(maps) == 3 else 2
        page.add(f'<div class="plots" style="grid-template-columns:repeat({columns},1fr)">{drawn}</div>')
    page.add(page.plot(histogram(shown, 1.3 * top)))


def _scan(summary: Realisation) -> str:
    found = summary["registration"]
    if found is None:
        return "No scan."
    if found["sd_mm"] is None:
        return (
            "How exactly the scan is registered is not known: it can slide or turn on the surface and fit as well, so "
            "a distance may belong to a place beside its own."
        )
    return f"The scan is registered to {number(found['sd_mm'])} mm."
