"""Files dropped on the page: what is made of them."""

import os
import socket
import time
from urllib.parse import quote

import pytest
import yaml

from tests.shapes import NEAR, write_target
from tests.waiting import wait_for

CSV = "t,pressure_1 [kPa],pressure_2 [kPa],force [N]\n" + "".join(
    f"{10 * i},{20 * (i % 3)},{15 * (i % 4)},{0.1 + 0.5 * (i % 3) + 0.2 * (i % 4):.1f}\n" for i in range(24)
)


@pytest.fixture
def drop(ask):
    """Drops a file; gives the status and what is said of it."""
    return lambda name, content: ask(f"/api/drop?name={quote(name)}", content)


@pytest.fixture
def runs(ask):
    """The runs that the page lists, with their captures."""

    def listed():
        said = ask("/api/runs")[1]
        run, captures = said["columns"].index("run"), said["columns"].index("captures")
        return {row[run]: row[captures] for row in said["rows"]}

    return listed


def test_a_dropped_table_is_guessed_and_becomes_a_run(drop, ask, bench, runs):
    """A table that nobody described comes back with a mapping, its first rows and remarks, and is a run as it is."""
    status, found = drop("press.csv", CSV.encode())
    assert status == 200
    mapping = yaml.safe_load(found["mapping"])
    assert [a["column"] for a in mapping["actuation"]] == ["pressure_1 [kPa]", "pressure_2 [kPa]"]
    assert [o["unit"] for o in mapping["observables"]] == ["N"]
    assert found["rows"][0] == CSV.partition("\n")[0].split(",")
    assert found["rows"][1] == CSV.splitlines()[1].split(",")
    assert len(found["rows"]) == 9
    assert any("time" in remark for remark in found["remarks"])
    begun = ask("/api/import", {k: found[k] for k in ("table", "mapping", "name")})[1]
    end = time.monotonic() + 60
    while next(j for j in bench.desk.jobs.all() if j.facts()["id"] == begun["job"]["id"]).state == "running":
        assert time.monotonic() < end
        time.sleep(0.05)
    assert runs() == {"press": 24}


