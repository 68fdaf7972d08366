"""Tables as instruments lay them out: lines above the names, names in two lines, notes between rows, what is unseen."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table
from labrig.tables import read_file, sniff
from labrig.tables._mapping import Format

N = 24
T = 0.5 * np.arange(N)
P = np.repeat([0.0, 20.0, 40.0, 10.0], 6)
XYZ = np.stack([60 + 0.1 * P, 20 - 0.05 * P, 190 + 0.02 * P], axis=1)
ROWS = [f"{t},{p},{p / 8:.3f}" for t, p in zip(T, P, strict=True)]
MARKERS = [f"{i},{t},{x:.3f},{y:.3f},{z:.3f},{x + 1:.3f},{y + 1:.3f},{z + 1:.3f}"
           for i, (t, (x, y, z)) in enumerate(zip(T, XYZ, strict=True))]  # fmt: skip


def write(lines: list[str], name: str = "t.csv", end: str = "\n") -> Path:
    """A file of these lines."""
    path = Path(name)
    path.write_text("\n".join(lines) + end, encoding="utf-8")
    return path


LAYOUTS = {
    "Motive": (
        [
            "Format Version,1.23,Take Name,Take 1,Capture Frame Rate,2.000000,Length Units,Millimeters",
            "",
            ",Type,Marker,Marker,Marker,Marker,Marker,Marker",
            ",Name,Arm:M1,Arm:M1,Arm:M1,Arm:M2,Arm:M2,Arm:M2",
            ',ID,"4CF0","4CF0","4CF0","4CF1","4CF1","4CF1"',
            ",,Position,Position,Position,Position,Position,Position",
            "Frame,Time (Seconds),X,Y,Z,X,Y,Z",
        ],
        "Arm:M1 X",
    ),
    "Nexus": (
        ["Trajectories", "2", ",,Arm:M1,,,Arm:M2,,", "Frame,Sub Frame,X,Y,Z,X,Y,Z", ",,mm,mm,mm,mm,mm,mm"],
        "Arm:M1 X",
    ),
    "by hand": (["frame,t,m1,,,m2,,", ",,x,y,z,x,y,z"], "m1 x"),
    "a line a level": (
        [",,tip,tip,tip,base,base,base", "frame,t,x,y,z,x,y,z", ",,mm,mm,mm,mm,mm,mm"],
        "tip x",
    ),
}


@pytest.mark.parametrize("name", list(LAYOUTS))
def test_names_in_several_lines(desk: Path, name: str) -> None:
    """A line above that says whose x, y and z they are is a part of each name."""
    above, first = LAYOUTS[name]
    path = write([*above, *MARKERS])
    table = read_file(path, sniff(path))
    assert len(table.frame) == N
    assert table.frame.columns[2] == first
    assert len(set(table.frame.columns)) == 8
    assert table.numbers(first, "observable") == pytest.approx(XYZ[:, 0], abs=1e-3)


def test_bodies_and_markers_of_one_name(desk: Path) -> None:
    """Where one line above is too few to tell columns apart, two are: turns and places of a body."""
    above = [
        ",Name,Base,Base,Base,Tip,Tip,Tip",
        ",,Rotation,Position,Position,Rotation,Position,Position",
        "Frame,Time (Seconds),X,X,Y,X,X,Y",
    ]
    path = write([*above, *MARKERS])
    assert list(read_file(path, sniff(path)).frame.columns[[2, 3, 5]]) == [
        "Base Rotation X",
        "Base Position X",
        "Tip Rotation X",
    ]


def test_two_instruments_by_a_mapping(desk: Path) -> None:
    """Motion with names in several lines joins pressures of another file, by the names that a guess prints."""
    write([*LAYOUTS["Motive"][0], *MARKERS], "motion.csv")
    write(["t,p_set_kPa,F", *ROWS], "pressures.csv")
    how = sniff(Path("motion.csv"))
    Path("map.yaml").write_text(
        "table: pressures.csv\ntime: {column: t}\n"
        "join: [{name: cam, file: motion.csv, time: {column: Time (Seconds)}, "
        f"format: {{skip_rows: {how.skip_rows}, groups: {how.groups}}}}}]\n"
        "actuation: [{column: p_set_kPa, name: c1, unit: kPa}]\n"
        "observables: [{column: 'cam.Arm:M1 X', name: m1.x, unit: mm, marker: m1, axis: x}]\n",
        encoding="utf-8",
    )
    run = import_table(Path("map.yaml"), Path("run"))
    assert run["observed"].to_numpy()[:, 0, 0] == pytest.approx(XYZ[:, 0], abs=1e-3)


@pytest.mark.parametrize(
    ("above", "separator"),
    [
        (["# t p_set_kPa F"], " "),
        (["LabVIEW Measurement\t", "***End_of_Header***\t", "X0\t0.0\t0.0", "Delta_X\t0.5\t0.5",
          "***End_of_Header***\t\t", "t\tp_set_kPa\tF\tComment"], "\t"),
        (["Results", "Maximum,Mean,Least", '"1",12.3,0.1', "", "Raw Data", "t,p_set_kPa,F", "(s),(kPa),(N)"], ","),
        (["name,t,p_set_kPa,F", "raster,host,host,host"], ",,"),
    ],
)  # fmt: skip
def test_lines_above_the_rows(desk: Path, above: list[str], separator: str) -> None:
    """Names are found behind a sign of a comment, below other lines and small tables, and over lines of words."""
    lead = "," if separator == ",," else ""
    path = write([*above, *[lead + row.replace(",", separator[0]) for row in ROWS]])
    table = read_file(path, sniff(path))
    assert len(table.frame) == N
    assert table.numbers("p_set_kPa", "actuation").tolist() == P.tolist()
    assert table.numbers("t", "time").tolist() == T.tolist()


def test_lines_between_the_rows(desk: Path) -> None:
    """Names that come again, comments, blank lines and a footer are no rows, and are said; lines are counted on."""
    rows = [*ROWS[:8], "t,p_set_kPa,F", *ROWS[8:12], "# a hose came off", "", *ROWS[12:], "End of test"]
    table = read_file(path := write(["t,p_set_kPa,F", *rows]), sniff(path))
    assert table.numbers("F", "observable").tolist() == pytest.approx((P / 8).round(3).tolist())
    assert table.said == ("3 lines hold no number and are left out (line 10, 15, 29)",)
    assert table.at(8) == "t.csv, line 11"
    assert guess_mapping(path).remarks[0] == table.said[0]


def test_a_last_line_that_was_cut(desk: Path) -> None:
    """A row whose end was never written is left out, and it is said."""
    table = read_file(path := write(["t,p_set_kPa,F", *ROWS, "12.0,10"], end=""), sniff(path))
    assert len(table.frame) == N
    assert table.said == ("its last line was not written to its end and is left out",)


def test_blanks_that_hide_a_missing_cell(desk: Path) -> None:
    """With blanks between cells nobody can tell which one is missing: the line is named."""
    rows = [row.replace(",", " ") for row in ROWS]
    path = write(["t p F", *rows[:5], "2.5 20.0", *rows[6:]])
    with pytest.raises(
        LabrigError, match=r"t.csv, line 7: has 2 cells where others have 3: .* write NaN there"
    ):
        read_file(path, sniff(path))


def test_commas_at_the_end_of_rows(desk: Path) -> None:
    """They make no column."""
    path = write(["t,p_set_kPa,F", *[row + "," for row in ROWS]])
    guess = guess_mapping(path)
    assert [o["column"] for o in guess.mapping["observables"]] == ["F"]
    assert guess.mapping["time"]["column"] == "t"


def test_commands_that_are_written_where_they_change(desk: Path) -> None:
    """An empty command is as the one above; a guess sees it, and an empty first one is an error."""
    change = np.r_[True, np.diff(P) != 0]
    rows = [f"{t},{p if new else ''},{p / 8:.3f}" for t, p, new in zip(T, P, change, strict=True)]
    path = write(["t,p_set_kPa,F", *rows])
    assert guess_mapping(path).mapping["actuation"][0]["on_change"] is True
    import_guessed([path], Path("run"))
    assert labrig.open_run("run")["commanded"].to_numpy()[:, 0].tolist() == [0.0, 20.0, 40.0, 10.0]
    write(["t,p_set_kPa,F", "0.0,,0.0", *rows[1:]], "late.csv")
    Path("map.yaml").write_text(
        "table: late.csv\ntime: {column: t}\nobservables: [{column: F, name: F, unit: N}]\n"
        "actuation: [{column: p_set_kPa, name: c1, unit: kPa, on_change: true}]\n"
    )
    with pytest.raises(
        LabrigError, match=r"late.csv, line 2: column 'p_set_kPa' .* is empty in the first row"
    ):
        import_table(Path("map.yaml"), Path("other"))


def test_words_and_numbers_for_nothing(desk: Path) -> None:
    """What `missing` lists is no number, written as a word or as a number."""
    cells = [f"{p / 8:.3f}" for p in P]
    cells[3], cells[9] = "9999", "saturated"
    write(["t,p,F", *[f"{t},{p},{f}" for t, p, f in zip(T, P, cells, strict=True)]])
    Path("map.yaml").write_text(
        "table: t.csv\nformat: {missing: [9999, Saturated]}\ntime: {column: t}\n"
        "actuation: [{column: p, name: c1, unit: kPa}]\nobservables: [{column: F, name: F, unit: N}, "
        "{column: t, name: clock, unit: s}]\n"
    )
    run = import_table(Path("map.yaml"), Path("run"))
    assert np.flatnonzero(np.isnan(run["observed"].to_numpy()[:, 0, 0])).tolist() == [3, 9]


@pytest.mark.parametrize("code", ["0,0,0", "-3.697314e+28,-3.697314e+28,-3.697314e+28", "99999,99999,99999"])
def test_markers_that_were_not_seen(desk: Path, code: str) -> None:
    """What a tracker writes for a marker out of sight is missing, and said; where rest may be at 0, 0 is a place."""
    rows = [f"{t},{p},{x:.3f},{y:.3f},{z:.3f}" for t, p, (x, y, z) in zip(T, P, XYZ, strict=True)]
    for i in (4, 15):
        rows[i] = f"{T[i]},{P[i]},{code}"
    rows = [f"{row},{i}" for i, row in enumerate(rows)]
    import_guessed([write(["t_s,p_set_kPa,m.x_mm,m.y_mm,m.z_mm,force_N", *rows])], Path("run"))
    place, hold = (labrig.open_run("run")[name].to_numpy() for name in ("position_mm", "hold_s"))
    assert np.isnan(place[np.isfinite(hold)]).all(axis=(1, 2)).nonzero()[0].tolist() == [4, 15]
    moved = [f"{t},{p},{p / 9:.3f},{p / 7:.3f},{p / 5:.3f}" for t, p in zip(T, P, strict=True)]
    import_guessed([write(["t_s,p_set_kPa,m.x_mm,m.y_mm,m.z_mm", *moved], "moved.csv")], Path("moved"))
    place, hold = (labrig.open_run("moved")[name].to_numpy() for name in ("position_mm", "hold_s"))
    assert np.isfinite(place[np.isfinite(hold)]).all(axis=(1, 2)).sum() == N


def test_a_sheet_with_a_title(desk: Path) -> None:
    """Titles and empty rows above the names of a workbook are no names; units below them are read."""
    import pandas as pd

    cells = [["Soft arm, campaign 7", None, None], [None] * 3, ["t", "p_set", "F"], ["s", "kPa", "N"],
             *[[float(v) for v in row.split(",")] for row in ROWS]]  # fmt: skip
    pd.DataFrame(cells).to_excel("t.xlsx", header=False, index=False)
    mapping = guess_mapping("t.xlsx").mapping
    assert mapping["format"] == {"skip_rows": 2, "units_row": True}
    assert mapping["actuation"] == [{"column": "p_set", "name": "p_set", "unit": "kPa"}]
    assert mapping["observables"] == [{"column": "F", "name": "F", "unit": "N"}]


@pytest.mark.parametrize("ending", ["csv", "xlsx"])
def test_axes_below_a_merged_name(desk: Path, ending: str) -> None:
    """Columns that are but x and y are those of the name that was merged over them, and no marker without a name."""
    import pandas as pd

    cells = [
        ["", "Pressure", "Tip position", "", ""],
        ["Time", "set", "x", "y", "z"],
        ["s", "kPa", "mm", "mm", "mm"],
    ]
    cells += [[0.1 * i, 10 * (i % 4), 9.5 + i % 4, 2.5 * (i % 4), 80.5 - i % 4] for i in range(24)]
    frame = pd.DataFrame(cells)
    if ending == "csv":
        frame.to_csv("t.csv", header=False, index=False)
    else:
        frame.to_excel("t.xlsx", header=False, index=False)
    mapping = guess_mapping(f"t.{ending}").mapping
    assert {o["marker"] for o in mapping["observables"]} == {"Tip position"}
    assert [a["name"] for a in mapping["actuation"]] == ["Pressure set"]


def test_each_file_may_be_another_sheet(desk: Path) -> None:
    """An entry of `table` names its sheet."""
    import pandas as pd

    with pd.ExcelWriter("t.xlsx") as writer:
        for day, shift in (("monday", 0.0), ("tuesday", 1.0)):
            pd.DataFrame({"t": T, "p": P, "F": P + shift}).to_excel(writer, sheet_name=day, index=False)
    Path("map.yaml").write_text(
        "table: [{file: t.xlsx, part: monday, session: a}, {file: t.xlsx, part: tuesday, session: b}]\n"
        "time: {column: t}\nactuation: [{column: p, name: c1, unit: kPa}]\n"
        "observables: [{column: F, name: F, unit: N}]\n"
    )
    run = import_table(Path("map.yaml"), Path("run"))
    assert run["observed"].to_numpy().ravel().tolist() == [*P, *(P + 1)]
    assert sorted(set(run["session"].to_numpy().tolist())) == ["a", "b"]


def test_a_sensor_in_another_unit_than_its_command(desk: Path) -> None:
    """What a chamber's sensor read is converted to the unit of its command; volts are no pressure."""
    write(["t,p,m,F", *[f"{t},{p},{p / 100},{p / 8}" for t, p in zip(T, P, strict=True)]])
    said = (
        "table: t.csv\ntime: {column: t}\nactuation: [{column: p, name: c1, unit: kPa}]\n"
        "measured: [{column: m, name: c1, unit: UNIT}]\nobservables: [{column: F, name: F, unit: N}]\n"
    )
    Path("map.yaml").write_text(said.replace("UNIT", "bar"))
    run = import_table(Path("map.yaml"), Path("run"))
    assert run["measured"].to_numpy().ravel() == pytest.approx(P)
    Path("map.yaml").write_text(said.replace("UNIT", "V"))
    with pytest.raises(LabrigError, match="measured c1: unit 'V' can't be converted to kPa"):
        import_table(Path("map.yaml"), Path("other"))


