"""Bad tables and mappings: one line that says what, where and what to do, exit code 2, and nothing left behind."""

from collections.abc import Callable
from pathlib import Path

import pytest

MAP = """\
table: t.csv
time: {column: t, unit: s}
capture: {column: capture}
actuation:
  - {column: p1, name: c1, unit: kPa}
observables:
  - {column: F, name: force, unit: N}
"""
TABLE = """\
t,capture,p1,F
0,a,10,1.0
1,a,10,1.1
2,b,20,2.0
3,b,20,2.1
"""
MORE = "{column: p1, name: c1, unit: kPa}"

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a good mapping and a good table, as the current one."""
    monkeypatch.chdir(tmp_path)
    Path("map.yaml").write_text(MAP)
    Path("t.csv").write_text(TABLE)
    return tmp_path


def swap(name: str, old: str, new: str) -> None:
    """Change one thing in a file."""
    text = Path(name).read_text()
    assert old in text
    Path(name).write_text(text.replace(old, new, 1))


def refuse(labrig: Run, complaint: str, output: str = "run") -> None:
    """The import ends with this line, exit code 2, and no new file."""
    before = sorted(Path().iterdir())
    assert labrig("import", "--mapping", "map.yaml", "-o", output) == (2, "", f"labrig: {complaint}\n")
    assert sorted(Path().iterdir()) == before


def test_the_good_ones_pass(desk: Path, labrig: Run) -> None:
    """What the other tests spoil is accepted as it is."""
    code, out, err = labrig("import", "--mapping", "map.yaml", "-o", "run")
    assert (code, out, err) == (0, "run: 2 captures, 1 actuated, 1 observable, 1 session\n", "")


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (
            "column: F",
            "column: G",
            "t.csv: has no column 'G' (observable force); it has t, capture, p1, F",
        ),
        ("column: t,", "column: T,", "t.csv: has no column 'T' (time); it has t, capture, p1, F"),
        ("column: p1", "column: p2", "t.csv: has no column 'p2' (actuation c1); it has t, capture, p1, F"),
        (
            "unit: N",
            "unit: newtonn",
            "map.yaml: observables 'force': there is no unit 'newtonn'; use one such as kPa, bar, N, mm, s, degC or 1",
        ),
        (
            "unit: kPa",
            "unit: kpag",
            "map.yaml: actuation 'c1': there is no unit 'kpag'; write kPa",
        ),
        ("unit: s", "unit: kg", "map.yaml: time: unit 'kg' can't be converted to s"),
        ("table: t.csv", "table: u.csv", "u.csv: there is no such table"),
        (
            "table: t.csv",
            "tabel: t.csv",
            "map.yaml, line 1: tabel: there is no such field; did you mean table?",
        ),
        (
            "table: t.csv\n",
            "",
            "map.yaml: table: name the file, or give it on the command line",
        ),
        (
            "capture: {column: capture}",
            "capture: {}",
            "map.yaml, line 3: capture: give either 'column: NAME', 'per: file' or 'per: segment'",
        ),
        (
            "{column: p1, name: c1, unit: kPa}",
            "{name: c1, unit: kPa}",
            "map.yaml: actuation 'c1' has neither 'column:' nor 'value:', and t.csv says nothing of it",
        ),
        (
            MORE,
            f"{MORE}\n  - {MORE}",
            "map.yaml: actuation: two entries have the same name",
        ),
        (
            "- {column: F, name: force, unit: N}",
            "- {column: F, name: force, unit: N}\n  - {column: t, name: force, unit: N}",
            "map.yaml: observables: two entries have the same name",
        ),
        (
            "observables:",
            "measured: [{column: p1, name: c9, unit: kPa}]\nobservables:",
            "map.yaml: measured: 'c9' is no name under 'actuation:'",
        ),
        (
            "capture: {column: capture}",
            "capture: {column: capture}\nbetween_sessions: open",
            "map.yaml, line 4: between_sessions: should be 'held', 'vented' or 'unknown', not 'open'",
        ),
        (
            "capture: {column: capture}",
            "capture: {column: capture}\nformat: {every: 0}",
            "map.yaml, line 4: format: every: should be greater than 0, not 0",
        ),
    ],
)
def test_a_wrong_mapping(desk: Path, labrig: Run, old: str, new: str, complaint: str) -> None:
    """The complaint names the file, the field and, where there is one, the choice."""
    swap("map.yaml", old, new)
    refuse(labrig, complaint)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        (
            "1,a,10,1.1",
            "1,a,,1.1",
            "t.csv, line 3: column 'p1' (actuation c1) is empty or NaN; every row needs it",
        ),
        (
            "1,a,10,1.1",
            "1,a,NaN,1.1",
            "t.csv, line 3: column 'p1' (actuation c1) is empty or NaN; every row needs it",
        ),
        (
            "2,b,20,2.0",
            ",b,20,2.0",
            "t.csv, line 4: column 't' (time) is empty or NaN; every row needs it",
        ),
        (
            "2,b,20,2.0",
            "2,b,20,two",
            "t.csv, line 4: column 'F' (observable force) holds 'two', not a number",
        ),
        (
            "2,b,20,2.0",
            "2,b,inf,2.0",
            "t.csv, line 4: column 'p1' (actuation c1) holds inf, not a number",
        ),
        (
            "1,a,10,1.1",
            "-1,a,10,1.1",
            "t.csv, line 3: time goes backward within session 't'; if the rows were shuffled, sort them by time: "
            "'sort: true' under 'time:' does",
        ),
        (
            "3,b,20,2.1",
            "3,a,20,2.1",
            "t.csv, line 5: capture 'a' appears again after another one; rows of one capture must stand together",
        ),
        (
            "1,a,10,1.1",
            "1,a,15,1.1",
            "t.csv, line 2: actuation 'c1' changes within one capture; "
            "leave 'capture:' out to take every row as one, or write 'capture: {per: segment}' to have the holds found",
        ),
        (TABLE, "t,capture,p1,F\n", "t.csv: has no rows"),
        (TABLE, "", "t.csv: is empty"),
        (
            TABLE,
            "t,capture,p1,F\n0,a,10,\n1,a,10,\n",
            "t.csv: no row has an observable that is a number",
        ),
    ],
)
def test_a_wrong_table(desk: Path, labrig: Run, old: str, new: str, complaint: str) -> None:
    """The complaint names the file, the line as an editor counts it, the column and what it is for."""
    swap("t.csv", old, new)
    refuse(labrig, complaint)


def test_a_mapping_that_is_no_yaml(desk: Path, labrig: Run) -> None:
    """A syntax error is given with its line."""
    swap("map.yaml", "time: {column: t, unit: s}", "time: {column: t, unit: s")
    refuse(labrig, "map.yaml, line 3: is not YAML (expected ',' or '}', but got ':')")


@pytest.mark.parametrize("text", ["", "- one\n- two\n", "just words\n"])
def test_a_mapping_that_is_no_mapping(desk: Path, labrig: Run, text: str) -> None:
    """A list, a text or nothing at all is refused alike."""
    Path("map.yaml").write_text(text)
    refuse(labrig, "map.yaml is not a mapping: it should begin with `table: ...`")


def test_a_mapping_that_is_not_there(desk: Path, labrig: Run) -> None:
    """The reason is the system's own."""
    Path("map.yaml").unlink()
    refuse(labrig, "cannot read the mapping map.yaml: No such file or directory")