def test_a_workbook_is_read_as_well(drop, tmp_path):
    """What labrig import reads can be dropped: an Excel sheet, too."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for line in CSV.splitlines():
        book.active.append([float(x) if x[0].isdigit() else x for x in line.split(",")])
    book.save(tmp_path / "press.xlsx")
    status, found = drop("press.xlsx", (tmp_path / "press.xlsx").read_bytes())
    assert (status, found["rows"][0]) == (200, CSV.partition("\n")[0].split(","))


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("picture.png", bytes(range(256)) * 8),
        ("other.mcap", b"\x89MCAP0\r\n nothing"),
        ("empty.csv", b""),
        ("inputs.csv", b"t [s],pressure [kPa]\n0,1\n1,2\n2,3\n"),
        ("..", b"1"),
    ],
)
def test_what_is_no_campaign_is_refused_in_one_line(drop, bench, name, content):
    """A file that no run can be made of is refused by its own name, and is not kept."""
    status, said = drop(name, content)
    assert status == 400
    assert said["error"].count("\n") == 0
    assert str(bench.desk.folder) not in said["error"]
    assert not [p for p in bench.desk.folder.rglob("*") if p.name == name]


def test_a_log_of_labrigs_needs_no_mapping(drop, ask, make_run, bench, runs):
    """The log of a run, dropped, is a run again with as many captures."""
    run = bench.desk.folder / make_run(captures=10)
    status, found = drop("again.mcap", next(run.glob("*.mcap")).read_bytes())
    assert (status, found["log"]) == (200, True)
    assert "10 captures" in found["remarks"][0]
    assert ask("/api/import", {"table": found["table"], "name": "again"})[1] == {"run": "again", "job": None}
    assert runs() == {"run": 10, "again": 10}


def test_a_dropped_model_is_a_model_of_the_folder(drop, ask, make_run, bench):
    """A model file is no table: it is kept under a free name, says what it lacks, and is offered once that is there."""
    run = make_run(captures=10)
    text = b"base: {kind: python, file: base.py, function: predict}\neffects: []\n"
    before = set(ask(f"/api/run?run={run}")[1]["models"])
    for name in ("mine.yaml", "mine-2.yaml"):
        status, found = drop("mine.yml", text)
        assert (status, found["model"]) == (200, name)
        assert found["remarks"] == [f"it needs base.py: put that into {bench.desk.folder}"]
    assert (bench.desk.folder / "mine.yaml").read_bytes() == text
    given = ask(f"/api/run?run={run}")[1]
    assert (set(given["models"]), set(given["unread"])) == (before, {"mine.yaml", "mine-2.yaml"})
    (bench.desk.folder / "base.py").touch()
    assert set(ask(f"/api/run?run={run}")[1]["models"]) == before | {"mine.yaml", "mine-2.yaml"}
    assert drop("line.yaml", b"base: {kind: static, degree: 1}\neffects: []\n")[1]["remarks"] == []


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"name: rig\n", "other.yaml: neither a table nor a model file (a model file has a line 'base:')"),
        (
            b"name: rig\nchambers: [{name: c1}]\npressure: {kind: simulated}\n",
            "other.yaml: is a rig file, no measurements: put it into the workbench's folder, and open the workbench "
            "for it: labrig workbench . --rig other.yaml",
        ),
        (b"base: {kind: none}\n", "other.yaml, line 1: base: kind: there is no 'none'"),
        (b"base: {kind: [\n", "other.yaml"),
    ],
)
def test_other_yaml_is_refused(drop, bench, content, said):
    """YAML that is no model says what is wrong with it, and is not kept."""
    status, answer = drop("other.yaml", content)
    assert status == 400
    assert answer["error"].startswith(said)
    assert not [p for p in bench.desk.folder.rglob("*") if p.name == "other.yaml"]


def test_a_dropped_shape_is_a_target(drop, bench, tmp_path):
    """It is no campaign: it is kept where Shape finds it; one that cannot be read is refused, and not kept."""
    shape = write_target(tmp_path / "body.ply", NEAR).read_bytes()
    status, answer = drop("body.ply", shape)
    assert (status, answer["target"]) == (200, "targets/body.ply")
    assert (bench.desk.folder / "targets" / "body.ply").read_bytes() == shape
    status, answer = drop("half.ply", b"ply\nformat ascii 1.0\n")
    assert (status, answer["error"]) == (400, "half.ply has no complete PLY header")
    assert not list(bench.desk.folder.rglob("half.ply"))


def test_an_empty_name_is_told_as_one(drop, ask):
    """A complaint begins with what it is about, not with a colon."""
    table = drop("any.csv", CSV.encode())[1]["table"]
    said = ask("/api/import", {"table": table, "mapping": "", "name": ""})[1]["error"]
    assert said == "the name of the run is empty: give the run a plain name, without a folder"


def test_what_was_dropped_can_be_put_away(drop, ask, bench):
    """Nothing of it is left then; what was not dropped stays, whoever asks."""
    table = drop("any.csv", CSV.encode())[1]["table"]
    (bench.desk.folder / "a" / "b").mkdir(parents=True)
    (bench.desk.folder / "a" / "b" / "own.csv").touch()
    for other in ("a/b/own.csv", ".workbench/dropped", ".workbench/jobs", "..", ""):
        status, said = ask("/api/put-away", {"table": other})
        assert (status, "outside" in said["error"] or "was not dropped here" in said["error"]) == (400, True)
    assert (bench.desk.folder / table).exists()
    assert (bench.desk.folder / "a" / "b" / "own.csv").exists()
    assert ask("/api/put-away", {"table": table}) == (200, {})
    assert not list(bench.desk.folder.glob(".workbench/dropped/*"))


def test_what_was_dropped_long_ago_is_tidied_away(drop, bench):
    """What nobody made a run of within a week goes with the next drop; what is newer stays."""
    tables = [bench.desk.folder / drop(f"{name}.csv", CSV.encode())[1]["table"] for name in "ab"]
    ago = time.time() - 8 * 24 * 3600
    os.utime(tables[0].parent, (ago, ago))
    third = bench.desk.folder / drop("c.csv", CSV.encode())[1]["table"]
    assert [path.exists() for path in (*tables, third)] == [False, True, True]


def test_an_upload_that_is_broken_off_leaves_nothing(ask, bench, capsys):
    """A page that is closed in the middle is no error for the terminal, and no half a file."""
    head = f"POST /api/drop?name=half.csv HTTP/1.1\r\nHost: 127.0.0.1:{bench.port}\r\n"
    head += f"x-labrig-token: {bench.desk.token}\r\ncontent-length: 1000000\r\n\r\n"
    with socket.create_connection(("127.0.0.1", bench.port)) as connection:
        connection.sendall(head.encode() + b"t,p\n" * 1000)
        wait_for(lambda: list(bench.desk.folder.glob(".workbench/dropped/*/half.csv.part")))
    wait_for(lambda: not list(bench.desk.folder.glob(".workbench/dropped/*")))
    assert ask("/api/runs")[0] == 200
    assert capsys.readouterr().err == ""