def test_a_log_of_a_serial_monitor(desk: Path) -> None:
    """Times before an arrow are a column of their own."""
    lines = [f"13:05:{t:06.3f} -> {p},{p / 8:.3f}" for t, p in zip(T, P, strict=True)]
    table = read_file(path := write(lines, "t.log"), sniff(path))
    assert [table.numbers(c, "it").tolist() for c in (1, 2)] == [P.tolist(), (P / 8).round(3).tolist()]
    guess = guess_mapping(path)
    assert guess.mapping["time"] == {"column": 0, "unit": "date"}


@pytest.mark.parametrize("indent", [None, 0, 2])
@pytest.mark.parametrize("name", ["t.json", "t.txt"])
def test_records_of_json(desk: Path, indent: int | None, name: str) -> None:
    """One record a line, or a list of them in any layout and whatever the file is called.

    Keys within keys, and lists, are columns.
    """
    records = [
        {"t_s": t, "set": {"p_kPa": p}, "tip_mm": place}
        for t, p, place in zip(T.tolist(), P.tolist(), XYZ.tolist(), strict=True)
    ]
    lines = (
        [json.dumps(one) for one in records]
        if indent is None
        else [json.dumps(records, indent=indent or None)]
    )
    path = write(lines, name)
    guess = guess_mapping(path)
    assert guess.mapping["actuation"][0]["column"] == "set.p_kPa"
    assert [o["column"] for o in guess.mapping["observables"]] == ["tip_mm.0", "tip_mm.1", "tip_mm.2"]
    Path("half.json").write_text('{"t": 1}\n{"t": ')
    with pytest.raises(LabrigError, match=r"half.json: can't be read as JSON, one record a line"):
        guess_mapping("half.json")


