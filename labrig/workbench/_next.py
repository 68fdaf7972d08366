"""What to measure next, and two models on the same run: the parts of Watch that come before and after the rig."""

import json
from pathlib import Path
from typing import Any

from starlette.responses import Response
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig.workbench._answers import answering, body_of, says, told
from labrig.workbench._desk import Desk
from labrig.workbench._held import Key
from labrig.workbench._run import Pair, pair_of, run_folder
from labrig.workbench._shapes import captures_of, shape_of
from labrig.workbench._views import kept

_MOST_MINUTES = 100_000.0


def routes(desk: Desk) -> list[Route]:
    """`/api/next`, `/api/versus`: GET what is known, POST to have it computed as a job; `/api/versus/shapes`."""
    return [
        Route("/api/next", answering(lambda r: _next(desk, r.query_params))),
        Route("/api/next", answering(lambda r: _propose(desk, body_of(r))), methods=["POST"]),
        Route("/api/versus", answering(lambda r: _versus(desk, r.query_params))),
        Route("/api/versus", answering(lambda r: _compare(desk, body_of(r))), methods=["POST"]),
        Route("/api/versus/shapes", answering(lambda r: _shapes(desk, r.query_params))),
    ]


def _words(pair: Pair, minutes: float) -> list[str]:
    """The command that finds the programme; its two results lie with the others of the run and the model."""
    desk = pair.desk
    if desk.rig_file is None:
        raise LabrigError("its limits are needed: start the workbench with: labrig workbench --rig RIG.yaml")
    words = ["next", pair.run_name, *pair.together(), "--model", pair.model_name, "--rig", str(desk.rig_file)]
    words += ["--minutes", f"{minutes:g}", "-o", desk.name(pair.results / "next.yaml")]
    return [*words, "--out", desk.name(pair.results / "next"), "--force"]


def _next(desk: Desk, asked: Any) -> Any:
    """The programme that was found for a run and a model, as next.json has it; None where none was looked for as they
    are now.
    """
    pair = pair_of(desk, asked)
    found = _current(pair, pair.results / "next" / "next.json")
    procedure = pair.results / "next.yaml"
    words = [] if desk.rig_file is None else _words(pair, _minutes(asked))
    return {
        "settled": _settled(pair),
        "found": found,
        "procedure": desk.name(procedure) if found is not None and procedure.is_file() else "",
        "command": desk.command(words) if words else "",
    }


def _settled(pair: Pair) -> str:
    """Why nothing is left to measure, where the last look at this run and model, as they are now, said so."""
    asked = ("next", pair.run_name, "--model", pair.model_name)
    last = next((job for job in pair.desk.jobs.all() if job.words[: len(asked)] == asked), None)
    if last is None or last.ended is None or not last.had_nothing_to_do:
        return ""
    if not pair.is_older_than(round(last.ended.ended_s * 1e9)):
        return ""
    return last.facts()["last"].removeprefix("labrig: ")


def _propose(desk: Desk, asked: dict[str, Any]) -> Any:
    pair = pair_of(desk, asked)
    words = _words(pair, _minutes(asked))
    pair.results.mkdir(parents=True, exist_ok=True)
    job = desk.jobs.start(words, "what to measure next", pair.run_name)
    return says({"job": job.id, "command": job.command}, 202)


def _minutes(asked: Any) -> float:
    try:
        minutes = float(asked.get("minutes") or 10.0)
    except ValueError:
        minutes = 0.0
    if not 0.0 < minutes < _MOST_MINUTES:
        raise LabrigError(f"{asked.get('minutes')}: give a number of minutes, more than 0")
    return minutes


def _versus_words(desk: Desk, run: str, models: list[str]) -> tuple[list[str], Path]:
    if len(set(models)) != 2:
        raise LabrigError("choose two models: the one before and the one after")
    stems = [Path(model).stem for model in models]
    for model in models:
        desk.existing(model)
    folder = run_folder(desk, run) / f"{stems[0]}-and-{stems[1]}"
    words = ["compare", run, "--model", models[0], "--model", models[1], "--out", desk.name(folder)]
    return words, folder


def _versus(desk: Desk, asked: Any) -> Any:
    """Two models on one run, as comparison.json has it; None where they were not compared as they are now."""
    run, models = str(asked.get("run") or ""), [str(asked.get("a") or ""), str(asked.get("b") or "")]
    words, folder = _versus_words(desk, run, models)
    pairs = [pair_of(desk, {"run": run, "model": model}) for model in models]
    return {"found": _compared(pairs, folder / "comparison.json"), "command": desk.command(words)}


def _compared(pairs: list[Pair], path: Path) -> Any:
    """What the file says, if it is of these two in this order, and neither they nor the run have changed since."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        of = [
            (each.desk.folder / named["file"]).resolve()
            for each, named in zip(pairs, found["models"], strict=True)
        ]
        written = path.stat().st_mtime_ns
    except (OSError, ValueError, KeyError, TypeError):
        return None
    same = of == [pair.model for pair in pairs]
    return found if same and all(pair.is_older_than(written) for pair in pairs) else None


def _compare(desk: Desk, asked: dict[str, Any]) -> Any:
    run, models = str(asked.get("run") or ""), [str(asked.get("a") or ""), str(asked.get("b") or "")]
    words, _ = _versus_words(desk, run, models)
    job = desk.jobs.start(words, "two models on one run", run)
    return says({"job": job.id, "command": job.command}, 202)


def _shapes(desk: Desk, asked: Any) -> Any:
    """What is drawn of two models on one run."""
    run = str(asked.get("run") or "")
    keys = [pair_of(desk, {"run": run, "model": str(asked.get(name) or "")}).key for name in ("a", "b")]
    return Response(kept(desk, both, *keys), media_type="application/json")


def both(first: Key, second: Key) -> str:
    """Two models on the same run, before and after, as JSON; in the worker."""
    import labrig
    from labrig.diagnosis import versus

    result = versus(labrig.open_run(first[0]), labrig.Model.load(first[1]), labrig.Model.load(second[1]))
    summary = result.summary
    return told(
        {
            "units": summary["units"],
            "error": [each["error"] for each in summary["models"]],
            "floor": summary["error"]["floor"],
            "shape": shape_of(result),
            "captures": captures_of(result),
        }
    )


def _current(pair: Pair, path: Path) -> Any:
    """What a file of results says; None where there is none, or the run or the model has changed since."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        written = path.stat().st_mtime_ns
    except (OSError, ValueError):
        return None
    return found if pair.is_older_than(written) else None
