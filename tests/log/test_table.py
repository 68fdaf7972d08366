"""A Dataset becomes a run folder, and the folder the same Dataset again."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from labrig import LabrigError, open_run
from labrig.log import write_dataset

names = st.text(st.characters(exclude_categories=("C",)), min_size=1, max_size=5)
numbers = st.floats(allow_nan=True, allow_infinity=True, width=64)
finite = st.floats(-1e6, 1e6)


def _unique(draw: Any, low: int, high: int) -> np.ndarray:
    return np.array(draw(st.lists(names, min_size=low, max_size=high, unique=True)), dtype=np.str_)


@st.composite
def campaigns(draw: Any) -> xr.Dataset:
    """Datasets of the documented layout, with and without every optional variable, with ragged holds."""
    captures, longest, events = draw(st.integers(1, 4)), draw(st.integers(1, 4)), draw(st.integers(0, 3))
    chambers = _unique(draw, 1, 3)
    lengths = draw(st.lists(st.integers(0, longest), min_size=captures, max_size=captures))
    lengths[0] = longest
    rows = np.arange(longest)[None, :] < np.array(lengths)[:, None]

    def array(*shape: int, padded: bool = False, elements: Any = numbers) -> np.ndarray:
        values = draw(hnp.arrays(float, shape, elements=elements))
        return (
            np.where(rows.reshape(*rows.shape, *[1] * (len(shape) - 2)), values, np.nan) if padded else values
        )

    def text(count: int) -> np.ndarray:
        labels = st.lists(st.sampled_from(["", "a", "day 2", "π"]), min_size=count, max_size=count)
        return np.array(draw(labels), dtype="<U8")

    hold = ("capture", "time")
    times = array(captures, longest, padded=True, elements=finite)
    data: dict[str, Any] = {
        "commanded": (("capture", "chamber"), array(captures, len(chambers)), {"units": "bar"}),
        "hold_s": (hold, array(captures, longest, padded=True, elements=finite)),
        "time_s": (hold, times),
        "settled": (hold, draw(hnp.arrays(bool, (captures, longest))) & rows),
        "event_time_s": (("event",), array(events)),
        "event_commanded": (("event", "chamber"), array(events, len(chambers))),
    }
    coords: dict[str, Any] = {
        "capture": np.arange(captures),
        "chamber": chambers,
        "session": ("capture", text(captures)),
        "repeat": ("capture", text(captures)),
        "event_of": ("capture", draw(hnp.arrays(np.int64, captures, elements=st.integers(-1, 3)))),
        "event_session": ("event", text(events)),
        "chamber_min": ("chamber", array(len(chambers))),
        "chamber_max": ("chamber", array(len(chambers))),
    }
    if draw(st.booleans()):
        data["measured"] = ((*hold, "chamber"), array(captures, longest, len(chambers), padded=True))
    if draw(st.booleans()):
        markers = _unique(draw, 1, 3)
        coords |= {"marker": markers, "axis": np.array(["x", "y", "z"])}
        position = array(captures, longest, len(markers), 3, padded=True)
        data["position_mm"] = ((*hold, "marker", "axis"), position)
        if draw(st.booleans()):
            data["rest_mm"] = (("marker", "axis"), array(len(markers), 3))
    if draw(st.booleans()):
        observables = _unique(draw, 1, 3)
        data["observed"] = ((*hold, "observable"), array(captures, longest, len(observables), padded=True))
        coords["observable"] = observables
        for name in ("unit", "marker_of", "axis_of"):
            coords[name] = ("observable", text(len(observables)))
    if draw(st.booleans()):
        covariates = _unique(draw, 1, 2)
        data["covariates"] = ((*hold, "covariate"), array(captures, longest, len(covariates), padded=True))
        coords |= {"covariate": covariates, "covariate_unit": ("covariate", text(len(covariates)))}
    between = draw(st.sampled_from(["held", "vented", "unknown"]))
    return xr.Dataset(data, coords, {"source": "table", "between_sessions": between, "title": "x"})


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(campaign=campaigns())
def test_what_is_written_is_read_back_equal(campaign: xr.Dataset, tmp_path_factory: Any) -> None:
    """Every number to the last digit, every NaN, every name, and the attributes."""
    folder = tmp_path_factory.mktemp("table") / "run"
    write_dataset(campaign, folder, run_yaml={"procedure": "import"})
    back = open_run(folder)
    xr.testing.assert_equal(back, campaign)
    assert back["commanded"].attrs["units"] == "bar"
    assert {name: back.attrs[name] for name in campaign.attrs} == campaign.attrs
    assert back.attrs["warnings"] == []


def _simple(captures: int = 3, rows: int = 4) -> xr.Dataset:
    hold = ("capture", "time")
    time_s = np.arange(captures * rows, dtype=float).reshape(captures, rows)
    return xr.Dataset(
        {
            "commanded": (("capture", "chamber"), np.ones((captures, 1)), {"units": "kPa"}),
            "hold_s": (hold, time_s - time_s[:, :1]),
            "time_s": (hold, time_s),
            "settled": (hold, np.ones((captures, rows), bool)),
            "event_time_s": ("event", time_s[:, 0]),
            "event_commanded": (("event", "chamber"), np.ones((captures, 1))),
            "observed": ((*hold, "observable"), time_s[..., None].copy()),
        },
        {
            "chamber": ["p"],
            "session": ("capture", [""] * captures),
            "repeat": ("capture", [""] * captures),
            "event_of": ("capture", np.arange(captures)),
            "event_session": ("event", [""] * captures),
            "chamber_min": ("chamber", [0.0]),
            "chamber_max": ("chamber", [np.inf]),
            "observable": ["force"],
            "unit": ("observable", ["N"]),
            "marker_of": ("observable", [""]),
            "axis_of": ("observable", [""]),
        },
        {"source": "table", "between_sessions": "unknown"},
    )


def test_run_yaml_is_kept(tmp_path: Path) -> None:
    """What the caller says of the run is in run.yaml, plain values or not."""
    folder = write_dataset(
        _simple(), tmp_path / "run", run_yaml={"procedure": "import", "from": Path("a.csv")}
    )
    assert yaml.safe_load((folder / "run.yaml").read_text()) == {"procedure": "import", "from": "a.csv"}


def test_an_existing_folder_is_refused(tmp_path: Path) -> None:
    """Nothing is ever overwritten."""
    (tmp_path / "run").mkdir()
    with pytest.raises(LabrigError) as caught:
        write_dataset(_simple(), tmp_path / "run", run_yaml={})
    assert str(caught.value) == f"{tmp_path / 'run'} exists already; choose another name or remove it"


def test_a_missing_variable_is_named(tmp_path: Path) -> None:
    """The error says which parts of the layout are absent, and nothing is left behind."""
    with pytest.raises(LabrigError) as caught:
        write_dataset(_simple().drop_vars(["time_s", "repeat"]), tmp_path / "run", run_yaml={})
    assert str(caught.value) == "the campaign has no time_s, repeat; see docs/reference/dataset.md"
    assert list(tmp_path.iterdir()) == []


def test_values_in_a_row_without_time_are_refused(tmp_path: Path) -> None:
    """A row that could not be read back is not thrown away in silence."""
    campaign = _simple()
    for name in ("time_s", "hold_s"):
        campaign[name][1, 3] = np.nan
    with pytest.raises(LabrigError) as caught:
        write_dataset(campaign, tmp_path / "run", run_yaml={})
    assert str(caught.value) == "observed of capture 1 has values in row 3, which has no time"


def test_a_write_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder appears whole or not at all."""

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("labrig.log._writer.LogWriter.command", full)
    with pytest.raises(OSError, match="No space left"):
        write_dataset(_simple(), tmp_path / "run", run_yaml={})
    assert list(tmp_path.iterdir()) == []


def test_a_cut_table_keeps_its_whole_captures(tmp_path: Path) -> None:
    """A table's log may be damaged as well; the rows that are left are read, and the loss is said."""
    folder = write_dataset(_simple(60, 500), tmp_path / "run", run_yaml={})
    log = folder / "log.000.mcap"
    log.write_bytes(log.read_bytes()[: log.stat().st_size * 2 // 3])
    run = open_run(folder)
    assert 0 < run.sizes["capture"] < 60
    assert run.attrs["warnings"][0].startswith("log.000.mcap: not closed")
