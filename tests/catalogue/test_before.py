"""What a rig did shortly before a run is found beside it."""

from pathlib import Path
from typing import Any

import pytest
import xarray as xr
import yaml

from labrig.api._diagnose import _of_before
from labrig.catalogue import used_before
from tests.catalogue.conftest import START_S, write_run


def opened(folder: Path, start_s: float) -> xr.Dataset:
    """What a diagnosis is given of a run: where it lies, and when it began."""
    return xr.Dataset(attrs={"run": str(folder), "start_s": start_s})


def run(folder: Path, began_s: float, rig: str = "mannequin", kind: str = "openpneu") -> xr.Dataset:
    """A run of two captures that began so long after the first."""
    write_run(folder, rig=rig)
    facts = {"rig": {"name": rig, "pressure": {"kind": kind}}, "start_s": START_S + began_s}
    (folder / "run.yaml").write_text(yaml.safe_dump(facts), encoding="utf-8")
    return opened(folder, START_S + began_s)


def test_the_run_before_is_found(tmp_path: Path) -> None:
    """The last one of the rig that ended within half an hour; neither another rig's, nor a later one, nor itself."""
    run(tmp_path / "early", 0.0)
    run(tmp_path / "first", 1000.0)
    run(tmp_path / "other", 1900.0, rig="gripper")
    fresh = run(tmp_path / "fresh", 2000.0)
    run(tmp_path / "later", 2100.0)
    before = used_before([fresh])
    assert before is not None
    assert before.folder.name == "first"
    assert before.gap_s == pytest.approx(1000.0, abs=30)


def test_nothing_before_is_nothing(tmp_path: Path) -> None:
    """The first run of a rig, one after a long rest, one that is given with the run before, and a table."""
    first, fresh = run(tmp_path / "first", 0.0), run(tmp_path / "fresh", 600.0)
    rested = run(tmp_path / "rested", 9000.0)
    assert used_before([first]) is None
    assert used_before([rested]) is None
    assert used_before([first, fresh]) is None
    assert used_before([fresh, xr.Dataset()]) is None
    assert used_before([opened(tmp_path / "nowhere", 1.0)]) is None


def test_a_simulated_rig_begins_anew(tmp_path: Path) -> None:
    """What is simulated in the run's own process remembers nothing of the run before."""
    run(tmp_path / "first", 0.0, kind="simulated")
    assert used_before([run(tmp_path / "fresh", 600.0, kind="simulated")]) is None


def test_it_is_said_where_something_is_missing(tmp_path: Path) -> None:
    """The name of the run before, and what to do; nothing is said where nothing is missing."""
    run(tmp_path / "first", 0.0)
    fresh = run(tmp_path / "fresh", 600.0)
    summary: Any = {"verdict": "identified"}
    assert _of_before([fresh], summary) == [
        "the rig was in use until 10 min before (first), which it may remember: what creeps or has a loop looks like "
        "something else then, so diagnose first with it"
    ]
    assert _of_before([fresh], summary | {"verdict": "nothing_missing"}) == []
