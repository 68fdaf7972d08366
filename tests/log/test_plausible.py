"""Units and limits against the numbers, and files that nothing can be made of: one line each, nothing left behind."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import labrig
from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed


def imported(pressures: list[float], actuation: dict[str, Any], observable: dict[str, Any] | None = None):
    """A run of a few set-points."""
    Path("t.csv").write_text("p,F\n" + "".join(f"{p},{i}\n" for i, p in enumerate(pressures)))
    mapping = {
        "table": "t.csv",
        "actuation": [{"column": "p", "name": "p", **actuation}],
        "observables": [{"column": "F", "name": "F", "unit": "N", **(observable or {})}],
    }
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    return labrig.import_table("map.yaml", "run")


@pytest.mark.parametrize(
    ("actuation", "remark"),
    [
        (
            {"unit": "kPa"},
            "goes to 2.5 kPa, which is unusual for a pressure; in bar or psi they would be usual",
        ),
        (
            {"unit": "MPa"},
            "goes to 2.5 MPa, which is unusual for a pressure; in bar or psi they would be usual",
        ),
        ({"unit": "kPa", "max": 250}, "goes to 2.5 kPa, less than 2 % of its max of 250; are they in bar?"),
        ({"unit": "bar", "max": 2.4}, "set-points up to 2.5 bar, beyond its max of 2.4 bar (1 of 4 rows)"),
    ],
)
def test_a_unit_that_is_unlikely_is_remarked(desk: Path, actuation: dict[str, Any], remark: str) -> None:
    """Bar written as kPa, or as MPa, and set-points a little above their limit: the run is made and says so."""
    run = imported([0.0, 1.0, 2.0, 2.5], actuation)
    assert any(remark in said for said in run.attrs["warnings"])


def test_a_unit_that_fits_is_not_remarked(desk: Path) -> None:
    """The same numbers in bar, within their limit, are taken as they are."""
    assert imported([0.0, 1.0, 2.0, 2.5], {"unit": "bar", "min": 0, "max": 4}).attrs["warnings"] == []


@pytest.mark.parametrize(
    ("actuation", "complaint"),
    [
        (
            {"unit": "bar", "max": 2.5},
            "set-points up to 250 bar, beyond its max of 2.5 bar (3 of 4 rows); are they in kPa?",
        ),
        ({"unit": "kPa", "min": 300, "max": 400}, "set-points up to 0 kPa, beyond its min of 300 kPa"),
        ({"unit": "kPa", "min": 4, "max": 1}, "its max 1 is not above its min 4"),
    ],
)
def test_limits_that_cannot_be_are_refused(desk: Path, actuation: dict[str, Any], complaint: str) -> None:
    """Set-points far beyond a limit mean another unit; no run is made."""
    with pytest.raises(LabrigError) as raised:
        imported([0.0, 100.0, 200.0, 250.0], actuation)
    assert complaint in str(raised.value)
    assert not Path("run").exists()


@pytest.mark.parametrize("unit", ["px", "pixel", "pixels"])
def test_pixels_are_no_lengths(desk: Path, unit: str) -> None:
    """A coordinate in pixels stays as it is, in pixels: nobody calibrated the camera."""
    run = imported([10.0, 20.0, 30.0], {"unit": "kPa"}, {"unit": unit, "marker": "m", "axis": "x"})
    assert run["observed"].to_numpy().ravel().tolist() == [0.0, 1.0, 2.0]
    assert run["unit"].to_numpy().tolist() == [unit]


NASTY: dict[str, bytes] = {
    "empty.csv": b"",
    "blank.csv": b"\n\n  \n",
    "binary.csv": bytes(range(256)) * 20,
    "words.csv": b"dear diary\ntoday it rained\n",
    "header.csv": b"t,p,F\n",
    "ragged.csv": b"t,p,F\n0,1,2\n1,2,3,4,5,6\n2,3,4\n",
    "text.xlsx": b"t,p\nno workbook",
    "cut.xlsx": b"PK\x03\x04 cut",
    "cut.mat": b"MATLAB 5.0 MAT-file".ljust(128) + b"\x0e\x00\x00\x00 and no more",
    "cut.h5": b"\x89HDF\r\n\x1a\n and no more",
    "cut.npz": b"PK\x03\x04" + b"\x00" * 40,
    "cut.parquet": b"PAR1 and no more",
    "cut.mcap": b"\x89MCAP0\r\n and no more",
    "cut.bag": b"#ROSBAG V2.0\n and no more",
    "no.c3d": b"no markers",
    "a.db3": b"SQLite format 3\x00 no more",
}


@pytest.mark.parametrize("name", list(NASTY))
def test_what_is_no_table_ends_in_one_line(desk: Path, labrig, name: str) -> None:
    """The line names the file, the exit code is 2, and nothing is left behind."""
    Path(name).write_bytes(NASTY[name])
    code, out, err = labrig("import", name, "-o", "run")
    assert (code, out) == (2, "")
    assert err.startswith("labrig: ")
    assert name in err or "ROS" in err
    assert err.count("\n") == 1
    assert len(err) < 400
    assert [p.name for p in Path().iterdir()] == [name]


def test_a_name_that_two_columns_have(desk: Path) -> None:
    """Which of them is meant can't be known; one that nobody asks for does no harm."""
    Path("t.csv").write_text("t,p,F,F\n" + "".join(f"{i},{10 * i},{i},{-i}\n" for i in range(9)))
    mapping = {
        "table": "t.csv",
        "actuation": [{"column": "p", "name": "p", "unit": "kPa"}],
        "observables": [{"column": "F", "name": "F", "unit": "N"}],
    }
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    with pytest.raises(LabrigError, match=r"t\.csv: two columns are called 'F' \(observable F\)"):
        labrig.import_table("map.yaml", "run")
    mapping["observables"] = [{"column": "t", "name": "t", "unit": "N"}]
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    assert labrig.import_table("map.yaml", "run").sizes["capture"] == 9


