"""The rig files of the folder: listed with what opens them, and begun from where the form holds all of them."""

import json

import pytest
import yaml

from labrig.rig import load_rig

TWINS = {
    "name": "twins",
    "chambers": [{"name": "c1", "min_kpa": 0.0, "max_kpa": 60.0, "slew_kpa_s": 100.0}],
    "markers": ["m01", "m02"],
    "rest_mm": {"m01": [0.5, -1.25, 3.0], "m02": [1.0, 2.0, 3.0]},
    "pressure": {
        "kind": "openpneu",
        "port": "socket://127.0.0.1:4001",
        "dialect": "auto",
        "build": "full",
        "boot_s": 0.2,
    },
    "mocap": {"kind": "vicon", "host": "127.0.0.1", "port": 801, "subject": "mannequin", "up": "z"},
    "scanner": {"kind": "artec", "folder": "scans", "unit": "mm"},
}


def test_a_rig_file_of_the_folder_is_begun_from(ask, bench):
    """What `labrig rig simulate` wrote fills the form; its paths lead to the same files from the new place."""
    sim = bench.desk.folder / "sim"
    sim.mkdir()
    (sim / "rig.yaml").write_text("# by the command\n" + yaml.safe_dump(TWINS), encoding="utf-8")
    (listed,) = ask("/api/setup")[1]["rigs"]
    assert (listed["file"], listed["why"]) == ("sim/rig.yaml", "")
    assert listed["open"] == "labrig workbench . --rig sim/rig.yaml"
    status, begun = ask("/api/setup/begin", {"file": "sim/rig.yaml"})
    assert status == 200
    assert begun["remarks"] == ["the comments in sim/rig.yaml stay there: the new file has none of them"]
    assert ask("/api/setup/save", {"form": begun["form"], "file": "own.yaml"})[0] == 200
    before, after = load_rig(sim / "rig.yaml").to_dict(), load_rig(bench.desk.folder / "own.yaml").to_dict()
    assert after.pop("scanner") == {"kind": "artec", "folder": "sim/scans", "unit": "mm"}
    defaults = {"dialect": "auto", "host": "127.0.0.1", "port": 801, "up": "z"}
    del before["scanner"]
    for role in ("pressure", "mocap"):
        after[role] = {
            **{name: value for name, value in defaults.items() if name in before[role]},
            **after[role],
        }
    assert after == before
    assert ask("/api/setup")[1]["rigs"][0] == {
        "file": "own.yaml",
        "why": "",
        "look": "labrig rig check own.yaml --still",
        "open": "labrig workbench . --rig own.yaml",
    }


def test_a_map_and_a_shell_beside_the_file_are_found_from_the_new_place(ask, bench):
    """Those that labrig brings keep their names, and a path that is absolute stays."""
    sim = bench.desk.folder / "sim"
    sim.mkdir()
    shell = {"pressure": {"kind": "simulated"}, "simulated": {"shell": "own.yaml"}}
    for name, change, moved in (
        ("map", {"pressure": {"kind": "modbus", "host": "a", "map": "own.yaml"}}, "sim/own.yaml"),
        ("map", {"pressure": {"kind": "modbus", "host": "a", "map": "festo-vtem.yaml"}}, "festo-vtem.yaml"),
        ("folder", {"scanner": {"kind": "artec", "folder": "D:\\Scans", "unit": "mm"}}, "D:\\Scans"),
    ):
        (sim / "rig.yaml").write_text(yaml.safe_dump({**TWINS, **change}), encoding="utf-8")
        form = ask("/api/setup/begin", {"file": "sim/rig.yaml"})[1]["form"]
        assert form["scanner" if name == "folder" else "pressure"][name] == moved
    (sim / "rig.yaml").write_text(yaml.safe_dump({**TWINS, **shell}), encoding="utf-8")
    assert "cannot read the shell" in ask("/api/setup/begin", {"file": "sim/rig.yaml"})[1]["error"]


NOT_HELD = [
    ({"pressure": {"kind": "python", "file": "x.py"}}, "the form has no field for pressure of kind 'python'"),
    ({"mocap": {"kind": "vicon", "rename": {"m01": "A"}}}, "the form has no field for mocap.rename"),
    ({"markers": ["m1, 1, 2, 3"], "rest_mm": None}, "the form would lose something of it"),
    ({"chambers": [{"name": "c1"}]}, "line 2: chambers: c1: max_kpa: is missing"),
    (
        {"pressure": {"kind": "modbus", "host": "a", "map": "../../m.yaml"}},
        "lies outside the workbench's folder",
    ),
]


@pytest.mark.parametrize(("change", "why"), NOT_HELD)
def test_a_file_of_which_something_would_be_lost_is_not_begun_from(ask, bench, change, why):
    """The list says why, and a page that asks all the same is told it."""
    (bench.desk.folder / "old.yaml").write_text(yaml.safe_dump({**TWINS, **change}), encoding="utf-8")
    (listed,) = ask("/api/setup")[1]["rigs"]
    assert why in listed["why"]
    status, said = ask("/api/setup/begin", {"file": "old.yaml"})
    assert status == 400
    assert why in said["error"]


@pytest.mark.parametrize("name", ["", "../rig.yaml", "/etc/passwd", "none.yaml", "run", "x\0.yaml"])
def test_only_a_rig_file_of_the_folder_is_begun_from(ask, bench, name):
    """Nothing else is read for a page."""
    (bench.desk.folder.parent / "rig.yaml").write_text(yaml.safe_dump(TWINS), encoding="utf-8")
    status, said = ask("/api/setup/begin", {"file": name})
    assert (status, "is no rig file of" in said["error"]) == (400, True)


def test_files_that_are_odd_hold_nothing_up(ask, bench):
    """Aliases of aliases, a file that is huge, no YAML at all, no text: each is listed with one line, or not at all."""
    folder = bench.desk.folder
    bomb = "x: &a [l, l, l, l, l, l, l, l, l]\n" + "".join(
        f"x{k}: &{chr(98 + k)} [{', '.join([f'*{chr(97 + k)}'] * 9)}]\n" for k in range(12)
    )
    (folder / "bomb.yaml").write_text(f"{bomb}chambers: *m\npressure: {{kind: *m}}\n")
    (folder / "deep.yaml").write_text(f"chambers: 1\npressure: {'[' * 3000}\n")
    (folder / "huge.yaml").write_text("chambers: []\npressure: {}\n" + "#" * 300_000)
    (folder / "odd.yaml").write_text("chambers: [\npressure: {")
    (folder / "bytes.yaml").write_bytes(b"chambers:\npressure:\n\xff\xfe")
    (folder / "folder.yaml").mkdir()
    listed = {each["file"]: each["why"] for each in ask("/api/setup")[1]["rigs"]}
    assert set(listed) == {"bomb.yaml", "bytes.yaml", "deep.yaml", "huge.yaml", "odd.yaml"}
    assert all(why and "\n" not in why for why in listed.values())
    assert len(json.dumps(listed)) < 2000
