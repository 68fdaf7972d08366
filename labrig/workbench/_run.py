"""One run beside one model: which models and results there are, and which steps have something to show."""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig._running import notes
from labrig._text import counted
from labrig.catalogue import Row, list_runs
from labrig.contents import Summary
from labrig.log import read_notes, run_id, segment_paths
from labrig.workbench._answers import answering
from labrig.workbench._desk import Desk
from labrig.workbench._ended import row_said
from labrig.workbench._fits import base_file, effects_in, own_effects, unreadable
from labrig.workbench._held import Key, stamp
from labrig.workbench._models import far_models, near_models, results_name


@dataclass(frozen=True)
class Pair:
    """A run and a model of the desk's folder, by their paths and by their names below it."""

    desk: Desk
    run: Path
    model: Path

    @property
    def run_name(self) -> str:
        """The run below the folder."""
        return self.desk.name(self.run)

    @property
    def model_name(self) -> str:
        """The model below the folder."""
        return self.desk.name(self.model)

    @property
    def key(self) -> Key:
        """What the worker knows them by."""
        return str(self.run), str(self.model)

    @cached_property
    def results(self) -> Path:
        """Where results of the two lie: where some are already, else a folder in the run's, of the model's name."""
        own = self.run / results_name(self.desk, self.run, self.model)
        for name in ("diagnosis.json", "compare.json"):
            for place in (own, self.run, self.run.parent):
                if place.is_relative_to(self.desk.folder) and self._is_about(place / name):
                    return place
        return own

    def has(self, name: str) -> bool:
        """Whether there is a result file of this run beside this model as they are now."""
        path = self.results / name
        return self._is_about(path)

    def diagnosis(self) -> Summary:
        """The content of diagnosis.json; raises `LabrigError` where there is none of these two."""
        if not self.has("diagnosis.json"):
            raise LabrigError(
                f"{self.run_name} is not diagnosed with {self.model_name} yet: find the missing effect in Which first"
            )
        return json.loads((self.results / "diagnosis.json").read_text(encoding="utf-8"))

    def together(self) -> list[str]:
        """The other runs that the diagnosis is of; none where there is no diagnosis."""
        if not self.has("diagnosis.json"):
            return []
        own, runs = run_id(self.run), self.diagnosis().get("runs", [])
        return [run["run"] for run in runs if run["id"] != own and (self.desk.folder / run["run"]).is_dir()]

    def is_older_than(self, written_ns: int) -> bool:
        """Whether the run, the model, its base and effects of people's own are as when a result was written."""
        files = [self.model, base_file(self.model), *own_effects(self.model.parent, self.desk.folder)]
        own = [path.stat().st_mtime_ns for path in files if path and path.is_file()]
        return written_ns >= max(*own, self._measured_ns)

    @cached_property
    def _measured_ns(self) -> int:
        """When the run was measured to its end, for one that was gone on with has other results; 0 while it goes on."""
        if str(self.run) in measured_now():
            return 0
        return max(path.stat().st_mtime_ns for _, path in segment_paths(self.run))

    def _is_about(self, path: Path) -> bool:
        try:
            written = path.stat().st_mtime_ns
            content = json.loads(path.read_text(encoding="utf-8"))
            runs = {each["id"] for each in content["runs"]}
            changed = any(_says_otherwise(self.desk, each) for each in content["runs"])
            named = Path(content["model"])
        except (OSError, ValueError, KeyError, TypeError):
            return False
        if run_id(self.run) not in runs or changed or not self.is_older_than(written):
            return False
        told = (named, self.desk.folder / named, path.parent / named)
        if self.model in {each.resolve() for each in told}:
            return True
        # a folder that was moved or copied: the name is all that is left of a path
        return named.name == self.model.name and not any(each.exists() for each in told)


def measured_now() -> set[str]:
    """The folders of the runs that processes measure now."""
    return {str(note.facts.get("folder")) for note in notes("run") if not note.is_stale}


def as_now(row: Row, run: Path, going: Collection[str]) -> Row:
    """The row of a run as it stands: a log that is not closed is of none that was killed, while it goes on.

    Of one that was ended it says by whom.
    """
    return row._replace(state="goes on") if str(run) in going else row_said(row)


def _says_otherwise(desk: Desk, run: Mapping[str, Any]) -> bool:
    """Whether a run that a result is about has something else ruled out by now, or nobody can tell."""
    folder = desk.folder / run["run"]
    try:
        return folder.is_dir() and read_notes(folder).ruled_out_in_words != ", ".join(
            run.get("ruled_out", [])
        )
    except LabrigError:
        return True


def pair_of(desk: Desk, asked: Mapping[str, Any]) -> Pair:
    """The run and the model that a request names; raises `LabrigError` where there is no such one."""
    run = run_folder(desk, str(asked.get("run") or ""))
    model = desk.existing(str(asked.get("model") or ""))
    if not model.is_file():
        raise LabrigError("choose a model, or make one")
    return Pair(desk, run, model)


def run_folder(desk: Desk, name: str) -> Path:
    """The run of this name; raises `LabrigError` where there is none."""
    run = desk.existing(name)
    if not run.is_dir() or not segment_paths(run):
        raise LabrigError(f"{name or 'the folder itself'} is not a run: it holds no log")
    return run


def routes(desk: Desk) -> list[Route]:
    """`/api/run`."""
    return [Route("/api/run", answering(lambda request: _run(desk, request)))]


def _run(desk: Desk, request: Request) -> Any:
    name = request.query_params.get("run", "")
    run = run_folder(desk, name)
    near = near_models(desk, run)
    why = {desk.name(path): unreadable(path) for path in [*near, *far_models(desk, run, near)]}
    models = [each for each in why if not why[each]]
    first = next((each for path in near if (each := desk.name(path)) in models), "")
    model = request.query_params.get("model") or first
    pair = pair_of(desk, {"run": name, "model": model}) if model else None
    if pair is not None and pair.model_name not in models:
        models = [pair.model_name, *models]
    compared = pair is not None and (pair.has("compare.json") or pair.has("diagnosis.json"))
    diagnosed = pair is not None and pair.has("diagnosis.json")
    after = True if compared else "compare the run with a model first"
    return {
        "run": name,
        "model": model,
        "models": models,
        "unread": {each: words for each, words in why.items() if words},
        "effects": {each: effects_in(desk.folder / each) for each in models},
        "facts": _facts(row_of(desk, run)),
        "diagnosed": diagnosed,
        "stamp": stamp(pair.key) if pair is not None else "",
        "steps": {
            "compare": True,
            "where": after,
            "which": after,
            "add": True if diagnosed else "find out first which effect is missing",
            "watch": True,
        },
    }


def row_of(desk: Desk, run: Path) -> Row:
    """What the catalogue says of a run; of one that lies deeper than it lists, what it says of that run's folder."""
    name = desk.name(run)
    row = next((row for row in list_runs(desk.folder) if row.run == name), None)
    row = row or next((row._replace(run=name) for row in list_runs(run)), Row(run=name))
    return as_now(row, run, measured_now())


def _facts(row: Row) -> list[str]:
    captures = "" if row.captures is None else counted(row.captures, "capture")
    return [text for text in (row.started and f"{row.started} UTC", row.rig, captures, row.state) if text]
