"""Times run on through a resume, and the wall's time is kept beside them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from labrig import LabrigError, open_run
from labrig.campaign import Actuate, Interrupted, Procedure, Record, RigInfo, Settle, Steps, resume, run
from labrig.log import LogWriter


class Four(Procedure):
    """Four captures."""

    def steps(self, rig: RigInfo) -> Steps:
        """Up and down."""
        for pressure_kpa in (10.0, 20.0, 10.0, 30.0):
            yield Actuate((pressure_kpa, pressure_kpa))
            yield Settle(3.0)
            yield Record(1.0)


def _stopped_after(steps: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C once so many steps are durable."""
    left = steps + 1  # a log makes its own beginning durable first
    original = LogWriter.step_done

    def count(writer: LogWriter) -> None:
        nonlocal left
        original(writer)
        left -= 1
        if left == 0:
            raise KeyboardInterrupt

    monkeypatch.setattr(LogWriter, "step_done", count)


def test_a_resumed_run_goes_on_where_its_times_ended(
    make_rig: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even when the computer's clock says that the second session came before the first."""
    first, second = make_rig(), make_rig()
    with monkeypatch.context() as patch:
        _stopped_after(6, patch)
        with pytest.raises(Interrupted):
            run(Four(), first.rig, tmp_path / "run", first.clock)
    ended_s = first.clock.now_s()
    assert second.clock.now_s() < ended_s
    resume(Four(), second.rig, tmp_path / "run", second.clock)
    data = open_run(tmp_path / "run")
    session = data["session"].to_numpy()
    time_s = data["time_s"].to_numpy()
    assert set(session.tolist()) == {"0", "1"}
    assert np.nanmin(time_s[session == "1"]) > np.nanmax(time_s[session == "0"])
    events = data["event_time_s"].to_numpy()
    assert np.all(np.diff(events) >= 0)


def test_a_clock_that_is_set_back_during_a_run_changes_no_time(
    make_rig: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`time_s` rises through it; `wall_time` shows the hour."""
    fake = make_rig()
    wall = {"s": 1.7e9}
    monkeypatch.setattr(fake.clock, "wall_s", lambda: wall["s"])

    def set_back() -> None:
        if fake.clock.now_s() - start_s > 8.0:
            wall["s"] = 1.7e9 - 3600.0

    start_s = fake.clock.now_s()
    fake.clock.on_sleep = set_back
    run(Four(), fake.rig, tmp_path / "run", fake.clock)
    data = open_run(tmp_path / "run")
    rising = data["time_s"].to_numpy()
    assert np.all(np.diff(rising[np.isfinite(rising)]) > 0)
    hours = np.diff(data["wall_time"].to_numpy()).astype("timedelta64[h]").astype(int)
    assert hours.tolist().count(-1) == 1


def test_a_run_goes_to_netcdf_and_back(fake: Any, tmp_path: Path) -> None:
    """As docs/reference/dataset.md writes it, with what every installation has; no time is lost."""
    run(Four(), fake.rig, tmp_path / "run", fake.clock)
    data = open_run(tmp_path / "run")
    data.drop_attrs().to_netcdf(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as back:
        assert set(back.variables) == set(data.variables)
        apart = np.abs(back["wall_time"].to_numpy() - data["wall_time"].to_numpy())
        assert apart.max() < np.timedelta64(1, "us")


def test_a_folder_that_is_deleted_is_noticed_and_its_log_saved(fake: Any, tmp_path: Path) -> None:
    """Within a second or two of the run the chambers are vented, and the captures are in a new folder."""
    import shutil

    folder = tmp_path / "run"
    start_s = fake.clock.now_s()

    def delete() -> None:
        if fake.clock.now_s() - start_s > 12.0 and folder.exists():
            shutil.rmtree(folder)

    fake.clock.on_sleep = delete
    with pytest.raises(LabrigError) as caught:
        run(Four(), fake.rig, folder, fake.clock)
    saved = tmp_path / "run-rescued"
    assert str(caught.value) == (
        f"{folder / 'log.000.mcap'} was deleted or moved while the run went on; what it held is saved in {saved}, "
        "2 captures; the chambers are vented"
    )
    assert fake.clock.now_s() - start_s < 18.0
    assert open_run(saved).sizes["capture"] == 2
    assert np.abs(fake.pressure_kpa).max() <= 0.5


def test_a_folder_that_is_gone_with_everything_around_it_is_saved_elsewhere(
    fake: Any, tmp_path: Path
) -> None:
    """Where nothing can be written beside it, the log goes to the computer's folder for temporary files."""
    import shutil

    folder = tmp_path / "all" / "run"
    start_s = fake.clock.now_s()

    def delete() -> None:
        if fake.clock.now_s() - start_s > 12.0 and folder.exists():
            shutil.rmtree(tmp_path / "all")

    fake.clock.on_sleep = delete
    with pytest.raises(LabrigError, match=r"what it held is saved in .*labrig-\w+.run, 2 captures") as caught:
        run(Four(), fake.rig, folder, fake.clock)
    saved = Path(str(caught.value).split("saved in ")[1].split(", ")[0])
    assert open_run(saved).sizes["capture"] == 2
    shutil.rmtree(saved.parent)
