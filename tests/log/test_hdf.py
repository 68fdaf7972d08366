"""HDF5 and NetCDF-4: numbers, units and clocks as the attributes of their arrays say."""

from pathlib import Path

import numpy as np
import pytest

from labrig import LabrigError
from labrig.log import import_guessed, import_table

N = 40
SET = np.repeat([0.0, 10.0, 30.0, 20.0], 10)


def write(name: str, time: np.ndarray, since: str, **height: object) -> Path:
    """A file of a clock, a pressure and a height in mm, packed as NetCDF does it unless `height` has a `unit`."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(name, "w") as file:
        file["time"] = time
        file["time"].attrs["units"] = np.bytes_(since)
        file["p_set"] = SET
        file["p_set"].attrs["units"] = "kPa"
        packed = np.round((50 + 0.2 * SET - 50) / 0.001).astype("i2")
        packed[3] = -32768
        file["height"] = packed
        packing = {"scale_factor": 0.001, "add_offset": np.array([50.0]), "_FillValue": np.int16(-32768)}
        file["height"].attrs.update({**packing, "units": "mm", **height})
        file["nothing"] = np.zeros(N)
        file["nothing"].attrs["NAME"] = np.bytes_(
            "This is a netCDF dimension but not a netCDF variable.   40"
        )
    return Path(name)


def test_packed_numbers(desk: Path) -> None:
    """Scale, offset and the number that stands for nothing are taken from the attributes, and units, too."""
    path = write("a.nc", np.arange(N), "minutes since 2026-05-04 08:00:00")
    run, guess, _ = import_guessed([path], Path("run"))
    assert [guess.mapping[part][0]["unit"] for part in ("actuation", "observables")] == ["kPa", "mm"]
    assert len(guess.mapping["observables"]) == 1
    expected = 50 + 0.2 * SET
    expected[3] = np.nan
    assert run["observed"].to_numpy().ravel() == pytest.approx(expected, abs=1e-9, nan_ok=True)
    assert run["time_s"].to_numpy().ravel() == pytest.approx(60.0 * np.arange(N), abs=1e-6)


def test_times_since_a_date(desk: Path) -> None:
    """Two files whose clocks each count from their own day keep the time between them."""
    paths = [
        write("b.nc", np.arange(N) * 1000, "milliseconds since 2026-05-05"),
        write("a.nc", np.arange(N) * 1000, "milliseconds since 2026-05-04"),
    ]
    run, _, _ = import_guessed(paths, Path("run"))
    assert list(dict.fromkeys(run["session"].to_numpy().tolist())) == ["a", "b"]
    assert np.nanmax(run["time_s"].to_numpy()) == pytest.approx(86400 + N - 1)


def test_a_mapping_in_another_unit(desk: Path) -> None:
    """A unit that the attribute of an array contradicts is refused."""
    write("a.nc", np.arange(N), "s", units="cm")
    Path("m.yaml").write_text(
        "table: a.nc\ntime: {column: time, unit: s}\nactuation: [{column: p_set, name: p, unit: kPa}]\n"
        "observables: [{column: height, name: h, unit: mm}]\n"
    )
    with pytest.raises(LabrigError, match=r"'height' .* is in cm, as the table says, and in mm"):
        import_table(Path("m.yaml"), Path("run"))


def test_calibrations_beside_a_record_do_not_cut_its_names(desk: Path) -> None:
    """Of arrays of two lengths on one level each part keeps the whole names of its columns."""
    h5py = pytest.importorskip("h5py")
    with h5py.File("a.h5", "w") as file:
        for name in ("gain", "offset", "noise", "scale", "serial"):
            file[f"run/{name}"] = np.arange(4.0)
        file["run/time_s"], file["run/p_cmd_kPa"] = np.arange(N, dtype=float), SET
        file["run/y_mm"] = 50 + 0.2 * SET
    run, guess, _ = import_guessed([Path("a.h5")], Path("run"))
    assert guess.mapping["time"]["column"] == "time_s"
    assert [guess.mapping[part][0]["name"] for part in ("actuation", "observables")] == ["p_cmd", "y"]
    assert run["commanded"].attrs["units"] == "kPa"


@pytest.mark.parametrize("kind", [np.bytes_(b"char"), "char"])
def test_a_text_of_matlab_is_no_column(desk: Path, kind: object) -> None:
    """What is marked as text is left out, whether the mark is bytes or a text itself."""
    h5py = pytest.importorskip("h5py")
    with h5py.File("a.mat", "w") as file:
        file["t_s"], file["p_set"], file["y_mm"] = np.arange(N, dtype=float), SET, 50 + 0.2 * SET
        file["title"] = np.full(N, 65, np.uint16)
        file["title"].attrs["MATLAB_class"] = kind
    _, guess, _ = import_guessed([Path("a.mat")], Path("run"))
    assert [entry["column"] for entry in guess.mapping["observables"]] == ["y_mm"]
