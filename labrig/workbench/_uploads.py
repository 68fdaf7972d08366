"""Files that a page sends: each kept in a folder of its own, whole or not at all, until somebody has looked at it."""

import asyncio
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from labrig._durable import put_at
from labrig._errors import LabrigError
from labrig.workbench._answers import failed, says
from labrig.workbench._desk import OWN, Desk

MOST_BYTES = 4 * 1024**3
_KEPT_S = 7 * 24 * 3600.0
"""What was dropped and looked at no more is kept for so long."""


def taking(desk: Desk, look: Callable[[Desk, Path], Any]) -> Any:
    """An endpoint that keeps what is sent and answers what `look` says of the file."""

    async def endpoint(request: Request) -> Response:
        try:
            path = await _kept(desk, request)
            return says(await asyncio.to_thread(look, desk, path))
        except ClientDisconnect:  # the page was closed meanwhile
            return Response(status_code=400)
        except Exception as error:
            return failed(error)

    return endpoint


def dropped_folder(desk: Desk) -> Path:
    """Where what is sent is kept, each in a folder of its own."""
    return desk.folder / OWN / "dropped"


def dropped(desk: Desk, name: str) -> Path:
    """A file that was dropped, there or not, by its name below the folder; raises `LabrigError` for another."""
    path = desk.path(name)
    if path.parent.parent != dropped_folder(desk):
        raise LabrigError(f"{desk.name(path)} was not dropped here")
    return path


def tidy(desk: Desk) -> None:
    """Remove what was dropped long ago and became no run: such files may be large, and no page shows them."""
    try:
        old = [p for p in dropped_folder(desk).iterdir() if time.time() - p.stat().st_mtime > _KEPT_S]
    except OSError:
        return
    for folder in old:
        shutil.rmtree(folder, ignore_errors=True)


def free_name(folder: Path, stem: str, end: str = "") -> str:
    """A plain name for a run, or for a file with this end, that there is not yet in a folder."""
    name = re.sub(r"[^\w.+-]+", "-", stem).strip("-.") or "run"
    names = (name, *(f"{name}-{k}" for k in range(2, 10_000)))
    return next(n for n in names if not (folder / f"{n}{end}").exists())


async def _kept(desk: Desk, request: Request) -> Path:
    """Write what is sent to a folder of its own, whole or not at all."""
    name = re.sub(r"[^\w.()+ -]", "_", Path(request.query_params.get("name", "")).name).strip(". ")
    if not name:
        raise LabrigError("a file without a name: give it one and drop it again")
    tidy(desk)
    folder = dropped_folder(desk) / f"{time.strftime('%Y%m%d-%H%M%S')}-{time.time_ns() % 10**6:06d}"
    folder.mkdir(parents=True)
    path, size = folder / name, 0
    try:
        with (folder / f"{name}.part").open("xb") as file:
            async for chunk in request.stream():
                size += len(chunk)
                if size > MOST_BYTES:
                    raise LabrigError(f"{name}: larger than 4 GB; use labrig import in a terminal")
                await asyncio.to_thread(file.write, chunk)
        put_at(folder / f"{name}.part", path)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return path
