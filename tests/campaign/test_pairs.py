"""Two channels that get one target: a plan that sets them apart is refused before anything moves."""

from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

from labrig.campaign import Actuate, Procedure, RigInfo, dry_run
from labrig.cli._run_steps import print_plan
from labrig.rig import RigConfig, parse_rig

LINE = (
    "step 1 (actuate): c1 and c2 are one pair and get one target on the published firmware: set them alike, or declare "
    "`build: full` if the board's is"
)


class Apart(Procedure):
    """Sets both alike, then apart, twice."""

    def steps(self, rig: RigInfo) -> Generator[Any, Any, None]:
        yield Actuate((5.0, 5.0))
        yield Actuate((5.0, 9.0))
        yield Actuate((9.0, 5.0))


def rig(folder: Path, **board: str) -> RigConfig:
    """Two chambers on one pair of a board."""
    content = {
        "name": "pair",
        "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in (1, 2)],
        "pressure": {"kind": "openpneu", "port": "socket://127.0.0.1:1", **board},
    }
    return parse_rig(content, "rig.yaml", folder)


@pytest.mark.parametrize(
    ("board", "broken", "may"),
    [
        ({"dialect": "published"}, [LINE, LINE.replace("step 1", "step 2")], ""),
        ({}, [], LINE),
        ({"dialect": "table"}, [], ""),
        ({"build": "full"}, [], ""),
    ],
)
def test_a_dry_run_knows_pairs(tmp_path: Path, capsys: Any, board: dict, broken: list[str], may: str) -> None:
    """Where the dialect is known that is a broken limit; where the board has to be asked first, it may be one."""
    config = rig(tmp_path, **board)
    plan = dry_run(Apart(), config)
    assert (plan.broken, plan.may_refuse) == (broken, may)
    print_plan(plan, config)
    said = capsys.readouterr().out.splitlines()[-1]
    assert said.startswith("the controller may refuse this, which it tells by its dialect: step 1") is bool(
        may
    )
