"""The torso's forward model, the bodies, and clocks: made once, kept in a folder."""

import argparse
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from labrig import open_run
from labrig.campaign import Procedure, run
from labrig.physics import load_shell, open_simulations, plant_shell, rig_shell, simulate
from labrig.rig import connect, load_rig
from labrig.surface import Mesh, grid, read_mesh
from labrig.surrogate import (
    frames_of,
    load_forward,
    load_model,
    save_forward,
    save_model,
    train_forward,
    train_warp,
    training_set,
)
from labrig_drivers import SimulatedClock
from labrig_procedures import Capture

EXAMPLES = Path(__file__).parents[2] / "examples" / "bodies"
PLANT = {"count": [36, 36], "seed": 1}


@dataclass
class Bench:
    """Where things are kept, and what is made of them when it is first needed."""

    folder: Path
    bodies_file: Path | None
    workers: int
    simulations: int = 800

    @property
    def simulated(self) -> Any:
        """The torso at many pressures, with derivatives."""
        path = self.folder / "torso"
        if not (path / "simulations.npz").is_file():
            simulate(
                load_shell("torso"),
                path,
                self.simulations,
                jacobians=True,
                workers=self.workers,
                resume=path.exists(),
            )
        return open_simulations(path)

    @property
    def model(self) -> Any:
        """The forward model of it."""
        path = self.folder / "torso.pt"
        if not path.is_file():
            save_forward(train_forward(training_set(self.simulated)).model, path)
        return load_forward(path)

    @property
    def warped(self) -> Any:
        """What 40 captures of the rig make of it: 34 markers, no scans."""
        path = self.folder / "sim2real.pt"
        if not path.is_file():
            run = self.captured("capture", Capture(captures=40, repeated=0))
            captures = frames_of(open_run(run), self.model.chamber_names)
            save_model(train_warp(self.model, captures, [], "ours", 0).model, path)
        return load_model(path)

    def captured(self, name: str, procedure: Procedure) -> Path:
        """A run of a procedure on the simulated rig, made once."""
        folder = self.folder / name
        if not (folder / "done").exists():
            shutil.rmtree(folder, ignore_errors=True)
            clock = SimulatedClock(0.0)
            with connect(load_rig(self.rig_file()), clock) as rig:
                run(procedure, rig, folder, clock)
            (folder / "done").touch()
        return folder

    @property
    def unseen(self) -> Any:
        """Which of the simulations, counting those that converged, the model did not learn from."""
        return np.array(self.model.provenance["split"]["test"])

    @property
    def rig(self) -> dict[str, Any]:
        """A simulated rig whose plant is the torso on a finer mesh, with parameters 15 % off."""
        return {
            "name": "torso",
            "chambers": [
                {"name": f"c{c + 1}", "min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 200} for c in range(9)
            ],
            "markers": [f"m{m + 1:02d}" for m in range(34)],
            "pressure": {"kind": "simulated"},
            "mocap": {"kind": "simulated"},
            "scanner": {"kind": "simulated"},
            "simulated": {"shell": "torso", "seed": 1, "plant": PLANT},
        }

    def rig_file(self) -> Path:
        """The rig as a file."""
        path = self.folder / "rig.yaml"
        path.write_text(yaml.safe_dump(self.rig), encoding="utf-8")
        return path

    def plant(self) -> Any:
        """The shell that the rig really is."""
        return plant_shell(self.rig)

    def nominal(self) -> Any:
        """The shell that the model was made from."""
        return rig_shell(self.rig)

    def bodies(self, count: int | None = None) -> list[Mesh]:
        """The bodies of the file that was named (grid_mm, (B, rows, columns, 3)), or the examples; evenly chosen."""
        if self.bodies_file is None:
            meshes = [read_mesh(path) for path in sorted(EXAMPLES.glob("*.ply"))]
        else:
            places = np.load(self.bodies_file)["grid_mm"].astype(float)
            _, triangles = grid(places.shape[2], places.shape[1])
            meshes = [Mesh(one.reshape(-1, 3), triangles) for one in places]
        if count is None or count >= len(meshes):
            return meshes
        return [meshes[k] for k in np.linspace(0, len(meshes) - 1, count).round().astype(int)]


def clock(call: Callable[[], Any], times: int = 15) -> float:
    """Median processor time of a call, s, after one that does not count."""
    call()
    taken = []
    for _ in range(times):
        begin = time.process_time()
        call()
        taken.append(time.process_time() - begin)
    return float(np.median(taken))


def asked_for(title: str, paper: str) -> argparse.ArgumentParser:
    """The arguments that the benchmarks of shapes share."""
    parser = argparse.ArgumentParser(description=title)
    parser.add_argument("--bodies", type=Path)
    parser.add_argument("--paper", type=int, default=24, help=paper)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=Path("benchmarks/out/ik"))
    parser.add_argument("--out", type=Path, default=Path("benchmarks/RESULTS.md"))
    return parser
