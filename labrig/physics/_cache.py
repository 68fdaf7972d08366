"""The user's folder for what takes long to compute: solved shapes, by what they were solved for."""

import hashlib
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from labrig._user_folder import cache_folder
from labrig.arrays import Floats


def content_folder(kind: str, name: str, *content: Any) -> Path:
    """The folder in it for what belongs to JSON-like content; `kind` and `name` are for people."""
    plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)[:40]
    return cache_folder() / f"{kind}-{plain}-{digest(content)}"


def digest(content: Any) -> str:
    """A short name for JSON-like content."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:20]


class ArrayCache:
    """Arrays by a key that is JSON-like, each in a small file of its own, in a folder.

    Several processes may write to it; what cannot be read or written is as if it were not there.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def read(self, key: Any) -> tuple[Floats, ...] | None:
        """The arrays of a key, None if there are none."""
        try:
            with np.load(self._path(key), allow_pickle=False) as arrays:
                return tuple(arrays[name] for name in sorted(arrays.files))
        except Exception:  # not there, cut off, or of another format: worked out again
            return None

    def write(self, key: Any, *arrays: Floats) -> None:
        """Keep the arrays of a key."""
        made: Path | None = None
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self._folder, prefix="making-", delete=False) as file:
                made = Path(file.name)
                np.savez(file, **{f"a{k}": array for k, array in enumerate(arrays)})  # type: ignore[arg-type]
            made.replace(self._path(key))
        except OSError:  # the disk is full, or somebody else's
            if made is not None:
                made.unlink(missing_ok=True)

    def _path(self, key: Any) -> Path:
        return self._folder / f"{digest(key)}.npz"
