"""Logs in which names stand before numbers, notes among the first rows, files that do not cover another."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table
from labrig.tables import read_file, sniff
from labrig.tables._join import _span
from labrig.tables._labelled import is_labelled

N = 24
T = 0.5 * np.arange(N)
P = np.repeat([0.0, 20.0, 40.0, 10.0], 6)
ROWS = [f"{t},{p},{p / 8:.3f}" for t, p in zip(T, P, strict=True)]


def write(lines: list[str], name: str = "t.csv") -> Path:
    """A file of these lines."""
    path = Path(name)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def stamped(before: str, between: str, *, unit: str = "") -> list[str]:
    """Lines of a serial plotter, each with what stands before its names."""
    return [
        f"{before.format(s=int(t), ms=int(t * 1000) % 1000)}Setpoint:{p}{unit}{between}Angle:{p / 8:.3f}"
        for t, p in zip(T, P, strict=True)
    ]


@pytest.mark.parametrize("between", [",", "\t", " ", ", "])
@pytest.mark.parametrize(
    "before",
    ["", "13:05:{s:02d}.{ms:03d} -> ", "2026-03-04 13:05:{s:02d},{ms:03d} INFO rig: ", "[{s}.{ms:03d}] "],
)
def test_a_log_of_a_serial_plotter(desk: Path, before: str, between: str) -> None:
    """Names before numbers are the columns; what is written before the first of them is the time."""
    found = guess_mapping(write(stamped(before, between), "log.txt"))
    assert found.mapping["format"] == {"separator": "labels"}
    assert [one["column"] for one in found.mapping["actuation"]] == ["Setpoint"]
    assert [one["column"] for one in found.mapping["observables"]] == ["Angle"]
    assert found.mapping.get("time", {}).get("column") == ("time" if before else None)
    Path("map.yaml").write_text(yaml.safe_dump(found.mapping))
    run = import_table(Path("map.yaml"), Path("run"))
    commanded = run["commanded"].to_numpy().ravel()
    assert commanded[np.r_[True, np.diff(commanded) != 0]] == pytest.approx([0, 20, 40, 10])
    times = run["time_s"].to_numpy()
    assert np.sort(times[np.isfinite(times)])[-1] == pytest.approx(T[-1] if before else N - 1)


@pytest.mark.parametrize(
    "stamp",
    [
        "2026-03-04T13:05:{s:02d}.{ms:03d}",
        "2026-03-04 13:05:{s:02d}.{ms:03d}+01:00",
        "04.03.2026 13:05:{s:02d},{ms:03d}",
    ],
)
@pytest.mark.parametrize("between", [",", " "])
def test_a_date_with_a_name_before_it(desk: Path, stamp: str, between: str) -> None:
    """A date and time with a name is one value, whole to its zone, and the clock."""
    found = guess_mapping(write(stamped(f"stamp:{stamp}{between}", between), "log.txt"))
    assert found.mapping["format"] == {"separator": "labels"}
    assert found.mapping["time"]["column"] == "stamp"
    Path("map.yaml").write_text(yaml.safe_dump(found.mapping))
    times = import_table(Path("map.yaml"), Path("run"))["time_s"].to_numpy()
    assert np.nanmax(times) - np.nanmin(times) == pytest.approx(T[-1])


def test_units_behind_the_numbers(desk: Path) -> None:
    """A unit behind a number is the column's, and several numbers behind one name are several columns."""
    table = read_file(path := write(["P: 20.0 kPa, flex: 1,2,3", "P: 30.0 kPa, flex: 4,5,6"]), sniff(path))
    assert list(table.frame.columns) == ["P [kPa]", "flex", "flex 2", "flex 3"]
    assert table.frame.to_numpy().tolist() == [[20, 1, 2, 3], [30, 4, 5, 6]]


def test_lines_with_other_names_are_left_out(desk: Path) -> None:
    """Lines of a log that have other names, or none, are said; lines are counted on."""
    lines = ["boot ok", *stamped("", ",")[:8], "warning: valve 3 late", *stamped("", ",")[8:]]
    table = read_file(path := write(lines, "log.txt"), sniff(path))
    assert len(table.frame) == N
    assert table.said == ("2 lines without these names are left out (first line 1)",)
    assert table.at(8) == "log.txt, line 11"


