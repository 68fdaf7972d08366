"""What was drawn is kept beside the runs, under a digest of all that it is made from; it may be deleted at any time."""

import hashlib
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from labrig import __version__
from labrig._durable import put_at
from labrig.workbench._desk import OWN, Desk
from labrig.workbench._held import Key, stamp

_KEPT = 200
_FORMAT = 3  # of what is kept; another number where `view` gives something else
_making = (
    threading.Lock()
)  # the worker does one thing at a time: who asks for what is being made waits for it


def kept(desk: Desk, work: Callable[..., str], *keys: Key) -> str:
    """What `work` makes of these runs and models in the worker; read again while none of their files has changed."""
    path = desk.folder / OWN / "views" / f"{_name(work.__name__, keys)}.json"
    if not path.is_file():
        with _making:
            if not path.is_file():
                text = desk.worker.ask(work, *keys)
                with suppress(
                    OSError
                ):  # a folder that is only read, or a full disk: it is made again next time
                    _keep(path, text)
                return text
    return path.read_text(encoding="utf-8")


def _keep(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    _tidy(path.parent)
    partial = path.with_suffix(".part")
    partial.write_text(text, encoding="utf-8")
    put_at(partial, path)


def _name(of: str, keys: tuple[Key, ...]) -> str:
    parts: list[Any] = [__version__, _FORMAT, of, *((key, stamp(key)) for key in keys)]
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def _tidy(folder: Path) -> None:
    views = sorted(folder.glob("*.json"), key=lambda path: path.stat().st_mtime)
    for path in views[:-_KEPT]:
        path.unlink(missing_ok=True)
