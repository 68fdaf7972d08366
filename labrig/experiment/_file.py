"""An experiment as a procedure file that `labrig run` takes."""

from collections.abc import Sequence
from pathlib import Path

import yaml

from labrig._durable import write_whole
from labrig.contents import ProgrammePoint
from labrig.experiment._again import Again
from labrig.experiment._experiment import Experiment


def write_procedure(
    experiment: Experiment, points: Sequence[ProgrammePoint], path: Path, without: Again | None = None
) -> None:
    """Write the `points` of a programme, in kPa, as a procedure file (YAML), in one piece or not at all.

    They are those of the experiment, or those to be measured `without` an effect.
    """
    summary = experiment.summary
    separates = ", ".join(summary["separates"]) or "what is open"
    rig = f" for rig {summary['rig']}" if "rig" in summary else ""
    ruled_out = summary.get("ruled_out") if without is None else without.effect
    why = summary["why"] if without is None else without.why
    before = {ruled_out, summary.get("put_back")} if without is None else {ruled_out}
    first = [f"# First {hand['what']}." for hand in summary["by_hand"] if hand["effect"] in before]
    lines = [
        f"# Written by labrig next{rig}: separates {separates if without is None else ruled_out}.",
        f"# Why: {why}.",
        *first,
        f"# labrig run {path.name} --rig RIG.yaml --dry-run",
        *([f"# Then say so: labrig rule-out RUN {ruled_out}"] if ruled_out else []),
        "procedure: programme",
        "points:",
    ]
    lines += [f"- {_flow(point)}" for point in points]
    write_whole(path, "\n".join(lines) + "\n")


def _flow(point: ProgrammePoint) -> str:
    return yaml.safe_dump(
        dict(point), default_flow_style=True, sort_keys=False, width=10_000, allow_unicode=True
    ).strip()
