"""What `labrig run` says when something of a person's own fails: one line, and whether the chambers are vented."""

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from labrig.campaign import Interrupted

RIG = {
    "name": "small",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "pressure": {"kind": "simulated"},
    "simulated": {"surface": "membrane", "seed": 0},
}
CAMERA = '''
from pathlib import Path

import numpy as np

from labrig_drivers import DeviceError, Identity, MarkerFrame


class CameraError(DeviceError):
    """Made of more than its text."""

    def __init__(self, code, text):
        super().__init__(f"{code}: {text}")


class Camera:
    marker_names = ("m1",)

    def __init__(self, name, clock):
        self.name, self.clock, self.number = name, clock, 0

    def connect(self):
        pass

    def close(self):
        pass

    def identify(self):
        return Identity(self.name, "camera", "a camera")

    def frames(self):
        self.number += 1
        if Path("cap").exists():
            raise CameraError(5, "lens cap")
        return [MarkerFrame(self.clock.now_s(), self.number, np.zeros((1, 3)), np.zeros(1, np.int8))]
'''
BENCH = """
import numpy as np

from labrig_drivers import Identity, PressureSample, VentReport


class Bench:
    def __init__(self, name, clock, channels):
        self.name, self.clock, self.channels = name, clock, channels
        self.pressure_kpa = np.zeros(len(channels))

    def connect(self):
        pass

    def close(self):
        pass

    def identify(self):
        return Identity(self.name, "bench", "a bench")

    def set(self, pressure_kpa):
        self.pressure_kpa = np.array(pressure_kpa, float)

    def samples(self):
        return [PressureSample(self.clock.now_s(), self.pressure_kpa)]

    def vent(self, timeout_s=10.0):
        self.pressure_kpa[:] = 0.0
        return VentReport(self.pressure_kpa.copy(), 0.1)
"""
UP = """
from pathlib import Path

from labrig.campaign import Actuate, Procedure, Record, Settle


class Up(Procedure):
    def steps(self, rig):
        for number in range(2):
            yield Actuate([10.0] * 4)
            yield Settle(0.1)
            yield Record(0.1)
            if Path("one/log.000.mcap").exists():
                Path("cap").touch()
"""

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a simulated rig without cameras and a procedure, as the current one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG))
    (tmp_path / "up.py").write_text(UP)
    return tmp_path


def test_a_drivers_own_kind_of_error_is_told_with_the_vent(lab: Path, labrig: Run) -> None:
    """An error that is made of more than its text is told as any other: what failed, vented, how to go on."""
    (lab / "camera.py").write_text(CAMERA)
    own = {"mocap": {"kind": "python", "file": "camera.py", "class": "Camera"}}
    (lab / "rig.yaml").write_text(yaml.safe_dump({**RIG, **own}))
    code, _, err = labrig("run", "up.py", "--rig", "rig.yaml", "--out", "one")
    assert (code, err.splitlines()[-1]) == (
        3,
        "labrig: 5: lens cap; the chambers are vented; to resume: labrig run --resume one",
    )


def test_what_cannot_be_resumed_is_not_called_resumable(lab: Path, labrig: Run) -> None:
    """A run whose rig is another one now is to be begun anew: nothing beside that says how to resume it."""
    stop = "            if Path('one/log.000.mcap').exists():\n                raise ValueError('no more')\n"
    (lab / "up.py").write_text(UP + stop)
    labrig("run", "up.py", "--rig", "rig.yaml", "--out", "one")
    (lab / "up.py").write_text(UP)
    chambers = [{**RIG["chambers"][0], "max_kpa": 50}, *RIG["chambers"][1:]]
    (lab / "rig.yaml").write_text(yaml.safe_dump({**RIG, "chambers": chambers}))
    code, _, err = labrig("run", "--resume", "one")
    assert code == 2
    assert err.startswith("labrig: cannot resume one: the limits of the chambers changed (")
    assert err.endswith("; start a new run\n")


@pytest.mark.parametrize(
    ("field", "value"), [("seed", "abc"), ("start_s", "abc"), ("rig", None), ("identity", {"pressure": 3})]
)
def test_a_run_yaml_that_was_changed_by_hand_is_named(
    lab: Path, labrig: Run, field: str, value: object
) -> None:
    """What is no number, or holds no fields, is one line with its place, and no segment of the log is begun."""
    stop = "            if Path('one/log.000.mcap').exists():\n                raise ValueError('no more')\n"
    (lab / "up.py").write_text(UP + stop)
    labrig("run", "up.py", "--rig", "rig.yaml", "--out", "one")
    (lab / "up.py").write_text(UP)
    facts = yaml.safe_load((lab / "one/run.yaml").read_text())
    (lab / "one/run.yaml").write_text(yaml.safe_dump({**facts, field: value}))
    code, _, err = labrig("run", "--resume", "one")
    assert (code, err.startswith(f"labrig: one/run.yaml: {field}")) == (2, True), err
    assert not (lab / "one/log.001.mcap").exists()


def test_a_procedure_that_exits_has_failed(lab: Path, labrig: Run) -> None:
    """`sys.exit()` in a procedure is no way to end a run: it is told as its error, and never as a success."""
    (lab / "up.py").write_text(UP + "            raise SystemExit\n")
    assert labrig("run", "up.py", "--rig", "rig.yaml", "--out", "one") == (
        2,
        "",
        "labrig: procedure up failed at step 3: SystemExit: (up.py, line 15)\n",
    )


def test_another_ctrl_c_does_not_take_the_last_words_away(
    lab: Path, labrig: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who presses Ctrl-C again when the run has ended, and its rig is let go, still reads that it is vented."""

    def stopped(*_: object, **__: object) -> None:
        raise Interrupted("stopped by Ctrl-C after 1 steps and 0 captures; the chambers are vented")

    def pressed(_rig: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("labrig.cli._run_steps.run_procedure", stopped)
    monkeypatch.setattr("labrig.rig._rig.Rig.vent", pressed)
    assert labrig("run", "up.py", "--rig", "rig.yaml", "--out", "one") == (
        130,
        "",
        "labrig: stopped by Ctrl-C after 1 steps and 0 captures; the chambers are vented\n",
    )


def test_ctrl_c_in_a_check_says_that_the_chambers_are_vented(
    lab: Path, labrig: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A check that is stopped while it fills a chamber says what has become of the pressure."""

    def pressed(*_: object) -> None:
        raise KeyboardInterrupt

    own = {"pressure": {"kind": "python", "file": "bench.py", "class": "Bench"}, "simulated": None}
    (lab / "bench.py").write_text(BENCH)
    (lab / "rig.yaml").write_text(yaml.safe_dump({**RIG, **own}))
    monkeypatch.setattr("labrig.cli._rig_steps.fill_in_turn", pressed)
    code, _, err = labrig("rig", "check", "rig.yaml", "--read-s", "0.2")
    assert (code, err) == (130, "labrig: stopped by Ctrl-C; the chambers are vented\n")
