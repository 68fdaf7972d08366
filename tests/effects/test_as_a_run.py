"""What xarray made of a run is taken as a run, or refused in one line that says what is missing and what to do."""

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
import yaml

import labrig
from labrig import LabrigError
from labrig.effects import Rows, as_a_run, rows_of
from labrig.log import open_run
from labrig_drivers.simulated import hide, seal
from tests.rigs import RIG


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """A run of six captures."""
    folder = tmp_path_factory.mktemp("lab")
    (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    seal(folder, hide("creep", seed=1))
    labrig.run("capture", folder / "rig.yaml", out=folder / "first", captures=6)
    return open_run(folder / "first")


def same(one: Rows, other: Rows) -> bool:
    """Whether all arrays of rows are the same."""
    names = ("actuation", "measured", "values", "event_actuation", "event_time_s", "rest_mm", "hold_s")
    return all(np.array_equal(getattr(one, n), getattr(other, n), equal_nan=True) for n in names)


def test_captures_that_where_chose_are_a_run(run: xr.Dataset) -> None:
    """`where(..., drop=True)` copies what has no captures over all of them: the rows are those of `isel`."""
    chosen = run.commanded.max("chamber") > 40
    assert 0 < int(chosen.sum()) < run.sizes["capture"]
    by_where = run.where(chosen, drop=True)
    assert "capture" in by_where["rest_mm"].dims
    assert same(rows_of(by_where), rows_of(run.isel(capture=np.flatnonzero(chosen))))
    assert same(rows_of(run.transpose("axis", ...)), rows_of(run))
    assert as_a_run(run) is run


def test_parts_of_a_run_that_are_put_together_are_it_again(run: xr.Dataset) -> None:
    """`xarray.concat` of a run's parts is the run; of the run with itself, or with another, it is refused."""
    parts = [run.isel(capture=slice(0, 3)), run.isel(capture=slice(3, None))]
    assert same(rows_of(xr.concat(parts, "capture", data_vars="all")), rows_of(run))
    with pytest.raises(LabrigError, match="capture 0 is in it twice: what was measured counts once"):
        rows_of(xr.concat([run, run], "capture", data_vars="all"))
    other = run.assign(event_time_s=run.event_time_s + 1)
    with pytest.raises(
        LabrigError, match=r"`event_time_s` is not the same along `capture`; give several runs as"
    ):
        rows_of(xr.concat([run, other], "capture", data_vars="all"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda r: r.isel(capture=0), r"`commanded` has no `capture`: sel\(capture=\[0\]\) keeps it"),
        (lambda r: r.sel(marker="m16"), r"`position_mm` has no `marker`: sel\(marker=\['m16'\]\) keeps it"),
        (lambda r: r.isel(event=0), r"`event_time_s` has no `event`: .*isel\(event=\[0\]\) keeps"),
        (lambda r: r.mean("time"), "`hold_s` has no `time`: .* before any mean over `time`"),
        (lambda r: r.drop_vars("hold_s"), "the run has no `hold_s`: labrig takes a run as labrig.open_run"),
        (lambda r: r.drop_vars("marker"), "`position_mm` has no `marker`"),
        (lambda r: r.rename(marker="m"), "`position_mm` has no `marker`: .*no dimension `m`: was it renamed"),
        (lambda r: r.sel(axis=["x", "z"]), "`axis` is x, z: a marker's places need x, y and z"),
        (lambda r: r.isel(event=[0]), "`event_of` counts events that are not there"),
        (lambda r: r.isel(capture=[]), "the run has no captures"),
    ],
)
def test_what_is_missing_is_named(
    run: xr.Dataset, change: Callable[[xr.Dataset], xr.Dataset], said: str
) -> None:
    """A variable or a dimension that is gone is named in one line, with what keeps it."""
    with pytest.raises(LabrigError, match=said) as raised:
        rows_of(change(run))
    assert "\n" not in str(raised.value)


def test_a_set_point_that_nobody_knows_is_named(run: xr.Dataset) -> None:
    """NaN in `commanded` is said of `commanded`, with its chamber and its capture, whatever the model is."""
    commanded = run.commanded.copy()
    commanded[3, 2] = np.nan
    with pytest.raises(LabrigError, match="`commanded` of chamber c3 in capture 3 is NaN"):
        rows_of(run.assign(commanded=commanded))
    with pytest.raises(LabrigError, match="drop=True"):
        rows_of(run.where(run.capture > 2))
