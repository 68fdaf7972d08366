"""Targets of the quick mannequin, a model of it, and a rig that is simulated with a scanner: for the page Shape."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from labrig.campaign._scans import _write_ply
from labrig.ik._models import SurfaceModel
from labrig.physics import load_surface
from labrig.surface import grid
from labrig_drivers import Scan

CHAMBERS = [f"c{c + 1}" for c in range(9)]
NEAR = np.linspace(10.0, 50.0, 9)
"""Pressures, kPa, of a target that the mannequin can be."""
FAR = np.linspace(20.0, 90.0, 9)
"""The same of one that is beyond its limits of 60 kPa."""
MODEL = "base: {kind: simulator, rig: rig.yaml}\n"


def simulated(name: str = "mannequin", high_kpa: float = 60.0, **more: Any) -> dict[str, Any]:
    """The content of a rig file."""
    return {
        "name": name,
        "chambers": [{"name": c, "min_kpa": 0, "max_kpa": high_kpa, "slew_kpa_s": 400} for c in CHAMBERS],
        "markers": [f"m{m + 1:02d}" for m in range(34)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "scanner": {"kind": "simulated"},
        "simulated": {"surface": "mannequin", "noise_mm": 0.05, "occlusion": 0.0, "repeatability_mm": 0.0},
        **more,
    }


def write_target(path: Path, pressure_kpa: np.ndarray) -> Path:
    """A PLY in mm of the mannequin at these pressures, (9,)."""
    model = SurfaceModel(load_surface({"simulated": {"surface": "mannequin"}}))
    uv, triangles = grid(31, 41)
    scan = Scan(0.0, model.points(pressure_kpa[None], uv)[0], triangles, (), "")
    path.parent.mkdir(parents=True, exist_ok=True)
    _write_ply(path, scan)
    return path


def write_lab(folder: Path) -> Path:
    """The rig, its model, and two targets: near.ply, which it can be, and bodies/far.ply, which it cannot."""
    folder.mkdir(exist_ok=True)
    (folder / "rig.yaml").write_text(yaml.safe_dump(simulated()), encoding="utf-8")
    (folder / "model.yaml").write_text(MODEL, encoding="utf-8")
    write_target(folder / "near.ply", NEAR)
    write_target(folder / "bodies" / "far.ply", FAR)
    return folder