@pytest.mark.parametrize("line", ["word " * 13000, "a:1" + " " * 65000 + "x", "a-" * 30000])
def test_long_lines_do_not_hang(line: str) -> None:
    """Lines of 64 KB, whatever is in them, are looked at in a moment: else this test never ends."""
    assert not is_labelled([line, "t,p,F"])


def test_a_column_of_words_with_numbers_makes_no_such_log(desk: Path) -> None:
    """A table of which one column holds such as state:1 is a table."""
    found = guess_mapping(write(["t_s,p_set_kPa,F_N,note", *[f"{row},state:1" for row in ROWS]]))
    assert "format" not in found.mapping
    assert [one["column"] for one in found.mapping["actuation"]] == ["p_set_kPa"]


def test_a_file_without_such_names(desk: Path) -> None:
    """A mapping that wants names before numbers where there are none ends in one line."""
    write(["t,p,F", *ROWS])
    mapping = {
        "table": "t.csv",
        "format": {"separator": "labels"},
        "actuation": [{"column": "p", "name": "p", "unit": "kPa"}],
    }
    Path("map.yaml").write_text(
        yaml.safe_dump(mapping | {"observables": [{"column": "F", "name": "F", "unit": "N"}]})
    )
    with pytest.raises(LabrigError) as error:
        import_table(Path("map.yaml"), Path("run"))
    assert str(error.value) == "t.csv: no line has a number with its name before it, such as angle:12.3"


@pytest.mark.parametrize("after", [0, 1, 2, 3, 5])
@pytest.mark.parametrize("note", ["# missing reply", "Sensor timeout, retry", "timeout"])
def test_a_note_among_the_first_rows(desk: Path, after: int, note: str) -> None:
    """Names are found, and no row is lost, wherever a note stands."""
    path = write(["t_s,p_set_kPa,F_N", *ROWS[:after], note, *ROWS[after:]])
    table = read_file(path, sniff(path))
    assert table.numbers("p_set_kPa", "actuation").tolist() == P.tolist()
    assert table.said == (f"line {after + 2} holds no number and is left out",)


def test_numbers_that_describe_columns_are_no_rows(desk: Path) -> None:
    """Lengths and increments between the names and the rows are no measurement."""
    head = [
        "Channel,t,p_set_kPa,F",
        "Unit,s,kPa,N",
        "Length,24,24,24",
        "wf_increment,0.5,0.5,0.5",
        "Values,,,",
    ]
    path = write([*head, *["," + row for row in ROWS]])
    assert len(read_file(path, sniff(path)).frame) == N


def test_a_unit_that_is_a_ratio(desk: Path) -> None:
    """mm/mm is a unit, and a line of units with it is no row."""
    path = write(["t,p_set,strain", "(sec),(kPa),(mm/mm)", *ROWS])
    found = guess_mapping(path)
    assert found.mapping["format"] == {"units_row": True}
    assert [one["unit"] for one in (*found.mapping["actuation"], *found.mapping["observables"])] == [
        "kPa",
        "1",
    ]


def test_comments_that_look_like_names(desk: Path) -> None:
    """Words of a comment that are too few for the cells name no columns."""
    rows = [row.replace(",", " ") + " 0 0 0 0 1\t" for row in ROWS]
    head = [
        "# Gnuplot File : positions of 1 particle(s) Monitored",
        "# 1st Column : time, others : particle(s) number 0 ",
    ]
    found = guess_mapping(write([*head, *rows], "x.txt"))
    assert found.mapping["format"] == {"separator": "whitespace", "header": False, "skip_rows": 2}


