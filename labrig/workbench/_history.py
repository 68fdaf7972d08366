"""A rig over all its runs in the folder: `labrig history` as a job, and what it found."""

import json
import re
from pathlib import Path
from typing import Any

from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.contents import HistoryContent
from labrig.view import changed_pictures, history_headline, history_notes, history_pictures
from labrig.workbench._answers import answering, body_of, says
from labrig.workbench._desk import Desk
from labrig.workbench._run import Pair, pair_of, row_of

FOLDER = "history"


def routes(desk: Desk) -> list[Route]:
    """`/api/history`: GET what is known of a run's rig, POST to have all its runs read as a job."""
    return [
        Route("/api/history", answering(lambda r: _history(pair_of(desk, r.query_params)))),
        Route("/api/history", answering(lambda r: _look(pair_of(desk, body_of(r)))), methods=["POST"]),
    ]


def _history(pair: Pair) -> Any:
    """What was found of the rig with this model, in words and pictures, those first that show a change; None where
    nobody has looked.
    """
    rig = row_of(pair.desk, pair.run).rig
    words, place = _asked(pair, rig)
    return {"rig": rig, "found": _found(pair, rig, place), "command": pair.desk.command(words) if rig else ""}


def _look(pair: Pair) -> Any:
    rig = row_of(pair.desk, pair.run).rig
    if not rig:
        raise LabrigError(f"{pair.run_name} does not say on which rig it was measured")
    words, _ = _asked(pair, rig)
    job = pair.desk.jobs.start(words, f"history of {rig}", pair.run_name)
    return says({"job": job.id, "command": job.command}, 202)


def _asked(pair: Pair, rig: str) -> tuple[list[str], Path]:
    """The command, and the folder of its results: one for each rig and model."""
    stem = re.sub(r"[^\w.-]+", "-", f"{rig}-{pair.model.stem}")
    place = pair.desk.folder / FOLDER / stem
    words = ["history", rig, "--model", pair.model_name, "--runs", ".", "--out", f"{FOLDER}/{stem}"]
    return words, place


def _found(pair: Pair, rig: str, place: Path) -> Any:
    """What the file says, if it is of this rig and model and can be read."""
    try:
        content: HistoryContent = json.loads((place / "history.json").read_text(encoding="utf-8"))
        model = pair.desk.folder / str(content["model"])
        return _shown(content) if content["rig"] == rig and model.resolve() == pair.model else None
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        return None


def _shown(content: HistoryContent) -> dict[str, Any]:
    pictures = history_pictures(content)
    telling = dict.fromkeys([*changed_pictures(content), *pictures])
    return {
        "headline": history_headline(content),
        "runs": len(content["runs"]),
        "last": content["runs"][-1]["date"],
        "changes": [[c["words"], c["noticed_date"], c["since_fit"]] for c in content["changes"]],
        "notes": history_notes(content),
        "pictures": {name: pictures[name]() for name in telling},
    }
