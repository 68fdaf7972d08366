"""A rig set up through the server: what is checked, what is written, and what is refused. No device is opened."""

import os
from typing import Any

import pytest

from labrig.rig import load_rig
from labrig.workbench import _rig_setup

ROW = {"min_kpa": "0", "max_kpa": "60", "slew_kpa_s": "100"}
FORM: dict[str, Any] = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", **ROW, "output": ""} for n in range(1, 5)],
    "pressure": {"kind": "openpneu", "port": "COM3"},
}


def row(**typed: str) -> dict[str, str]:
    """A chamber as it is typed."""
    return {"name": "c1", **ROW, **typed}


def simulated(**typed: str) -> dict[str, Any]:
    """A simulated controller over a membrane, or over what is typed."""
    return {"pressure": {"kind": "simulated"}, "simulated": {"body": "surface:membrane", **typed}}


def openpneu(**typed: str) -> dict[str, Any]:
    """A board at COM3."""
    return {"pressure": {"kind": "openpneu", "port": "COM3", **typed}}


def modbus(**typed: str) -> dict[str, Any]:
    """A regulator of Festo's, reached by the network."""
    return {
        "pressure": {"kind": "modbus", "by": "host", "host": "10.0.0.2", "map": "festo-vtem.yaml", **typed}
    }


KINDS: dict[str, dict[str, Any]] = {
    "openpneu": openpneu(build="full", boot_s="2,5"),
    "modbus tcp": modbus(serial="COM9"),
    "modbus rtu": modbus(by="serial", serial="COM5", baudrate="115200", map="festo-pgva.yaml")
    | {"chambers": [row(max_kpa="40")]},
    "simulated": simulated(seed="3"),
    "shell": simulated(body="shell:membrane4"),
    "vicon": {
        "mocap": {"kind": "vicon", "host": "10.0.0.3", "subject": "body", "up": "y"},
        "markers": "m1\nm2, 1, 2, 3",
    },
    "simulated mocap": {**simulated(), "mocap": {"kind": "simulated"}, "markers": "m01"},
    "artec": {"scanner": {"kind": "artec", "folder": "C:\\Scans", "unit": "cm"}},
    "simulated scanner": {**simulated(), **openpneu(), "scanner": {"kind": "simulated"}},
    "safety": {
        "safety": {"vents_alone": "a relay: it's off", "heartbeat_s": "3"},
        "follow": {"on_miss": "skip"},
    },
}


@pytest.fixture(autouse=True)
def _nothing_is_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    """A device that is connected fails the test."""

    def opened(*_: object) -> None:
        raise AssertionError("a device was opened")

    for place in ("_wired_pressure.WiredPressure", "_vicon.Vicon", "_artec.ArtecFolder"):
        monkeypatch.setattr(f"labrig_drivers.{place}.connect", opened)
    monkeypatch.setattr("serial.Serial.open", opened)


@pytest.fixture
def setup(ask):
    """Asks for one of the parts of setting up, with a form that is `FORM` but for what is given."""

    def asking(part: str, file: str = "rig.yaml", **changes: Any) -> tuple[int, Any]:
        return ask(f"/api/setup/{part}", {"form": {**FORM, **changes}, "file": file})

    return asking


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_device_is_written_as_it_was_typed(setup, bench, kind):
    """What is shown is what is saved, and `load_rig` reads the values that were typed."""
    status, shown = setup("check", **KINDS[kind])
    assert (status, shown["fault"], shown["wrong_file"]) == (200, None, "")
    assert not (bench.desk.folder / "rig.yaml").exists()
    status, saved = setup("save", **KINDS[kind])
    assert (status, saved["file"]) == (200, "rig.yaml")
    path = bench.desk.folder / "rig.yaml"
    assert path.read_text(encoding="utf-8") == shown["text"]
    config = load_rig(path)
    assert config.name == "bench"
    for role in ("pressure", "mocap", "scanner"):
        typed, device = KINDS[kind].get(role), config.devices[role]
        if typed is not None:
            assert device is not None
            assert device.kind == typed["kind"]
            left_out = {"modbus tcp": {"serial"}, "modbus rtu": {"host"}}.get(kind, set())
            for name in set(typed) - {"kind", "by"} - left_out:
                assert str(device.options[name]) == typed[name].replace(",", "."), name
            assert not left_out & set(device.options)