def test_holds_without_a_clock(desk: Path) -> None:
    """Where only the time of each hold is known, as in a programme that labrig wrote, holds follow one another."""
    hold = np.where(np.arange(N) % 3 == 0, 20.0, 4.0)
    path = write(["p_set_kPa,hold_s,F_N", *[f"{p},{h},{p / 8}" for p, h in zip(P, hold, strict=True)]])
    run, guess, _ = import_guessed([path], Path("run"))
    assert run["time_s"].to_numpy().ravel() == pytest.approx(np.cumsum(hold) - hold[0])
    assert run["hold_s"].to_numpy().ravel() == pytest.approx(hold)
    assert guess.remarks == ["each hold is taken to begin where the one before ended, by 'hold_s'"]


def test_the_unit_of_an_array_is_that_of_its_columns(desk: Path) -> None:
    """p_kPa and heights_mm say the units of all that they hold, and x_mm, y_mm and z_mm are places of as many."""
    random = np.random.default_rng(1)
    arrays = {"p_kPa": random.uniform(0, 30, (N, 2)), "heights_mm": random.normal(size=(N, 2, 2))}
    arrays |= {f"{axis}_mm": random.normal(size=(N, 2)) for axis in "xyz"}
    np.savez("t.npz", t_s=np.arange(N), **arrays)
    guess = guess_mapping(Path("t.npz"))
    found = [(o["name"], o["unit"], o.get("marker")) for o in guess.mapping["observables"]]
    assert found == [
        *((f"marker.{i}.{axis}", "mm", f"marker.{i}") for i in range(2) for axis in "xyz"),
        *((f"heights.{i}.{j}", "mm", None) for i in range(2) for j in range(2)),
    ]
    assert [(a["name"], a["unit"]) for a in guess.mapping["actuation"]] == [("p.0", "kPa"), ("p.1", "kPa")]
    assert not any("unit" in line for line in guess.remarks)


