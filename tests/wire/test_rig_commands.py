"""labrig rig check, simulate, record and replay, as a person runs them."""

import os
import signal
import subprocess
import sys
import time

import pytest
import yaml

from labrig.cli import main
from labrig.rig import device_makers, parse_rig
from labrig_drivers import DeviceError, RealClock
from labrig_drivers import simulated as simulated_devices
from labrig_drivers._check import check_devices
from labrig_drivers.simulated._twins import TwinOptions, TwinRig

NO_MAP = "pressure: map: nope.yaml: no such register map (labrig brings festo-pgva.yaml, festo-vtem.yaml)"
LABRIG = [sys.executable, "-c", "from labrig.cli import main; main()"]


def labrig(*arguments, code=0):
    """Run a command; its standard output and error."""
    done = subprocess.run([*LABRIG, *map(str, arguments)], capture_output=True, text=True, timeout=100)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout, done.stderr


@pytest.fixture
def simulated(tmp_path):
    """Starts `labrig rig simulate` and waits until it is ready: (rig file, process)."""
    processes = []

    def start(*arguments):
        out = tmp_path / f"sim{len(processes)}"
        process = subprocess.Popen(
            [*LABRIG, "rig", "simulate", "-o", str(out), "--surface", "mannequin", *arguments],
            stdout=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        for line in process.stdout:
            if line.startswith("ready"):
                return out / "rig.yaml", process
        raise AssertionError("it did not start")

    yield start
    for process in processes:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.fixture
def twins(plant, tmp_path):
    """Runs twins over the small plant: `twins(**options)` gives a TwinRig."""
    running = []

    def start(**options):
        rig = TwinRig(
            plant, "bench", tmp_path, RealClock(), TwinOptions(**{"boot_s": 0.0, "rate_hz": 200.0, **options})
        )
        entered = rig.__enter__()
        running.append(rig)
        return entered

    yield start
    for rig in running:
        rig.__exit__(None, None, None)


def checked(rig, folder, change=lambda content: None, read_s=0.5):
    """The findings about a rig, as (device, what, state) and texts."""
    content = {**rig.rig}
    change(content)
    config = parse_rig(content, "rig.yaml", folder)
    findings = check_devices(device_makers(config, RealClock()), read_s=read_s, vent_timeout_s=3.0)
    return {(f.device, f.what): (f.state, f.text) for f in findings}


@pytest.mark.parametrize("pressure", ["openpneu", "openpneu-table", "modbus"])
def test_check_finds_a_simulated_rig_well(twins, tmp_path, pressure):
    """Every kind of twin is found well by the rig file that reaches it."""
    found = checked(twins(pressure=pressure), tmp_path)
    assert {key: state for key, (state, _) in found.items()} == dict.fromkeys(
        [
            ("pressure", "connect"),
            ("mocap", "connect"),
            ("scanner", "connect"),
            ("pressure", "readings"),
            ("mocap", "readings"),
            ("mocap", "markers"),
            ("mocap", "extent"),
            ("pressure", "vent"),
        ],
        "well",
    )


def test_check_names_what_is_not_well(twins, tmp_path, plant):
    """Wrong names, covered markers, a stuck valve and a missing folder are each found, and named."""
    rig = twins()
    plant.occluded = set(range(20))
    plant.stuck_kpa = 20.0

    def change(content):
        content["markers"] = [*content["markers"], "nose"]
        content["scanner"] = {"kind": "artec", "folder": "nowhere", "unit": "mm"}

    found = checked(rig, tmp_path, change)
    assert found["scanner", "connect"][0] == "bad"
    assert found["mocap", "markers"] == (
        "bad",
        "the server sends nothing for nose: check `subject` and the marker names, and that its output holds "
        "labelled markers",
    )
    state, text = found["pressure", "vent"]
    assert state == "bad"
    assert text.startswith("vent not confirmed within 3 s: c1 reads 20.0 kPa, ")


def test_check_goes_on_when_one_device_is_dead(twins, tmp_path):
    """A device that does not answer does not keep the others from being checked."""
    rig = twins()
    found = checked(rig, tmp_path, lambda content: content["mocap"].update(port=1))
    assert found["mocap", "connect"] == (
        "bad",
        "127.0.0.1:1 refuses the connection (nothing listens on that port; is the server running?)",
    )
    assert found["pressure", "vent"][0] == "well"


def test_check_notices_metres(twins, tmp_path, plant):
    """Markers that span a few mm are probably in metres."""
    plant.rest_mm = plant.rest_mm / 1000.0
    state, text = checked(twins(), tmp_path)["mocap", "extent"]
    assert state == "look"
    assert text.endswith("that looks like metres; set `unit: m`, or correct the calibration")


def test_check_notices_millimetres_that_were_taken_for_metres(twins, tmp_path, plant):
    """No rig is hundreds of metres large; and one marker alone has no extent that could look like another unit."""
    rig = twins()
    state, text = checked(rig, tmp_path, lambda content: content["mocap"].update(unit="m"))["mocap", "extent"]
    assert state == "look"
    assert text.endswith(" mm: no rig is so large; is `unit: m` set, and the server sends mm?")
    names = rig.rig["markers"]
    found = checked(rig, tmp_path, lambda content: content.update(markers=[names[0], "nose"]))
    assert ("mocap", "extent") not in found


@pytest.mark.parametrize(
    ("register_map", "text"),
    [
        ("festo-pgva.yaml", "pressure: Festo PGVA-1 has 1 outputs, the rig has 4 chambers"),
        ("nope.yaml", NO_MAP),
    ],
)
def test_a_map_that_does_not_serve(twins, register_map, text):
    """A twin whose map has too few outputs, or is not there, says so."""
    with pytest.raises(DeviceError) as error:
        twins(pressure="modbus", register_map=register_map)
    assert str(error.value) == text


def test_a_port_that_is_taken(twins, tmp_path):
    """A twin that cannot have its port says which."""
    port = twins().rig["mocap"]["port"]
    with pytest.raises(DeviceError, match=rf"^mocap: the twin cannot listen on 127\.0\.0\.1:{port}: "):
        twins(mocap_port=port)


def test_simulate_check_record_replay_check(simulated, tmp_path):
    """The whole round on the command line: simulate, check, record, replay, check the replay."""
    rig, process = simulated("--scan-every-s", "0.5", "--pressure", "modbus")
    content = yaml.safe_load(rig.read_text())
    assert content["pressure"]["host"] == content["mocap"]["host"] == "127.0.0.1"
    out, _ = labrig("rig", "check", rig, "--read-s", "1", "--still")
    assert "NOT WELL" not in out
    assert "confirmed in" in out
    assert list((rig.parent / "scans").glob("Eva scan *.obj"))
    recording = tmp_path / "recording"
    labrig("rig", "record", rig, "-o", recording, "--seconds", "2")
    assert sorted(path.name for path in recording.iterdir()) == ["mocap.wire", "pressure.wire", "rig.yaml"]
    _, error = labrig("rig", "record", rig, "-o", recording, code=2)
    assert error == f"labrig: {recording} is not empty: record into a new folder\n"
    replay = subprocess.Popen(
        [*LABRIG, "rig", "replay", str(recording), "-o", str(tmp_path / "again")],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        while not replay.stdout.readline().startswith("ready"):
            assert replay.poll() is None
        out, _ = labrig("rig", "check", tmp_path / "again" / "rig.yaml", "--read-s", "0.5", "--still")
        assert "NOT WELL" not in out
    finally:
        replay.kill()
        replay.wait()
        replay.stdout.close()
    assert process.poll() is None


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGTERM to a process")
def test_simulate_ends_on_sigterm(simulated):
    """A terminated simulation lets its ports go and ends without an error."""
    _, process = simulated()
    os.kill(process.pid, signal.SIGTERM)
    assert process.wait(timeout=180) == 0


def test_check_of_a_dead_rig_has_exit_code_3(tmp_path):
    """A rig that is not well ends with 3 and one line for each thing that is not."""
    rig = tmp_path / "rig.yaml"
    rig.write_text(
        "name: r\nchambers: [{name: c1, max_kpa: 10}]\npressure: {kind: openpneu, port: 'socket://127.0.0.1:1'}\n"
    )
    began = time.monotonic()
    _, error = labrig("rig", "check", rig, code=3)
    assert error == (
        "labrig: pressure: connect: 127.0.0.1:1 refuses the connection (nothing listens on that port; is the "
        "server running?)\n"
    )
    assert time.monotonic() - began < 60


def test_ready_is_said_when_it_is(tmp_path, monkeypatch, capsys):
    """What takes minutes on a new computer, the shapes, is worked out before a port is open and `ready` is said."""
    done = []
    enter, build = TwinRig.__enter__, simulated_devices.build_plant

    def built(*arguments):
        plant = build(*arguments)
        shape_mm = plant._surface.shape_mm
        plant._surface.shape_mm = lambda deflection: (done.append("shapes"), shape_mm(deflection))[1]
        return plant

    monkeypatch.setattr(simulated_devices, "build_plant", built)
    monkeypatch.setattr(TwinRig, "__enter__", lambda twins: (done.append("ports"), enter(twins))[1])
    words = ("rig", "simulate", "-o", str(tmp_path / "sim"), "--surface", "membrane", "--seconds", "0")
    with pytest.raises(SystemExit):
        main(list(words))
    assert done[:2] == ["shapes", "ports"]
    assert "ready; Ctrl-C ends it" in capsys.readouterr().out


def test_simulate_does_not_overwrite_a_persons_rig(tmp_path):
    """A rig.yaml that somebody wrote is left alone."""
    (tmp_path / "rig.yaml").write_text("name: mine\n")
    _, error = labrig("rig", "simulate", "-o", tmp_path, "--seconds", "0", code=2)
    assert error == f"labrig: {tmp_path / 'rig.yaml'} is somebody's own: choose another folder with -o\n"
    assert (tmp_path / "rig.yaml").read_text() == "name: mine\n"