def test_sections_are_written_as_they_were_typed(setup, bench):
    """Markers with a resting place, what is simulated, what vents alone, and what a miss leads to."""
    for kind in ("vicon", "simulated", "safety"):
        assert setup("save", f"{kind}.yaml", **KINDS[kind])[0] == 200
    vicon, simulated, safety = (
        load_rig(bench.desk.folder / f"{kind}.yaml") for kind in ("vicon", "simulated", "safety")
    )
    assert (vicon.markers, vicon.rest_mm) == (("m1", "m2"), {"m2": (1.0, 2.0, 3.0)})
    assert simulated.simulated == {"surface": "membrane", "seed": 3}
    assert (safety.safety.vents_alone, safety.safety.heartbeat_s) == ("a relay: it's off", 3.0)
    assert safety.follow.on_miss == "skip"


WRONG: list[tuple[dict[str, Any], str, str]] = [
    ({"name": ""}, "name", "is missing"),
    ({"chambers": []}, "chambers", "a rig needs at least one chamber"),
    ({"chambers": [row(), row()]}, "chambers", "chamber c1 is named twice"),
    ({"chambers": [row(max_kpa="high")]}, "chambers.0.max_kpa", "should be a valid number, not 'high'"),
    ({"chambers": [row(max_kpa="nan")]}, "chambers.0.max_kpa", "should be a finite number, not nan"),
    ({"chambers": [row(max_kpa="9" * 30)]}, "chambers.0.max_kpa", "should be less than or equal to 1000"),
    ({"chambers": [row(min_kpa="5")]}, "chambers.0", "0 kPa (vented) must lie between min_kpa and max_kpa"),
    ({"chambers": [row(max_kpa="120")]}, "chambers.0", "c1 on channel 0 may not be set from 0 to 120 kPa"),
    ({"chambers": [row(name=n, output="5") for n in "ab"]}, "chambers", "outputs [5, 5] are not different"),
    ({"chambers": [row(output="x")]}, "chambers.0.output", "should be a valid integer, not 'x'"),
    (openpneu(port=""), "pressure.port", "is missing"),
    (openpneu(boot_s="31"), "pressure.boot_s", "should be less than or equal to 30, not 31"),
    (openpneu(dialect="other"), "pressure.dialect", "should be 'auto', 'published' or 'table'"),
    (modbus(host=""), "pressure", "give either host (Modbus TCP) or serial (RTU)"),
    (modbus(map="none.yaml"), "pressure.map", "none.yaml: no such register map"),
    (modbus(map="../m.yaml"), "pressure.map", "../m.yaml: lies outside"),
    (modbus(map="/etc/passwd"), "pressure.map", "/etc/passwd: lies outside"),
    (simulated(body="shell:../x.yaml"), "simulated.body", "../x.yaml: lies outside"),
    (simulated(body="shell:none.yaml"), "simulated.body", "cannot read the shell"),
    (simulated(body="surface:mannequin"), "chambers", "surface 'mannequin' has 9, the rig names 4"),
    (simulated(noise_mm="-1"), "simulated.noise_mm", "should be a number from 0 to 1000, not -1"),
    ({"mocap": {"kind": "vicon", "port": "70000"}}, "mocap.port", "should be less than or equal to 65535"),
    ({"mocap": {"kind": "vicon"}, "markers": "m1, m1"}, "markers", "marker m1 is named twice"),
    ({"scanner": {"kind": "artec", "unit": "mm"}}, "scanner.folder", "is missing"),
    ({"safety": {"heartbeat_s": "0"}}, "safety.heartbeat_s", "should be greater than or equal to 0.2, not 0"),
    ({"follow": {"tolerance_share": "1"}}, "follow.tolerance_share", "should be less than 1, not 1"),
]


@pytest.mark.parametrize(("changes", "at", "says"), WRONG)
def test_what_is_wrong_is_said_at_its_field_and_nothing_is_written(setup, bench, changes, at, says):
    """In one line, for every part of the form; who saves all the same is told it, too."""
    status, shown = setup("check", **changes)
    assert (status, shown["fault"]["at"]) == (200, at)
    assert says in shown["fault"]["says"]
    assert "\n" not in shown["fault"]["says"]
    status, said = setup("save", **changes)
    assert status == 400
    assert said["error"] == f"nothing was written: {at}: {shown['fault']['says']}"
    assert list(bench.desk.folder.glob("*.yaml*")) == []


@pytest.mark.parametrize(
    "name",
    [
        *("../x.yaml", "..\\x.yaml", "/tmp/x.yaml", "C:\\x.yaml", "sub/x.yaml", "x\0.yaml", "", ".yaml", ".x.yaml"),
        *("x.txt", "x", "x.yaml ", "x:y.yaml", "con.yaml", "COM3.yaml", "a" * 100 + ".yaml", "x\n.yaml", ".."),
    ],
)  # fmt: skip
def test_a_name_that_is_none_for_a_rig_file_is_refused(setup, bench, name):
    """Out of the folder, hidden, a device of Windows', no YAML: in a line beside the name, and nothing is written."""
    (bench.desk.folder / "sub").mkdir()
    shown = setup("check", name)[1]
    assert shown["fault"] is None
    status, said = setup("save", name)
    assert (status, said["error"]) == (400, shown["wrong_file"])
    files = [path for path in bench.desk.folder.parent.rglob("*") if path.is_file()]
    assert [path for path in files if ".workbench" not in path.parts] == []


