"""An experiment as a procedure file that `labrig run` takes."""

from collections.abc import Sequence
from pathlib import Path

import yaml

from labrig._durable import write_whole
from labrig.contents import ProgrammePoint
from labrig.experiment._propose import Experiment


def write_procedure(experiment: Experiment, points: Sequence[ProgrammePoint], path: Path) -> None:
    """Write the `points` of a programme, in kPa, as a procedure file (YAML), in one piece or not at all."""
    summary = experiment.summary
    separates = ", ".join(summary["separates"]) or "what is open"
    rig = f" for rig {summary['rig']}" if "rig" in summary else ""
    lines = [
        f"# Written by labrig next{rig}: separates {separates}.",
        f"# Why: {summary['why']}.",
        f"# labrig run {path.name} --rig RIG.yaml --dry-run",
        "procedure: programme",
        "points:",
    ]
    lines += [f"- {_flow(point)}" for point in points]
    write_whole(path, "\n".join(lines) + "\n")


def _flow(point: ProgrammePoint) -> str:
    return yaml.safe_dump(
        dict(point), default_flow_style=True, sort_keys=False, width=10_000, allow_unicode=True
    ).strip()
