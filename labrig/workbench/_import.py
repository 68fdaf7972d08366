"""Files dropped on the page: kept, looked at, and made runs of with a mapping that is guessed and can be changed."""

import shutil
from pathlib import Path
from typing import Any, TypedDict

from starlette.requests import Request
from starlette.routing import Route

from labrig._errors import LabrigError
from labrig._text import counted
from labrig.workbench._answers import answering, body_of
from labrig.workbench._columns import Meaning, changed, fault_of, mapping_of, meanings, text_of
from labrig.workbench._desk import Desk
from labrig.workbench._models import is_model
from labrig.workbench._rig_files import is_rig
from labrig.workbench._shape_files import SHAPES, TakenTarget, taken
from labrig.workbench._uploads import dropped, free_name, taking, tidy


class _Model(TypedDict):
    """A dropped model file: its name in the folder, and what it still lacks."""

    model: str
    remarks: list[str]


class _Named(TypedDict):
    """A dropped file: where it is kept, a name for its run, and whether it is a log of labrig's."""

    table: str
    name: str
    log: bool


class _LookedAt(_Named):
    """The same with a mapping, the first rows, and remarks."""

    rows: list[list[str]]
    mapping: str
    columns: list[Meaning]
    remarks: list[str]


_SHOWN = 8


def routes(desk: Desk) -> list[Route]:
    """`/api/drop` takes a file and says what it may be; `/api/columns` puts what was chosen for its columns into its
    mapping, `/api/import` makes a run of it, and `/api/put-away` removes it.
    """
    tidy(desk)
    return [
        Route("/api/drop", taking(desk, _looked_at), methods=["POST"]),
        Route("/api/columns", answering(_chosen), methods=["POST"]),
        Route("/api/import", answering(lambda request: _import(desk, request)), methods=["POST"]),
        Route("/api/put-away", answering(lambda request: _put_away(desk, request)), methods=["POST"]),
    ]


def _looked_at(desk: Desk, path: Path) -> _LookedAt | _Model | TakenTarget:
    """What the page shows of a dropped file: a mapping, the first rows, remarks, a name for the run."""
    if path.suffix.lower() in {".yaml", ".yml"}:
        return _taken(desk, path)
    if path.suffix.lower() in SHAPES - {".xyz"}:  # which may be a table of measurements, too
        return taken(desk, path)
    said: _Named = {"table": desk.name(path), "name": free_name(desk.folder, path.stem), "log": False}
    if path.suffix.lower() == ".mcap" and (captures := _captures(path)) is not None:
        remark = f"a log of labrig's with {counted(captures, 'capture')}"
        return {**said, "log": True, "rows": [], "mapping": "", "columns": [], "remarks": [remark]}
    try:
        mapping, rows, remarks = desk.worker.ask(guessed, str(path))
    except LabrigError as error:
        shutil.rmtree(path.parent, ignore_errors=True)
        raise LabrigError(str(error).replace(str(path), path.name)) from None
    columns = meanings(mapping, rows[0])
    return {**said, "mapping": text_of(mapping), "columns": columns, "rows": rows, "remarks": remarks}


def _taken(desk: Desk, path: Path) -> _Model:
    """A dropped model is put into the folder, under a name that is free; raises `LabrigError` for other YAML."""
    from labrig.model import read_model_file

    try:
        if not is_model(path):
            if is_rig(path):
                raise LabrigError(
                    f"{path.name}: is a rig file, no measurements: put it into the workbench's folder, and open the "
                    f"workbench for it: labrig workbench . --rig {path.name}"
                )
            raise LabrigError(
                f"{path.name}: neither a table nor a model file (a model file has a line 'base:')"
            )
        base = read_model_file(path).base
        name = f"{free_name(desk.folder, path.stem, '.yaml')}.yaml"
        path.rename(desk.folder / name)
    except LabrigError as error:
        raise LabrigError(str(error).replace(str(path), path.name)) from None
    finally:
        shutil.rmtree(path.parent, ignore_errors=True)
    needed = [getattr(base, one) for one in ("file", "rig") if getattr(base, one, None)]
    lacking = [one for one in needed if not (desk.folder / one).exists()]
    return {"model": name, "remarks": [f"it needs {one}: put that into {desk.folder}" for one in lacking]}


def guessed(path: str) -> tuple[dict[str, Any], list[list[str]], list[str]]:
    """A mapping for a table, its header and first rows as texts, and remarks; in the worker."""
    from labrig.log import guess_mapping

    guess = guess_mapping(path)
    preview = guess.preview.head(_SHOWN)
    cells = [list(preview.columns), *preview.itertuples(index=False)]
    return guess.mapping, [[str(cell) for cell in row] for row in cells], guess.remarks


def _captures(path: Path) -> int | None:
    """Of a log of labrig's own, which needs no mapping and is put into `log`; None for another MCAP file."""
    from labrig.log import run_id, summarise

    folder = path.parent / "log"
    folder.mkdir()
    log = path.rename(folder / "log.000.mcap")
    try:
        run_id(folder)
        return summarise(folder).captures
    except LabrigError:
        log.rename(path)
        shutil.rmtree(folder)
        return None


def _import(desk: Desk, request: Request) -> Any:
    asked = body_of(request)
    table = dropped(desk, str(asked.get("table", "")))
    run = desk.path(str(asked.get("name", "")))
    if run == desk.folder or run.parent != desk.folder or run.name.startswith("."):
        raise LabrigError(
            f"{asked.get('name') or 'the name of the run is empty'}: give the run a plain name, without a folder"
        )
    if run.exists():
        raise LabrigError(f"{run.name}: exists already; choose another name")
    folder = table.parent
    if (folder / "log").is_dir():
        (folder / "log").rename(run)
        shutil.rmtree(folder, ignore_errors=True)
        return {"run": run.name, "job": None}
    if not table.is_file():
        raise LabrigError(f"there is no {desk.name(table)}; drop the file again")
    mapping = folder / "map.yaml"
    mapping.write_text(str(asked.get("mapping", "")), encoding="utf-8")
    words = ["import", desk.name(table), "--mapping", desk.name(mapping), "-o", run.name]
    return {"run": run.name, "job": desk.jobs.start(words, f"import {table.name}", run.name).facts()}


def _put_away(desk: Desk, request: Request) -> Any:
    """Remove a dropped file that nobody needs: it is a run by now, or is to be none."""
    table = dropped(desk, str(body_of(request).get("table", "")))
    if any(desk.name(table) in job.words and job.state == "running" for job in desk.jobs.all()):
        raise LabrigError(f"{table.name}: a run is made of it just now; wait for it, or cancel it")
    shutil.rmtree(table.parent, ignore_errors=True)
    return {}


def _chosen(request: Request) -> Any:
    """A mapping as text, what its columns mean, and what is wrong with it: as it was chosen, if anything was."""
    asked = body_of(request)
    mapping = mapping_of(str(asked.get("mapping", "")))
    if asked.get("chosen"):
        mapping = changed(mapping, asked["chosen"])
    columns = meanings(mapping, [str(name) for name in asked.get("header") or []])
    text = text_of(mapping) if asked.get("chosen") else str(asked["mapping"])
    return {"mapping": text, "columns": columns, "fault": fault_of(mapping)}