def test_a_file_that_exists_is_never_written_over(setup, bench, monkeypatch):
    """Whatever it is; also one that somebody made since the name was looked at."""
    path = bench.desk.folder / "rig.yaml"
    path.write_text("mine")
    said = "rig.yaml: exists already; choose another name"
    assert setup("check")[1]["wrong_file"] == said
    assert setup("save") == (400, {"error": said})
    monkeypatch.setattr(_rig_setup, "_new_file", lambda desk, name: name)
    assert setup("save") == (400, {"error": said})
    assert path.read_text() == "mine"


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_a_link_out_of_the_folder_is_not_written_through(setup, bench):
    """Nor one that leads nowhere yet."""
    outside = bench.desk.folder.parent / "outside.yaml"
    (bench.desk.folder / "rig.yaml").symlink_to(outside)
    assert setup("save")[0] == 400
    (bench.desk.folder / "own.yaml").symlink_to(bench.desk.folder / "none.yaml")
    assert setup("save", "own.yaml")[0] == 400
    assert not outside.exists()
    assert not (bench.desk.folder / "none.yaml").exists()


def test_a_disk_that_is_full_leaves_nothing(setup, bench, monkeypatch):
    """Neither half a file nor its name; the line names the file."""

    def full(_number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    status, said = setup("save")
    assert (status, said["error"]) == (400, f"{bench.desk.folder / 'rig.yaml'}: No space left on device")
    assert [path.name for path in bench.desk.folder.iterdir() if path.name != ".workbench"] == []


def test_what_is_right_and_worth_a_look_is_said(setup, bench):
    """Chambers that share a target, a firmware that is declared, a folder that is not there yet; nothing of others'."""
    artec = {"kind": "artec", "unit": "mm"}
    assert setup("check")[1]["remarks"][0].startswith("c1 and c2 are one pair")
    full = {"kind": "openpneu", "port": "COM3", "build": "full"}
    (said,) = setup("check", pressure=full)[1]["remarks"]
    assert "only if your board's firmware does that" in said
    apart = [{"name": f"c{n}", **ROW, "output": str(2 * n)} for n in range(4)]
    assert setup("check", chambers=apart)[1]["remarks"] == []
    (said,) = setup("check", chambers=apart, scanner={**artec, "folder": "scans"})[1]["remarks"]
    assert said.startswith("there is no folder scans yet")
    (bench.desk.folder / "scans").mkdir()
    for folder in ("scans", "/nowhere/scans", "../scans"):
        assert setup("check", chambers=apart, scanner={**artec, "folder": folder})[1]["remarks"] == []


def test_what_can_be_chosen_is_offered(ask, bench, monkeypatch):
    """This computer's ports, labrig's register maps and those of the folder, shells, and a name that is free."""
    monkeypatch.setattr(_rig_setup, "serial_ports", lambda: [("COM7", "OpenPneu")])
    folder = bench.desk.folder
    (folder / "rig.yaml").write_text("name: x\n")
    (folder / "own-map.yaml").write_text("name: x\nkpa_per_count: 1\nsetpoint: {}\n")
    (folder / "own-shell.yaml").write_text("name: x\ncontrol_points: [9, 9]\nlayers: []\nchambers: []\n")
    offered = ask("/api/setup")[1]
    assert offered["ports"] == [["COM7", "OpenPneu"]]
    assert offered["maps"] == ["festo-pgva.yaml", "festo-vtem.yaml", "own-map.yaml"]
    bodies = dict(offered["bodies"])
    assert bodies["surface:membrane"].endswith("4 chambers")
    assert {"shell:own-shell.yaml", "shell:membrane4", ""} <= set(bodies)
    assert (offered["file"], offered["rigs"]) == ("rig-2.yaml", [])


@pytest.mark.parametrize(
    "body", [{}, {"form": []}, {"form": "x"}, {"form": {"chambers": {}}}, {"form": {**FORM, "name": 5}}]
)
def test_what_is_no_form_is_refused_in_one_line(ask, bench, body):  # fmt: skip
    """Whatever else is sent."""
    for part in ("check", "save"):
        status, said = ask(f"/api/setup/{part}", {"file": "rig.yaml", **body})
        assert status == 400
        assert "\n" not in said["error"]
    assert list(bench.desk.folder.glob("*.yaml")) == []
