"""Where a learned model comes from: settings, versions, and the commit it was learned at."""

import platform
from importlib import metadata
from typing import Any

from labrig import __version__
from labrig._git import git_commit


def provenance(kind: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Plain facts to be kept in a model's file."""
    versions = {"labrig": __version__, "python": platform.python_version()}
    for name in ("numpy", "scipy", "torch"):
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {"kind": kind, "settings": settings, "versions": versions, "git_commit": git_commit()}
