"""How long a diagnosis takes, and how that grows with the campaign."""

import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.bench._draw import draw
from labrig.bench._files import write_model
from labrig.bench._report import markdown, write_section

if TYPE_CHECKING:
    from rich.table import Table

Timed = tuple[int, int, float, float]  # captures, numbers measured, seconds of wall and of processor time

_HEAD = ["captures", "numbers", "seconds", "processor s", "processor ms per capture"]


def time_diagnosis(captures: int, seed: int = 0) -> Timed:
    """Captures, numbers measured, wall and processor time of a diagnosis of a rig with many markers."""
    from labrig.diagnosis import diagnose
    from labrig.model import Model

    campaign = draw("single", seed, captures=captures)
    while campaign.dataset.sizes["chamber"] < 9 or "position_mm" not in campaign.dataset:
        seed += 1
        campaign = draw("single", seed, captures=captures)
    with tempfile.TemporaryDirectory(prefix="labrig-bench-", ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        began, worked = time.perf_counter(), time.process_time()
        diagnose(campaign.dataset, model)
        seconds, processor = time.perf_counter() - began, time.process_time() - worked
    data = campaign.dataset
    return data.sizes["capture"], int(data["position_mm"].notnull().sum()), seconds, processor


def _rows(timed: list[Timed]) -> list[list[str]]:
    return [[str(n), str(k), f"{s:.1f}", f"{p:.1f}", f"{1000.0 * p / n:.0f}"] for n, k, s, p in timed]


def speed_table(timed: list[Timed]) -> "Table":
    """The times for a terminal."""
    from rich.table import Table

    out = Table(title="time of a diagnosis")
    for name in _HEAD:
        out.add_column(name, justify="right")
    for row in _rows(timed):
        out.add_row(*row)
    return out


def write_speed(timed: list[Timed], path: Path) -> None:
    """Put the times into a Markdown file under "Speed of a diagnosis"."""
    how = "`labrig bench speed`: nine chambers, many markers, the whole library, one campaign of each size."
    write_section(path, "## Speed of a diagnosis", [how, "", *markdown(_HEAD, _rows(timed))])
