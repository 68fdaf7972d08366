"""The user's folder for what takes long to compute: solved shapes, by what they were solved for."""

import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Node = tuple[int, ...]


def cache_folder() -> Path:
    """Where it is: $LABRIG_CACHE, or the system's place for such things."""
    if given := os.environ.get("LABRIG_CACHE"):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", str(Path.home()))) / "labrig" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "labrig"
    return Path(os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))) / "labrig"


def content_folder(kind: str, name: str, *content: Any) -> Path:
    """The folder in it for what belongs to JSON-like content; `kind` and `name` are for people."""
    plain = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)[:40]
    return cache_folder() / f"{kind}-{plain}-{_digest(content)}"


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:20]


class NodeCache:
    """Marker positions (M, 3) and slopes (M, 3, C) at lattice nodes, in a folder of small files.

    Several processes may write to it; what cannot be read or written is as if it were not there.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def read(self) -> dict[Node, tuple[Array, Array]]:
        """All that is kept."""
        found: dict[Node, tuple[Array, Array]] = {}
        for path in sorted(self._folder.glob("nodes-*.npz")):
            try:
                with np.load(path, allow_pickle=False) as arrays:
                    node, at, slope = arrays["node"], arrays["at_mm"], arrays["slope"]
            except Exception:  # cut off, or of another format: solved again
                continue
            found.update({tuple(int(i) for i in n): (a, s) for n, a, s in zip(node, at, slope, strict=True)})
        return found

    def write(self, nodes: Mapping[Node, tuple[Array, Array]]) -> None:
        """Keep some more."""
        arrays: dict[str, Any] = {
            "node": np.array(list(nodes)),
            "at_mm": np.stack([at for at, _ in nodes.values()]),
            "slope": np.stack([slope for _, slope in nodes.values()]),
        }
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self._folder, prefix="making-", delete=False) as file:
                np.savez(file, **arrays)
            Path(file.name).replace(self._folder / f"nodes-{_digest(arrays['node'].tolist())}.npz")
        except OSError:
            return