def test_rows_outside_a_joined_file(desk: Path) -> None:
    """Rows before or after a joined file are counted, and where they are most of all, what may be wrong is asked."""
    write(["t_s,p_set_kPa", *[row.rpartition(",")[0] for row in ROWS]])
    write(["frame,F_N", *[f"{i},{p / 8}" for i, p in enumerate(P)]], "cam.csv")
    join = {"name": "cam", "file": "cam.csv", "time": {"column": "frame", "rate_hz": 2.0}}
    mapping = {
        "table": "t.csv", "time": {"column": "t_s", "unit": "s"},
        "actuation": [{"column": "p_set_kPa", "name": "p", "unit": "kPa"}],
        "observables": [{"column": "cam.F_N", "name": "F", "unit": "N"}],
    }  # fmt: skip

    def remarks(rate_hz: float, name: str) -> list[str]:
        join["time"] = {"column": "frame", "rate_hz": rate_hz}
        Path("map.yaml").write_text(yaml.safe_dump(mapping | {"join": [join]}))
        said = import_table(Path("map.yaml"), Path(name)).attrs["import_remarks"]
        return [line for line in said if "before or after" in line]

    assert remarks(2.0, "same") == []
    assert _span(1793697128.0, 1793700728.0) == "2026-11-03 09:12:08 to 2026-11-03 10:12:08 UTC"
    assert remarks(2.5, "faster") == ["t.csv: 4 of 24 rows are before or after cam.csv, 0 to 9.2 s"]
    assert remarks(20.0, "wrong") == [
        "t.csv: 21 of 24 rows are before or after cam.csv, 0 to 1.15 s; is its unit, 'rate_hz' or 'offset_s' right?"
    ]


def test_the_guess_is_kept_where_the_import_fails(desk: Path) -> None:
    """A table that can't be imported as guessed leaves no run, and the mapping to be corrected; the message says so."""
    lines = ["t_s,p_set_kPa,F_N", *ROWS[:12], "6.0,,0.1", *ROWS[13:]]
    with pytest.raises(LabrigError) as error:
        import_guessed([write(lines)], Path("run"))
    assert str(error.value).endswith(
        "; correct the table and import it again, or what was guessed, which is in run.map.yaml, and use it: "
        "labrig import --mapping run.map.yaml -o run"
    )
    assert not Path("run").exists()
    assert yaml.safe_load(Path("run.map.yaml").read_text())["table"] == "t.csv"


def test_a_unit_as_people_write_it(desk: Path) -> None:
    """A unit that a guess reads and a mapping does not is refused with the way it is written."""
    write(["t_s,p_set_kPa,R (Ohm)", *ROWS])
    mapping = guess_mapping(Path("t.csv")).mapping
    assert mapping["observables"] == [{"column": "R (Ohm)", "name": "R", "unit": "ohm"}]
    mapping["observables"][0]["unit"] = "Ohm"
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    with pytest.raises(LabrigError) as error:
        import_table(Path("map.yaml"), Path("run"))
    assert str(error.value) == "map.yaml: observables 'R': there is no unit 'Ohm'; write ohm"


def test_a_second_table_in_the_file(desk: Path) -> None:
    """A table below the first with more columns is refused where it begins, with how to read either."""
    second = ["Trajectories", "frame,t,x,y,z", *[f"{i},{i / 100},1,2,3" for i in range(9)]]
    path = write(["Devices", "t_s,p_set_kPa,F_N", *ROWS, "", *second])
    with pytest.raises(LabrigError) as error:
        guess_mapping(path)
    assert str(error.value) == (
        f"t.csv, line {N + 5}: has 5 cells where those before have 3: does a second table begin there? 'format: rows:' "
        "reads the first alone, 'skip_rows:' the other"
    )
    first = read_file(path, sniff(path).model_copy(update={"rows": N}))
    assert first.numbers("p_set_kPa", "actuation").tolist() == P.tolist()


@pytest.mark.parametrize(("written", "decimal"), [("1,5", ","), ("1,500", ".")])
def test_commas_in_quotes(desk: Path, written: str, decimal: str) -> None:
    """Between commas a number in quotes may have a decimal comma, but for one that may part thousands."""
    path = write(["t_s,p_set_kPa,F_N", *[f'{i},"{written}","{written}"' for i in range(9)]])
    assert sniff(path).decimal == decimal
