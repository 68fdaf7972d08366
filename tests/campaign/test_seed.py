"""What may be the seed of a run, and what else is refused before anything is made."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps, dry_run, run
from labrig.log import read_run_yaml


class Random(Procedure):
    """One capture at a random pressure."""

    def steps(self, rig: RigInfo) -> Steps:
        """Where the seed says."""
        yield Actuate(rig.rng().uniform(0.0, 60.0, 2))
        yield Settle(3.0)
        yield Record(0.5)


def test_a_whole_number_of_numpy_is_a_seed(fake: Any, tmp_path: Path) -> None:
    """A loop over `np.arange` works: the run is that of the plain number, and run.yaml holds it."""
    run(Random(), fake.rig, tmp_path / "run", fake.clock, np.int64(2))  # type: ignore[arg-type]
    assert read_run_yaml(tmp_path / "run")["seed"] == 2
    plans = [dry_run(Random(), fake.rig.config, seed).steps for seed in (2, np.uint8(2))]  # type: ignore[arg-type]
    assert plans[0] == plans[1]


@pytest.mark.parametrize("seed", [None, -1, "x", 2.0, True, np.bool_(True), np.float64(2.0)])
def test_what_is_no_seed_is_said_so_before_a_folder_is_made(fake: Any, tmp_path: Path, seed: Any) -> None:
    """One line that blames no procedure; nothing moves, and nothing is left behind."""
    with pytest.raises(LabrigError) as caught:
        run(Random(), fake.rig, tmp_path / "run", fake.clock, seed)
    assert str(caught.value) == f"seed {seed!r}: a whole number, 0 or more"
    assert not (tmp_path / "run").exists()
    assert fake.pressure.world.commands == []
    with pytest.raises(LabrigError, match="a whole number, 0 or more"):
        dry_run(Random(), fake.rig.config, seed)