def test_a_mapping_without_actuation(desk: Path, labrig: Run) -> None:
    """Something must be said of what was commanded, even that it was constant."""
    swap("map.yaml", "actuation:\n  - {column: p1, name: c1, unit: kPa}\n", "")
    refuse(
        labrig,
        "map.yaml: actuation: name at least one commanded value (a constant one has 'value:')",
    )


def test_a_table_without_observables(desk: Path, labrig: Run) -> None:
    """Only a C3D file says by itself what was observed."""
    swap("map.yaml", "observables:\n  - {column: F, name: force, unit: N}\n", "")
    refuse(labrig, "t.csv: the mapping names no observables")


def test_an_output_that_exists(desk: Path, labrig: Run) -> None:
    """Nothing is ever overwritten: what is there stays as it is, and nobody is told to remove it."""
    Path("run").mkdir()
    Path("run/mine.txt").write_text("mine")
    refuse(labrig, "run exists already; choose another name")
    assert Path("run/mine.txt").read_text() == "mine"


def test_a_table_that_is_no_parquet(desk: Path, labrig: Run) -> None:
    """A file that is not what its name says is named; the reason is the reader's."""
    Path("t.parquet").write_text("no table")
    swap("map.yaml", "table: t.csv", "table: t.parquet")
    code, out, err = labrig("import", "--mapping", "map.yaml", "-o", "run")
    assert (code, out) == (2, "")
    assert err.startswith("labrig: t.parquet: can't be read as Parquet or Feather (")
    assert err.count("\n") == 1
    assert not Path("run").exists()


def test_a_file_that_is_no_c3d(desk: Path, labrig: Run) -> None:
    """A C3D file that cannot be read is named."""
    Path("t.c3d").write_bytes(b"no markers here")
    swap("map.yaml", "table: t.csv", "table: t.c3d")
    code, out, err = labrig("import", "--mapping", "map.yaml", "-o", "run")
    assert (code, out) == (2, "")
    assert err.startswith("labrig: t.c3d: can't be read as C3D (")
    assert err.count("\n") == 1
    assert not Path("run").exists()


def test_an_event_that_forgets_a_chamber(desk: Path, labrig: Run) -> None:
    """Every event says what every chamber does."""
    swap("map.yaml", "table: t.csv", "table: [{file: t.csv, events: [{time_s: 1, actuation: {}}]}]")
    refuse(labrig, "map.yaml: t.csv: an event does not say 'c1'")


def test_tables_on_the_command_line(desk: Path, labrig: Run) -> None:
    """A table that is given takes the place of the mapping's; one that does not exist is named."""
    code, out, err = labrig("import", "--mapping", "map.yaml", "-o", "run", "other.csv")
    assert (code, out) == (2, "")
    assert err == f"labrig: {desk.resolve() / 'other.csv'}: there is no such table\n"
    Path("other.csv").write_text(TABLE + "4,c,30,3.0\n")
    code, out, err = labrig("import", "--mapping", "map.yaml", "-o", "run", "other.csv")
    assert (code, err) == (0, "")
    assert out == "run: 3 captures, 1 actuated, 1 observable, 1 session\n"
