"""The looker's own side: reads the run's log as it grows, diagnoses what is there, and keeps the picture fresh."""

import json
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.live._look import Look
from labrig.run_contents import LiveAnswer, RangeContent

if TYPE_CHECKING:
    from labrig.model import Model

RECORD = "diagnosis-live.json"
LOWEST = 19

Draw = Callable[[Sequence[Look], "str | None", Path], Any]
"""Draws looks, and why the campaign ended, into a folder."""


def serve(
    folder: Path, model_file: Path, questions: Iterable[str], say: Callable[[str], Any], draw: Draw
) -> None:
    """Answer questions (lines of JSON) until there are no more; each look goes into `diagnosis-live.json` too."""
    from labrig.model import Model

    looks = _earlier(folder)
    model: Model | None = None
    for line in questions:
        question = json.loads(line)
        if "end" in question:
            _keep(folder, looks, question["end"], draw)
            return
        try:
            model = model or Model.load(model_file)
            look, found = _look(folder, model, question.get("adapt"))
        except Exception as error:  # whatever it is, the campaign has its plan
            say(json.dumps({"trouble": f"the diagnosis failed: {type(error).__name__}: {error}"}))
            continue
        say(json.dumps({"look": look.to_dict(), **found}))
        looks = [*(each for each in looks if each.captures < look.captures), look]
        _keep(folder, looks, None, draw)


def _look(folder: Path, model: "Model", adapt: RangeContent | None) -> tuple[Look, LiveAnswer]:
    """Diagnose all that is whole in the log; with the range of a plan to `adapt`, propose what comes next, too."""
    from labrig._json import plain
    from labrig.diagnosis import diagnose
    from labrig.live._adapt import propose
    from labrig.log import open_run

    run = open_run(folder)
    summary = diagnose(run, model).summary
    minutes = float(run["time_s"].max()) / 60
    look = Look.of(summary, run.sizes["capture"], minutes)
    return look, {} if adapt is None else {"points": plain(propose(run, model, summary, **adapt))}


def _earlier(folder: Path) -> list[Look]:
    """The looks of a run that was interrupted; they are for the picture only."""
    try:
        kept = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        return [Look.from_dict(one) for one in kept["looks"]]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def _keep(folder: Path, looks: Sequence[Look], ended: str | None, draw: Draw) -> None:
    from labrig._json import write_json

    if not looks:
        return
    try:
        write_json({"looks": [look.to_dict() for look in looks], "ended": ended}, folder / RECORD)
        draw(looks, ended, folder)
    except Exception as error:  # a picture is not worth more
        print(f"no picture: {type(error).__name__}: {error}", file=sys.stderr)


def lower_priority() -> None:
    """Run only when nobody else wants to; on Windows whoever starts this process says so."""
    if hasattr(os, "nice"):
        os.nice(LOWEST)
