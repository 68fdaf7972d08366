"""rig.yaml is checked before anything is connected, and every mistake is one clear line."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from labrig import LabrigError
from labrig.rig import connect, load_rig, parse_rig
from labrig_drivers import DeviceError, Identity, SimulatedClock

GOOD: dict[str, Any] = {
    "name": "small",
    "chambers": [
        {"name": "c1", "max_kpa": 60},
        {"name": "c2", "min_kpa": -20, "max_kpa": 50, "slew_kpa_s": 10},
    ],
    "markers": ["m1"],
    "rest_mm": {"m1": [1, 2, 3]},
    "pressure": {"kind": "openpneu", "port": "COM3"},
    "mocap": {"kind": "vicon", "host": "127.0.0.1"},
}


def test_a_rig_is_read_with_its_defaults(tmp_path: Path) -> None:
    """Limits are kPa, slew has a default, device options are kept as they stand."""
    path = tmp_path / "rig.yaml"
    path.write_text(yaml.safe_dump(GOOD))
    config = load_rig(path)
    assert [channel.name for channel in config.channels] == ["c1", "c2"]
    assert [(c.min_kpa, c.max_kpa, c.slew_kpa_s) for c in config.channels] == [(0, 60, 100), (-20, 50, 10)]
    assert config.pressure.options == {"port": "COM3"}
    assert config.folder == tmp_path
    assert config.scanner is None
    assert parse_rig(config.to_dict(), "again", tmp_path) == config


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": ""}, ", line 13: name: String should have at least 1 character"),
        ({"chambers": []}, ": a rig needs at least one chamber"),
        ({"chambers": [{"name": "c1"}]}, ", line 2: chambers: c1: max_kpa: is missing"),
        (
            {"chambers": [{"name": "c1", "min_kpa": 5, "max_kpa": 60}]},
            ", line 2: chambers: c1: 0 kPa (vented) must lie between min_kpa and max_kpa",
        ),
        ({"chambers": [{"name": "c1", "max_kpa": 6}] * 2}, ": chamber c1 is named twice"),
        (
            {"safety": {"stale_pressure_s": float("inf")}},
            ", line 23: safety: stale_pressure_s: should be a finite number, not inf",
        ),
        (
            {"mocap": {"kind": "vicon", "lost_after_s": float("nan")}},
            ", line 12: mocap: lost_after_s: should be a finite number, not nan",
        ),
        (
            {"safety": {"heartbeat_s": 500}},
            ", line 23: safety: heartbeat_s: should be less than or equal to 60, not 500; it is in seconds",
        ),
        (
            {"scanner": {"kind": "artec", "folder": "scans", "unit": "mm", "size_mm": [0, 500]}},
            ", line 25: scanner: size_mm: should be the least and the most mm across, not 0 and 500",
        ),
        ({"markers": ["m1", "m1"]}, ": marker m1 is named twice"),
        ({"mocap": None}, ": markers are named but there is no mocap device"),
        ({"presure": {}}, ", line 17: presure: there is no such field; did you mean pressure?"),
        (
            {"pressure": {"kind": "simulated"}},
            ": a device is simulated, so a section `simulated` is needed (seed, noise_mm, ...)",
        ),
    ],
)
def test_a_mistake_is_named_with_its_place(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    """File, line, field, and what is wrong with it."""
    path = tmp_path / "rig.yaml"
    path.write_text(yaml.safe_dump({**GOOD, **change}))
    with pytest.raises(LabrigError) as caught:
        load_rig(path)
    assert str(caught.value) == f"{path}{message}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- a\n- b\n", "{path} is not a rig: it should begin with `name: ...`"),
        ("name: [", "{path}, line 1: is not YAML (expected the node content, but found '<stream end>')"),
    ],
)
def test_what_is_no_rig_is_refused(tmp_path: Path, text: str, message: str) -> None:
    """Other YAML and no YAML are told apart."""
    path = tmp_path / "rig.yaml"
    path.write_text(text)
    with pytest.raises(LabrigError) as caught:
        load_rig(path)
    assert str(caught.value).startswith(message.format(path=path))


@pytest.mark.parametrize(
    ("change", "line", "said"),
    [
        ({"safety": {"vented_kpa": 100.0}}, ", line 23", "100 kPa counts as vented, and c1 may be at 60 kPa"),
        (
            {"chambers": [{"name": "skin", "max_kpa": 2}]},
            "",
            "3 kPa counts as vented, and skin may be at 2 kPa",
        ),
        (
            {"chambers": [{"name": "suction", "min_kpa": -3, "max_kpa": 0}]},
            "",
            "3 kPa counts as vented, and suction may be at 3 kPa",
        ),
    ],
)
def test_a_full_chamber_never_counts_as_vented(
    tmp_path: Path, change: dict[str, Any], line: str, said: str
) -> None:
    """What is read as vented is less than what a chamber may hold, of low pressures too; else nothing is connected."""
    path = tmp_path / "rig.yaml"
    path.write_text(yaml.safe_dump({**GOOD, **change}))
    with pytest.raises(LabrigError) as caught:
        load_rig(path)
    assert str(caught.value).startswith(
        f"{path}{line}: safety: vented_kpa: {said}: a full chamber would be called "
    )


def test_an_absent_file_is_named(tmp_path: Path) -> None:
    """The path is in the message."""
    with pytest.raises(LabrigError) as caught:
        load_rig(tmp_path / "none.yaml")
    assert str(caught.value) == f"cannot read the rig {tmp_path / 'none.yaml'}: No such file or directory"


@pytest.mark.parametrize(
    ("pressure", "message"),
    [
        (
            {"kind": "steam"},
            "rig small: pressure: no kind 'steam'; there are openpneu, modbus, simulated, python",
        ),
        (
            {"kind": "python"},
            "rig small: pressure: kind python needs `file` (a .py file) and `class`",
        ),
        (
            {"kind": "python", "file": "none.py", "class": "X"},
            "rig small: pressure: there is no file {folder}none.py",
        ),
        (
            {"kind": "python", "file": "mine.py", "class": "Absent"},
            "rig small: pressure: {folder}mine.py has no class Absent",
        ),
        (
            {"kind": "python", "file": "mine.py", "class": "Mine", "speed": 3},
            "rig small: pressure (python): got an unexpected keyword argument 'speed'",
        ),
    ],
)
def test_a_device_that_cannot_be_made_is_explained(
    tmp_path: Path, pressure: dict[str, Any], message: str
) -> None:
    """Unknown kinds, and every way in which a user's own device file can be wrong."""
    (tmp_path / "mine.py").write_text(MINE)
    config = parse_rig({**GOOD, "pressure": pressure}, "rig.yaml", tmp_path)
    with pytest.raises(LabrigError) as caught:
        connect(config, SimulatedClock())
    assert str(caught.value) == message.format(folder=f"{tmp_path}/")