def test_many_columns_without_a_unit_are_said_once(desk: Path) -> None:
    """One line says that four pressures and 25 heights have no unit."""
    random = np.random.default_rng(1)
    np.savez(
        "t.npz", t_s=np.arange(N), p=random.uniform(0, 30, (N, 4)), heights=random.normal(size=(N, 5, 5))
    )
    assert guess_mapping(Path("t.npz")).remarks == [
        "the unit of 'p.0' (and 28 more) is not said: written as 1"
    ]


@pytest.mark.parametrize("sheet", [False, True])
def test_a_first_row_with_blanks_is_a_row(desk: Path, sheet: bool) -> None:
    """A vent at which nothing was measured, below the units and above rows that are full, is the first row: names and
    units are kept.
    """
    rows = [[str(v) for v in line.split(",")] for line in ROWS]
    for i, row in enumerate(rows):
        row[1:] = ["0.0", *6 * [""]] if i % 4 == 0 else [*row[1:], *5 * row[2:]]
    lines = [["t", "p_set", *(f"F{k}" for k in range(6))], ["s", "kPa", *6 * "N"], *rows]
    if sheet:
        cells = [[float(c) if c[:1].isdigit() else c or None for c in line] for line in lines]
        pd.DataFrame(cells).to_excel("t.xlsx", header=False, index=False)
    else:
        write([",".join(line) for line in lines])
    guess = guess_mapping(Path("t.xlsx" if sheet else "t.csv"))
    assert guess.mapping["format"] == {"units_row": True}
    assert guess.mapping["actuation"] == [{"column": "p_set", "name": "p_set", "unit": "kPa"}]


