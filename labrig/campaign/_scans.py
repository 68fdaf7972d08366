"""Files that belong to a run beside its log: its scans, and what a simulated rig keeps sealed."""

import os
import re
import shutil
from pathlib import Path

import numpy as np

from labrig._durable import put_at, sync_folder
from labrig.rig import RigConfig
from labrig_drivers import Scan

_SEALED = "sealed.json"


def keep_scan(scan: Scan, folder: Path) -> tuple[str, ...]:
    """Copy a scan's files into a folder of its own in `scans/` of the run, or write its mesh there if it has none.

    Returns the files' names relative to the run's folder, with forward slashes. The folder has a number, and the files
    keep their names, by which a mesh finds its colours.
    """
    scans = folder / "scans"
    if not scans.exists():
        scans.mkdir()
        sync_folder(folder)
    used = [int(found[0]) for path in scans.iterdir() if (found := re.match(r"\d+", path.name))]
    own = scans / f"{1 + max(used, default=-1):03d}"
    own.mkdir()
    sync_folder(scans)
    if not scan.files:
        path = own / "scan.ply"
        _write_ply(path, scan)
        return (path.relative_to(folder).as_posix(),)
    kept = []
    for file in scan.files:
        path = own / file.name
        partial = path.with_name(path.name + ".partial")
        shutil.copyfile(file, partial)
        _publish(partial, path)
        kept.append(path.relative_to(folder).as_posix())
    return tuple(kept)


def _write_ply(path: Path, scan: Scan) -> None:
    """A binary PLY, mm, 32 bit floats."""
    vertices = np.asarray(scan.vertices_mm, "<f4")
    faces = np.zeros(len(scan.triangles), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
    faces["count"], faces["corners"] = 3, scan.triangles
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment unit mm\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    partial = path.with_name(path.name + ".partial")
    partial.write_bytes(header.encode("ascii") + vertices.tobytes() + faces.tobytes())
    _publish(partial, path)


def _publish(partial: Path, path: Path) -> None:
    with partial.open("rb+") as file:
        os.fsync(file.fileno())
    put_at(partial, path)
    sync_folder(path.parent)


def keep_sealed(config: RigConfig, folder: Path) -> None:
    """Copy the file that says what a simulated rig hides into the run, still sealed."""
    hidden = (config.simulated or {}).get("hidden")
    source = config.folder / hidden if isinstance(hidden, str) else None
    target = folder / _SEALED
    if source is not None and source.is_file() and not target.exists():
        shutil.copyfile(source, target)
