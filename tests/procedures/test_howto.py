"""The procedures in docs/how-to/procedure.md run as they are printed there."""

import re
from pathlib import Path

import pytest

from labrig import open_run
from labrig.campaign import dry_run, run
from labrig.rig import connect, parse_rig
from labrig_drivers import SimulatedClock

TEXT = (Path(__file__).parents[2] / "docs" / "how-to" / "procedure.md").read_text(encoding="utf-8")
RIG = {
    "name": "small",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 10)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated", "rate_hz": 20},
    "simulated": {"surface": "mannequin", "seed": 0},
}


@pytest.mark.parametrize("name", ["Squeeze", "Reach"])
def test_the_examples_run(tmp_path: Path, name: str) -> None:
    """Each stands in a file of its own, and makes captures on the simulated rig."""
    (block,) = (b for b in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL) if f"class {name}(" in b)
    space: dict[str, object] = {"__name__": "howto"}
    exec(block, space)
    procedure = space[name]()  # type: ignore[operator]
    config = parse_rig(RIG, "rig.yaml", tmp_path)
    assert dry_run(procedure, config).broken == []
    clock = SimulatedClock()
    with connect(config, clock) as rig:
        run(procedure, rig, tmp_path / "run", clock)
    assert open_run(tmp_path / "run").sizes["capture"] >= 2
