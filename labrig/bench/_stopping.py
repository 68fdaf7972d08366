"""Does stopping make a verdict surer than it is? The same campaigns, diagnosed as they grow, and judged where they end.

Every campaign is looked at all the way to its end, so that any stopping rule can be tried on the same records.
"""

import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from labrig._executor import Executor
from labrig.bench._draw import Campaign, draw
from labrig.bench._files import write_model
from labrig.bench._halves import make_rig
from labrig.bench._lines import adding_lines, read_lines
from labrig.bench._run import key_of
from labrig.bench.records import StoppingRecord

if TYPE_CHECKING:
    import xarray as xr

RECORDS = "stopping.jsonl"
MIX = ("single", "null", "pair", "single", "outside", "structural")
"""Classes in turn: half of the campaigns hide effects of the library, the others something else, or nothing."""
CAPTURES = 60
FIRST, GROWS = 12, 1.3
"""Captures at the first look, and by what each next look is later: a diagnosis takes longer than the captures do."""

_OF_TRUTH = ("class", "half", "seed", "effects", "also", "verdict", "without", "design", "captures", "floor")


def stopping_plan(count: int, seed: int, halves: Sequence[str]) -> list[tuple[str, str, int]]:
    """(half, class, seed) of `count` campaigns, halves and classes in turn."""
    return [
        (halves[k % len(halves)], MIX[(k // len(halves)) % len(MIX)], seed + k // len(halves))
        for k in range(count)
    ]


def looks_at(captures: int) -> list[int]:
    """After how many captures a campaign of so many is looked at: the last look is at all of it."""
    at, found = float(FIRST), []
    while round(at) < captures:
        found.append(round(at))
        at *= GROWS
    return [*found, captures]


def first_captures(dataset: "xr.Dataset", captures: int) -> "xr.Dataset":
    """The campaign as it was after so many captures: what was actuated later is not known yet."""
    cut = dataset.isel(capture=slice(0, captures))
    return cut.isel(event=slice(0, int(cut["event_of"].max()) + 1))


def acted(campaign: Campaign, captures: int) -> dict[str, float]:
    """How large each hidden effect was in the first captures, root mean square, in floors."""
    counts = np.isfinite(campaign.dataset["hold_s"].values[:captures]).sum()
    noisier = make_rig(campaign.truth["base"]).noisier
    return {
        name: float(np.sqrt(np.mean((part[:counts] / noisier) ** 2))) / campaign.truth["floor"]
        for name, part in campaign.parts.items()
    }


def watch(half: str, name: str, seed: int, captures: int = CAPTURES) -> StoppingRecord:
    """Draw a campaign and diagnose it as it grows; the record is plain JSON."""
    from labrig._json import plain
    from labrig.diagnosis import diagnose
    from labrig.live import Look
    from labrig.model import Model

    campaign = draw(name, seed, half, captures=captures)
    whole = campaign.dataset
    looks = []
    with tempfile.TemporaryDirectory(prefix="labrig-bench-", ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        for n in looks_at(whole.sizes["capture"]):
            part = first_captures(whole, n)
            minutes = float(part["time_s"].max()) / 60
            summary = diagnose(part, model, without=campaign.truth["without"]).summary
            look = Look.of(summary, n, minutes).to_dict()
            looks.append(look | {"rivals": summary["rivals"], "acted": acted(campaign, n)})
    truth = {key: campaign.truth[key] for key in _OF_TRUTH}
    return plain({"key": key_of(half, name, seed), "truth": truth, "looks": looks})


def stopping_records(folder: Path) -> list[StoppingRecord]:
    """The records that are done; a last line that was cut is left out."""
    return read_lines(folder / RECORDS)


def run_stopping(todo: list[tuple[str, str, int]], folder: Path, jobs: int = 1) -> Iterator[StoppingRecord]:
    """Watch campaigns, `jobs` at a time; each record is written as it is done, and skipped if it is there already."""
    done = {record["key"] for record in stopping_records(folder)}
    left = [one for one in todo if key_of(*one) not in done]
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # inherited by the workers: one core each
    with Executor(jobs) as executor, adding_lines(folder / RECORDS) as add:
        for _, record in executor.map(_watch, left):
            add(record)
            yield record


def _watch(task: tuple[str, str, int]) -> StoppingRecord:
    return watch(*task)
