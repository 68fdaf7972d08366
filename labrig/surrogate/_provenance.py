"""Where a learned model comes from: settings, versions, and the commit it was learned at."""

import platform
import subprocess
from importlib import metadata
from typing import Any

from labrig import __version__


def provenance(kind: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Plain facts to be kept in a model's file."""
    versions = {"labrig": __version__, "python": platform.python_version()}
    for name in ("numpy", "scipy", "torch"):
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {"kind": kind, "settings": settings, "versions": versions, "git_commit": _git_commit()}


def _git_commit() -> str | None:
    """The commit of the folder that labrig was started in, if it is a git repository."""
    try:
        answer = subprocess.run(
            ["git", "rev-parse", "HEAD"], capture_output=True, text=True, timeout=5, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return answer.stdout.strip() or None
