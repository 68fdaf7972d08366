"""The rig that stands for the paper's: captures and scans of a shell that the model does not know, through the log.

The plant is the shipped mannequin on a finer mesh, every parameter of it changed by chance; another seed is another
plant. A campaign is 40 random set-points with 34 markers, as in the paper, the first ten of them also scanned; a second
one, of other set-points, is scanned throughout and learned from by nobody.
"""

import shutil
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from pydantic import Field

from labrig.campaign import Actuate, Procedure, Record, RigInfo, Scan, Settle, Steps, run
from labrig.log import open_run
from labrig.physics import Simulations, open_simulations, simulate
from labrig.physics._shell_rig import rig_shell
from labrig.rig import connect, parse_rig
from labrig.surrogate import (
    ForwardModel,
    Frames,
    Shot,
    Trained,
    frames_of,
    load_forward,
    save_model,
    shots_of,
    train_forward,
    training_set,
)
from labrig_drivers import SimulatedClock

CHAMBERS = tuple(f"c{i + 1}" for i in range(9))
OCCLUSION = 0.018
"""Chance that a marker is hidden in a hold: leaves about 55 % of the frames complete, as in the paper."""
SIMULATIONS = 1000
SPREAD = 0.15
PLANT_COUNT = 34
FRAMES, SCANNED, HELD_OUT = 40, 10, 12


class Random(Procedure):
    """Random set-points over the whole range: wait, record the markers, scan the first of them."""

    captures: int = Field(FRAMES, ge=1, description="set-points")
    scanned: int = Field(0, ge=0, description="how many of them are scanned")
    settle_s: float = Field(3.0, ge=0.0, description="wait after each actuation, s")

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, settle, record, scan."""
        for number, share in enumerate(rig.rng().random((self.captures, len(rig.channels)))):
            yield Actuate(tuple(np.round(share * rig.max_kpa, 3).tolist()))
            yield Settle(self.settle_s)
            yield Record(0.3)
            if number < self.scanned:
                yield Scan()


def rig_content(seed: int) -> dict:
    """The rig.yaml of one plant."""
    return {
        "name": "paper",
        "chambers": [{"name": name, "min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 100} for name in CHAMBERS],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "scanner": {"kind": "simulated"},
        "simulated": {
            "shell": "mannequin",
            "plant": {"count": [PLANT_COUNT, PLANT_COUNT], "spread": SPREAD, "seed": seed},
            "seed": seed,
            "noise_mm": 0.1,
            "occlusion": OCCLUSION,
        },
    }


def campaign(folder: Path, seed: int, captures: int, scanned: int, order: int) -> Path:
    """Run a campaign on the plant `seed`, unless it was run before; `order` is the seed of its set-points."""
    if (folder / "done").is_file():
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    clock = SimulatedClock(1_700_000_000.0)
    rig = connect(parse_rig(rig_content(seed), "paper", Path()), clock)
    try:
        run(Random(captures=captures, scanned=scanned), rig, folder, clock, seed=order)
    finally:
        rig.close()
    (folder / "done").touch()
    return folder


@dataclass(frozen=True)
class Bench:
    """Simulations, forward models and campaigns, made once and kept in `folder`.

    `networks`: compare labrig's ensembles of networks as well, which takes minutes.
    """

    folder: Path
    workers: int = 2
    simulations_folder: Path | None = None
    networks: bool = False

    @cached_property
    def simulations(self) -> Simulations:
        """The 1,000 simulations of the nominal shell, with slopes."""
        given = self.simulations_folder
        if given is not None:
            return open_simulations(given)
        shell = rig_shell(rig_content(0))
        return simulate(
            shell, self.folder / "sims", SIMULATIONS, jacobians=True, workers=self.workers, resume=True
        )

    def trained(self, method: str, slopes: bool, seed: int = 0) -> Trained:
        """A forward model, trained now."""
        data = training_set(self.simulations, "sims")
        return train_forward(data if slopes else data.without_slopes(), method, seed=seed)  # type: ignore[arg-type]

    def forward(self, method: str = "gaussian") -> ForwardModel:
        """The forward model of a method, kept in a file."""
        path = self.folder / f"{method}.pt"
        if not path.is_file():
            save_model(self.trained(method, slopes=method != "paper").model, path)
        return load_forward(path)

    def captures(self, seed: int) -> tuple[Frames, list[Shot]]:
        """Forty frames of the plant `seed`, and ten scans at the first of them."""
        folder = campaign(self.folder / f"run-{seed}", seed, FRAMES, SCANNED, 100 + seed)
        return frames_of(open_run(folder), CHAMBERS), shots_of(folder, CHAMBERS)

    def held_out(self, seed: int) -> list[Shot]:
        """Scans of the plant `seed` at other set-points."""
        folder = campaign(self.folder / f"test-{seed}", seed, HELD_OUT, HELD_OUT, 900 + seed)
        return shots_of(folder, CHAMBERS)
