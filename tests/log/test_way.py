"""On a rig that goes to its set-points slowly, the way there is no part of the hold."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import labrig
from tests.rigs import RIG


def run_slowly(folder: Path, slew_kpa_s: float) -> Any:
    """What a rig of this slew limit records, with nothing hidden."""
    chambers = [{**chamber, "slew_kpa_s": slew_kpa_s} for chamber in RIG["chambers"]]
    rig = {**RIG, "chambers": chambers, "simulated": {"surface": "membrane", "seed": 0}}
    (folder / "rig.yaml").write_text(yaml.safe_dump(rig), encoding="utf-8")
    (folder / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n", encoding="utf-8")
    return labrig.open_run(labrig.run("capture", folder / "rig.yaml", out=folder / "run", captures=14))


@pytest.mark.parametrize("slew_kpa_s", [5.0, 20.0, 40.0])
def test_every_row_of_a_hold_is_at_its_set_point(tmp_path: Path, slew_kpa_s: float) -> None:
    """After the first second, that everything leaves out, the rig is where the capture says; nothing that follows
    from its rows can be the way there.
    """
    run = run_slowly(tmp_path, slew_kpa_s)
    off = np.abs(run["measured"] - run["commanded"]).max("chamber").where(run["hold_s"] > 1.0)
    assert float(off.max()) < 1.0
    assert bool(run["settled"].any("time").all())
    assert labrig.compare(run, tmp_path / "model.yaml").error["model"] < 0.2


def test_a_usual_way_is_left_as_it_was(tmp_path: Path) -> None:
    """Where it takes less than the first second, rows begin with the actuation."""
    run = run_slowly(tmp_path, 100.0)
    assert float(run["hold_s"][:, 0].max()) <= 0.25