MINE = """
import numpy as np
from labrig_drivers import DeviceError, Identity, PressureSample, VentReport

LOG = []

class Mine:
    def __init__(self, name, clock, channels, answers=True):
        self.name, self.clock, self.channels, self.answers = name, clock, channels, answers
    def connect(self):
        if not self.answers:
            raise DeviceError(f"{self.name}: no answer")
        LOG.append(f"{self.name} opened")
    def identify(self):
        return Identity(self.name, "mine", "made at home")
    def set(self, pressure_kpa): ...
    def samples(self): return [PressureSample(self.clock.now_s(), np.zeros(2))]
    def vent(self, timeout_s=10.0):
        LOG.append(f"{self.name} vented")
        return VentReport(np.zeros(2), 0.0)
    def frames(self): return []
    def close(self): LOG.append(f"{self.name} closed")

class Silent(Mine):
    def __init__(self, name, clock, marker_names):
        super().__init__(name, clock, (), answers=False)
"""


def _mine(folder: Path, **changes: Any) -> Any:
    (folder / "mine.py").write_text(MINE)
    mine = {"kind": "python", "file": "mine.py", "class": "Mine"}
    return parse_rig({**GOOD, "pressure": mine, "markers": [], "mocap": None, **changes}, "rig.yaml", folder)