def test_a_huge_cell_is_cut_in_the_complaint(desk: Path) -> None:
    """A cell of a million characters is shown by its beginning."""
    Path("t.csv").write_text("p,F\n1,2\n2," + "x" * 1_000_000 + "\n")
    Path("map.yaml").write_text(
        "table: t.csv\nactuation: [{column: p, name: p, unit: kPa}]\n"
        "observables: [{column: F, name: F, unit: N}]\n"
    )
    with pytest.raises(LabrigError) as raised:
        labrig.import_table("map.yaml", "run")
    assert str(raised.value).startswith("t.csv, line 3: column 'F' (observable F) holds 'xxxx")
    assert len(str(raised.value)) < 200


@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    data=st.one_of(
        st.binary(max_size=400), st.text("0123456789.,;-eE \n\t\"'tpxF#µ", max_size=400).map(str.encode)
    )
)
def test_whatever_a_file_holds(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Any bytes end as a run that can be opened or as one line, never in another error."""
    folder = tmp_path_factory.mktemp("any")
    (folder / "t.csv").write_bytes(data)
    said = ""
    try:
        import_guessed([folder / "t.csv"], folder / "run")
    except LabrigError as error:
        said = str(error).strip()
    if said:
        assert "\n" not in said
        assert not (folder / "run").exists()
    else:
        assert labrig.open_run(folder / "run").sizes["capture"] > 0


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(25, 120),
    separator=st.sampled_from([",", ";", "\t"]),
    comma=st.booleans(),
    unit=st.sampled_from(["kPa", "bar", "psi", "V"]),
)
def test_a_table_that_was_written_is_read_back(
    seed: int, n: int, separator: str, comma: bool, unit: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """However numbers are separated and pointed, the guess finds the columns, and the run has the numbers."""
    rng = np.random.default_rng(seed)
    table = np.column_stack([np.arange(n) * 0.05, rng.uniform(10, 60, n), rng.normal(size=n)]).round(6)
    comma = comma and separator != ","
    lines = [separator.join(["t [s]", f"u1 [{unit}]", "F [N]"])]
    lines += [separator.join(f"{v:.6f}".replace(".", "," if comma else ".") for v in row) for row in table]
    path = tmp_path_factory.mktemp("any") / "t.csv"
    path.write_text("\n".join(lines) + "\n")
    guess = guess_mapping(path)
    assert guess.mapping["time"]["unit"] == "s"
    assert guess.mapping["actuation"] == [{"column": f"u1 [{unit}]", "name": "u1", "unit": unit}]
    run, _, _ = import_guessed([path], path.with_name("run"))
    held = np.isfinite(run["time_s"].to_numpy())
    assert run["observed"].to_numpy()[held][:, 0] == pytest.approx(table[:, 2])


@pytest.mark.parametrize(
    ("column", "name", "unit"),
    [
        ("p1_kPa", "p1", "kPa"),
        ("chamber1_hPa", "chamber1", "hPa"),
        ("p1_mBar", "p1", "mbar"),
        ("p1kPa", "p1", "kPa"),
        ("p1_Pa", "p1", "Pa"),
        ("p1_kpa", "p1", "kPa"),
    ],
)
def test_a_unit_with_capitals_inside_is_one_word(desk: Path, column: str, name: str, unit: str) -> None:
    """A pressure in kPa is not one in Pa, however the header spells it."""
    Path("t.csv").write_text(f"{column},F_kN\n" + "".join(f"{40 * (i % 3)},{i % 5}\n" for i in range(16)))
    mapping = guess_mapping(desk / "t.csv").mapping
    assert [(a["name"], a["unit"]) for a in mapping["actuation"]] == [(name, unit)]
    assert [(o["name"], o["unit"]) for o in mapping["observables"]] == [("F", "kN")]


def test_a_run_in_a_folder_that_is_not_there(desk: Path) -> None:
    """The error names the folder, not the table."""
    Path("t.csv").write_text("p1_kPa,F_N\n" + "".join(f"{9 * i},{i}\n" for i in range(8)))
    with pytest.raises(LabrigError) as caught:
        import_guessed([Path("t.csv")], Path("nowhere/run"))
    assert str(caught.value) == f"{Path('nowhere/run')}: the folder nowhere does not exist"


def test_a_stress_may_have_any_size(desk: Path) -> None:
    """A stress is in a unit of pressure, and is none: 7 MPa is usual for it."""
    run = imported([0.0, 20.0, 60.0], {"unit": "kPa"}, {"name": "True Stress", "unit": "MPa"})
    assert not any("unusual" in line for line in run.attrs["warnings"])
