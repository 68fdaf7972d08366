"""The user's own folder for what labrig keeps between commands and no run holds."""

import os
import sys
from pathlib import Path


def cache_folder() -> Path:
    """Where it is: $LABRIG_CACHE, or the system's place for such things."""
    if given := os.environ.get("LABRIG_CACHE"):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", str(Path.home()))) / "labrig" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "labrig"
    return Path(os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))) / "labrig"