def test_a_users_own_device_is_connected_and_vented_before_it_is_closed(tmp_path: Path) -> None:
    """A class in a file beside rig.yaml is a device; leaving the rig vents it, then closes it."""
    with connect(_mine(tmp_path), SimulatedClock()) as rig:
        assert rig.identity == {"pressure": Identity("pressure", "mine", "made at home")}
        log = type(rig.pressure._device.device).vent.__globals__["LOG"]  # type: ignore[attr-defined]
        assert log == ["pressure opened"]
    assert log == ["pressure opened", "pressure vented", "pressure closed"]


def test_what_was_opened_is_closed_when_another_device_fails(tmp_path: Path) -> None:
    """No link stays open behind an error."""
    silent = {"kind": "python", "file": "mine.py", "class": "Silent"}
    with pytest.raises(DeviceError) as caught:
        connect(_mine(tmp_path, mocap=silent), SimulatedClock())
    assert str(caught.value) == "mocap: no answer"


def test_rest_positions_come_from_the_file(tmp_path: Path) -> None:
    """Markers that rest_mm does not name are unknown, not zero."""
    silent = {"kind": "python", "file": "mine.py", "class": "Mine"}
    config = _mine(tmp_path, markers=["m1", "m2"], mocap=silent)
    rig = connect(config, SimulatedClock())
    np.testing.assert_array_equal(rig.rest_mm, [[1, 2, 3], [np.nan] * 3])
    rig.close()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "pressure: {kind: openpneu, prot: COM3}",
            "line 4: pressure: prot: there is no such field; did you mean port",
        ),
        ("pressure: {kind: openpneu}", "line 4: pressure: port: is missing"),
        (
            "pressure: {kind: simulated}\nsimulated: {surface: mannequin, noise: 1}",
            "simulated: there is no such field as noise; did you mean noise_mm?",
        ),
        (
            "pressure: {kind: simulated}\nsimulated: {surface: membrane, noise_mm: much}",
            "simulated.noise_mm: should be a number from 0 to 1000, not 'much'",
        ),
        (
            "pressure: {kind: simulated}\nsimulated: {surface: membrane, seed: 0.5}",
            "simulated.seed: should be a whole number from 0 on, not 0.5",
        ),
        (
            "pressure: {kind: simulated}\nsimulated: {surface: membrane, occlusion: .nan}",
            "simulated.occlusion: should be a number from 0 to 1, not nan",
        ),
        (
            "pressure: {kind: simulated}\nfollow: {on_mis: skip}",
            "follow: on_mis: there is no such field; did you mean on_miss?",
        ),
    ],
)
def test_a_devices_settings_are_checked_with_the_file(tmp_path: Path, text: str, said: str) -> None:
    """Before anything is connected: the line, the device, and the name that was meant."""
    path = tmp_path / "rig.yaml"
    path.write_text("name: a\nchambers:\n  - {name: c1, max_kpa: 60}\n" + text + "\n", encoding="utf-8")
    with pytest.raises(LabrigError) as caught:
        load_rig(path)
    assert str(caught.value).startswith(f"{path}")
    assert said in str(caught.value)


def test_a_section_of_no_use_says_that_it_may_go(tmp_path: Path) -> None:
    """`simulated` beside devices of one's own names a shell that does not fit: name another, or leave it out."""
    path = tmp_path / "rig.yaml"
    path.write_text(yaml.safe_dump({**GOOD, "simulated": {"seed": 1}}))
    with pytest.raises(LabrigError) as caught:
        load_rig(path)
    assert str(caught.value).endswith(
        "shell 'mannequin' has 9, the rig names 2; name a shell with as many chambers: simulated: {shell: FILE.yaml}; "
        "no device is simulated, so the section `simulated` may go"
    )
