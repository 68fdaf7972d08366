"""Runs are listed, summed up, and made whole again."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError, import_table, open_run
from labrig.log import find_runs, recover, summarise


def test_a_run_is_summed_up(small_log) -> None:
    """Captures, sessions, length, and how it ended."""
    summary = summarise(small_log.folder)
    assert (summary.captures, summary.steps_done, summary.sessions) == (6, 6, 1)
    assert summary.state == "completed"
    assert summary.duration_s == pytest.approx(12.0, abs=0.1)
    assert summary.step_kinds == {"record": 6}
    assert summary.messages == {"command": 7, "measured": 120, "markers": 120, "step": 6, "plan": 1}
    assert summary.warnings == []
    assert summary.size_bytes == (small_log.folder / "log.000.mcap").stat().st_size


def test_a_killed_run_says_so(small_log, tmp_path: Path) -> None:
    """A log without its end was killed, or is still being written."""
    whole = (small_log.folder / "log.000.mcap").read_bytes()
    (tmp_path / "log.000.mcap").write_bytes(whole[: small_log.durable_bytes[2]])
    summary = summarise(tmp_path)
    assert summary.state == "not closed (killed, or still going on)"
    assert summary.captures == 3


def test_runs_are_found_two_levels_deep(two_sessions: Path, tmp_path: Path) -> None:
    """A folder of runs, a folder of folders of runs, and a run itself."""
    assert find_runs(tmp_path) == [two_sessions]
    shelf = tmp_path / "shelf" / "monday"
    shelf.mkdir(parents=True)
    two_sessions = two_sessions.rename(shelf / "run")
    assert find_runs(tmp_path / "shelf") == [two_sessions]
    assert find_runs(two_sessions) == [two_sessions]
    with pytest.raises(LabrigError) as caught:
        find_runs(tmp_path / "none")
    assert str(caught.value) == f"{tmp_path / 'none'} is not a folder; name the one that holds your runs"


def test_recovering_a_whole_run_loses_nothing(two_sessions: Path, tmp_path: Path) -> None:
    """The copy is equal, and the original is untouched."""
    before = {path.name: path.read_bytes() for path in two_sessions.iterdir()}
    (two_sessions / "scans" / "000").mkdir(parents=True)
    (two_sessions / "scans" / "000" / "scan.ply").write_bytes(b"ply")
    assert recover(two_sessions, tmp_path / "whole") == []
    assert open_run(tmp_path / "whole").equals(open_run(two_sessions))
    assert (tmp_path / "whole" / "scans" / "000" / "scan.ply").read_bytes() == b"ply"
    assert {name: (two_sessions / name).read_bytes() for name in before} == before


def test_a_damaged_run_becomes_whole(small_log, tmp_path: Path) -> None:
    """What is lost is said once; the copy has no warnings and opens in any reader of MCAP."""
    from mcap.reader import make_reader

    damaged = bytearray((small_log.folder / "log.000.mcap").read_bytes()[: small_log.durable_bytes[4] + 300])
    damaged[small_log.durable_bytes[1] + 400] ^= 0xFF
    source = tmp_path / "run"
    source.mkdir()
    (source / "log.000.mcap").write_bytes(damaged)
    lost = recover(source, tmp_path / "whole")
    assert any("fails its checksum" in line for line in lost)
    assert any("not closed" in line for line in lost)
    run = open_run(tmp_path / "whole")
    assert run.attrs["warnings"] == []
    assert run["commanded"][:, 0].to_numpy().tolist() == [0.0, 10.0, 30.0, 40.0]
    np.testing.assert_array_equal(run["position_mm"][3], open_run(small_log.folder)["position_mm"][4])
    with (tmp_path / "whole" / "log.000.mcap").open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == sum(summarise(tmp_path / "whole").messages.values())


def test_a_copy_never_replaces_anything(small_log, tmp_path: Path) -> None:
    """The target must be new."""
    with pytest.raises(LabrigError) as caught:
        recover(small_log.folder, tmp_path)
    assert str(caught.value) == f"{tmp_path} exists already; choose another name or remove it"


@pytest.mark.parametrize("long", [False, True])
def test_an_imported_run_has_the_sessions_of_its_captures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, long: bool
) -> None:
    """Two days in one table are two sessions in its summary, as the import says, however the table was written."""
    monkeypatch.setattr("labrig.log._table._ROW_BY_ROW", 0 if long else 100)
    frame = pd.DataFrame({"day": [1, 1, 2, 2], "p_kPa": [0.0, 10.0, 0.0, 10.0], "F_N": [0.1, 5.0, 0.2, 5.1]})
    import_table(frame, tmp_path / "run")
    summary = summarise(tmp_path / "run")
    assert (summary.captures, summary.sessions) == (4, 2)