def test_settings_above_the_names_are_no_rows(desk: Path) -> None:
    """Lines that give a setting by its name, some of them numbers, stand above the names of the columns."""
    settings = [
        "Setting;Value;",
        "Width (mm);6;",
        "Length (mm);33;",
        "Area (mm^2);18;",
        "Speed;450;",
        "Lab;ours;",
        ";;",
    ]
    path = write([*settings, "Time (s);p_set (kPa);F (N)", *(row.replace(",", ";") for row in ROWS)])
    how = sniff(path)
    assert (how.skip_rows, len(read_file(path, how).frame)) == (len(settings), N)
    assert guess_mapping(path).mapping["time"] == {"column": "Time (s)", "unit": "s"}


def test_names_that_come_again_begin_no_other_table(desk: Path) -> None:
    """Where each row begins with a word, what is below its names is one table, names in between or not."""
    rows = [f"hold {i},{row}" for i, row in enumerate(ROWS)]
    names = "what,t_s,p_set,F"
    path = write([names, *rows[:6], names, *rows[6:]])
    assert len(read_file(path, sniff(path)).frame) == N


def test_the_rows_that_are_wanted_end_before_a_second_table(desk: Path) -> None:
    """`rows:` reads the first of two tables with blanks between their cells, whatever follows."""
    path = write(["t p y", "0 1 2", "1 2 3", "2 3 4", "", "summary 3", "1 2"], "t.txt")
    table = read_file(path, Format(separator="whitespace", rows=3))
    assert table.frame["y"].tolist() == [2, 3, 4]
    with pytest.raises(LabrigError, match="line 6: has 2 cells where others have 3"):
        read_file(path, Format(separator="whitespace"))
