"""What a live diagnosis costs the campaign: the overhead of a capture on the real clock, with it and without.

    python benchmarks/live.py [--captures 30] [--out benchmarks/RESULTS.md]

Writes the section "Live diagnosis" of the results.
"""

import argparse
import os
import platform
import statistics
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

from _streaming import CHAMBERS, FRAME_HZ, MARKERS, make_rig

from labrig.bench._report import write_section
from labrig.campaign import Watching, run
from labrig.live import LiveDiagnosis, Looker, Settings
from labrig.log import Topic, load_segments
from labrig_drivers import RealClock
from labrig_procedures import Capture
from labrig_schema.step_pb2 import Step

CAPTURE_S = 3.0
HEADING = "## Live diagnosis"


def overheads(folder: Path, captures: int, model: Path | None) -> tuple[list[float], int]:
    """The overhead of each capture as a share of its 3 s, from the log's own times; and how many looks there were."""
    clock = RealClock()
    plan = Capture(captures=captures, repeated=0, settle_s=CAPTURE_S - 1.0, record_s=1.0, highest=0.5)
    if model is None:
        run(plan, make_rig(clock), folder, clock)
        looks = 0
    else:
        looker = Looker([sys.executable, "-m", "labrig.api._live", str(folder), str(model)])
        adviser = LiveDiagnosis(Settings(str(model), every=1), captures, looker, waits=False)
        try:
            run(plan, make_rig(clock), folder, clock, watching=Watching(adviser=adviser))
        finally:
            looker.close(None)
        looks = len(adviser.looks)
    segments, _ = load_segments(folder)
    steps = [Step.FromString(payload) for payload in segments[0].messages(Topic.STEP).payload]
    done = [step for step in steps if step.state == Step.DONE]
    begins = [step.started_s for step in done if step.kind == "actuate"]
    ramps = [step.ended_s - step.started_s for step in done if step.kind == "actuate"]
    pairs = zip(pairwise(begins), ramps, strict=False)
    return [(after - before - ramp - CAPTURE_S) / CAPTURE_S for (before, after), ramp in pairs], looks


def main() -> None:
    """Measure, print, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--captures", type=int, default=30)
    parser.add_argument("--out", type=Path, default=None)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        model = folder / "model.yaml"
        model.write_text("base: {kind: static, degree: 1}\neffects: []\n")
        alone, _ = overheads(folder / "alone", asked.captures, None)
        beside, looks = overheads(folder / "beside", asked.captures, model)
    load = f", load average {os.getloadavg()[0]:.0f}" if hasattr(os, "getloadavg") else ""
    how = (
        f"`python benchmarks/live.py` on {platform.machine()}, {os.cpu_count()} cores{load}: {asked.captures} captures "
        f"of {CAPTURE_S:g} s on the real clock, {MARKERS} markers at {FRAME_HZ:g} Hz, {CHAMBERS} chambers; a new look "
        f"as soon as the last one is done ({looks} looks)."
    )
    rows = ["| overhead of a capture | median | mean | worst |", "| --- | --- | --- | --- |"]
    for what, shares in (("without", alone), ("with a live diagnosis", beside)):
        figures = (statistics.median(shares), statistics.fmean(shares), max(shares))
        rows.append(f"| {what} | " + " | ".join(f"{100 * value:.2f} %" for value in figures) + " |")
    print("\n".join([how, *rows]))
    if asked.out is not None:
        write_section(asked.out, HEADING, [how, "", *rows])


if __name__ == "__main__":
    main()
