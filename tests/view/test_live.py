"""The live view: it shows the run, and whatever happens to the viewer, the run does not notice."""

import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.campaign import RigInfo, Watching, run
from labrig.physics import load_surface
from labrig.rig import connect, parse_rig
from labrig.view import LiveView, live_observers, live_predict
from labrig.view import _live as live_module
from labrig.view._viewer import headless_viewer
from labrig_drivers import MarkerFrame, SimulatedClock
from labrig_procedures import Capture

drawing = pytest.mark.skipif(
    sys.platform == "linux" and not any(Path("/usr/share/vulkan/icd.d").glob("*.json")),
    reason="no Vulkan driver here: apt-get install mesa-vulkan-drivers libvulkan1",
)
RIG = {
    "name": "plate",
    "chambers": [{"name": f"c{i}", "max_kpa": 60} for i in range(1, 10)],
    "markers": [f"m{i:02d}" for i in range(1, 35)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated"},
    "simulated": {"surface": "mannequin", "seed": 1},
}


def capture_three(folder, *observers):
    """Three captures on the simulated rig, watched."""
    clock = SimulatedClock()
    with connect(parse_rig(RIG, "rig", folder), clock) as rig:
        procedure = Capture.model_validate({"captures": 3, "repeated": 0})
        return run(procedure, rig, folder / "run", clock=clock, watching=Watching(observers=observers))


def ended(name):
    """Wait until no thread of that name is left."""
    deadline = time.monotonic() + 20
    while any(thread.name == name for thread in threading.enumerate()):
        assert time.monotonic() < deadline, f"thread {name} does not end"
        time.sleep(0.02)


def nobody():
    """An address where nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"rerun+http://127.0.0.1:{probe.getsockname()[1]}/proxy"


def test_no_viewer_is_no_loss(tmp_path):
    """A viewer that never was there costs the run nothing: all captures are in the log."""
    capture_three(tmp_path, LiveView(nobody()))
    ended("observer LiveView")
    assert labrig.open_run(tmp_path / "run").sizes["capture"] == 3


def test_a_viewer_that_hangs(tmp_path):
    """A viewer that accepts the connection and then says nothing does not hold the run up."""
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen(8)
        capture_three(tmp_path, LiveView(f"rerun+http://127.0.0.1:{silent.getsockname()[1]}/proxy"))
        assert labrig.open_run(tmp_path / "run").sizes["capture"] == 3
    ended("observer LiveView")


def test_a_model_that_fails_is_left_alone(tmp_path):
    """A prediction that raises ends the live view, not the run."""

    def broken(pressure_kpa):
        raise ZeroDivisionError

    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen(8)
        capture_three(tmp_path, LiveView(f"rerun+http://127.0.0.1:{silent.getsockname()[1]}/proxy", broken))
        assert labrig.open_run(tmp_path / "run").sizes["capture"] == 3
    ended("observer LiveView")


def test_a_viewer_that_does_not_start_is_said(monkeypatch):
    """Where no viewer starts, the run gets no observer and the person one line."""

    def start(web):
        raise labrig.LabrigError("the rerun viewer found no screen")

    monkeypatch.setattr(live_module, "start_viewer", start)
    said = []
    assert live_observers(True, True, said.append) == []
    assert said == ["no live view: the rerun viewer found no screen"] * 2


def test_nothing_asked_nothing_started(monkeypatch):
    """Without --live and --serve no viewer is started."""
    monkeypatch.setattr(live_module, "start_viewer", pytest.fail)
    assert live_observers(False, False, pytest.fail) == []


@pytest.fixture
def model(tmp_path):
    """A model whose base is the simulator of the rig."""
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG))
    (tmp_path / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    return tmp_path / "model.yaml"


def test_the_model_predicts_the_markers_that_the_rig_has(model):
    """The live view compares each marker with the simulator's own, in the rig's order."""
    pressure_kpa = np.linspace(0, 50, 9)
    everything = load_surface(RIG).predict(pressure_kpa[None])[0]
    np.testing.assert_array_equal(live_predict(model)(pressure_kpa), everything)
    np.testing.assert_array_equal(live_predict(model, ("m03", "m01"))(pressure_kpa), everything[[2, 0]])


def test_a_model_that_cannot_predict(model):
    """A base that is no simulator, a marker that it does not know and a missing rig are each one line."""
    with pytest.raises(LabrigError) as unknown:
        live_predict(model, ("nose",))
    rig = model.parent / "rig.yaml"
    assert str(unknown.value) == f"{rig}: the simulator knows nothing of marker 'nose', which the rig has"
    rig.unlink()
    with pytest.raises(LabrigError) as missing:
        live_predict(model)
    assert str(missing.value) == f"cannot read the rig of the simulator {rig}: No such file or directory"
    model.write_text("base: {kind: static, degree: 1}\n")
    with pytest.raises(LabrigError) as static:
        live_predict(model)
    assert (
        str(static.value)
        == f"{model}: base: the live view needs a simulator to predict with, this is 'static'"
    )


@drawing
def test_the_run_is_seen(tmp_path):
    """A viewer shows markers, surface, residuals, pressures, plan and events of the run, and complains of nothing."""
    from rerun.experimental import ViewerClient

    rest = np.zeros((34, 3))
    with headless_viewer(size="900x600") as viewer:
        live = LiveView(viewer.url, lambda pressure_kpa: rest + pressure_kpa.sum())
        capture_three(tmp_path, live)
        ended("observer LiveView")
        client = ViewerClient.connect(viewer.url)
        wanted = {f"/rig/{kind}" for kind in ("surface", "measured", "predicted", "occluded", "residual")}
        wanted |= {"/commanded/c9", "/measured/c1", "/residual", "/plan/step", "/plan/interlock", "/events"}
        deadline = time.monotonic() + 20
        found = set()
        while not wanted <= found:
            assert time.monotonic() < deadline, f"missing: {wanted - found}"
            time.sleep(0.1)
            if client.get_state().active_recording:
                found = {entity.entity_path for entity in client.get_recording_schema().entities}
        client.save_screenshot(str(tmp_path / "live.png"))
        state = client.get_state()
        assert [report.summary for view in state.views for report in view.reports] == []
        assert {"plan and interlock", "events", "measured, kPa"} <= {view.name for view in state.views}


@drawing
def test_a_viewer_killed_in_mid_run(tmp_path):
    """When the viewer dies during a run the run goes on to its end."""

    class Killer(LiveView):
        def step_done(self, completed):
            super().step_done(completed)
            if completed.index == 3:
                viewer.process.kill()
                viewer.process.wait(10)

    with headless_viewer(size="300x200") as viewer:
        capture_three(tmp_path, Killer(viewer.url))
        assert labrig.open_run(tmp_path / "run").sizes["capture"] == 3
    ended("observer Killer")


def test_a_hanging_viewer_does_not_hold_up_the_end():
    """A program whose viewer hangs ends at once, without a word about it."""
    script = """
import socket, threading
import numpy as np
from labrig_drivers import Channel, MarkerFrame
from labrig.campaign import RigInfo
from labrig.view import LiveView
silent = socket.socket()
silent.bind(("127.0.0.1", 0))
silent.listen(8)
live = LiveView(f"rerun+http://127.0.0.1:{silent.getsockname()[1]}/proxy")
def watch():
    live.started(RigInfo("rig", (Channel("c1", 0, 60),), tuple("abcdefghi")), np.random.rand(9, 3))
    for k in range(500):
        live.frame(MarkerFrame(k / 10, k, np.random.rand(9, 3), np.zeros(9, np.int8)))
    done.set()
    live.finished("completed")
done = threading.Event()
watching = threading.Thread(target=watch, daemon=True)
watching.start()
print(done.wait(20))
watching.join(15)
"""
    ran = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=180, check=False
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "True\n", "")


def test_rig_without_markers():
    """A rig that has no motion capture is watched by its pressures alone."""
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen(8)
        live = LiveView(f"rerun+http://127.0.0.1:{silent.getsockname()[1]}/proxy")
        live.started(RigInfo("valves", ()), None)
        live.event(1.0, "vented", "WARNING")
        live.finished("completed")
    assert live._recording is None


def test_a_marker_that_was_never_seen_hides_no_other(monkeypatch):
    """Beside one without any place yet the others are drawn, as large as their own spread asks for."""
    view, recording = LiveView("rerun+http://127.0.0.1:9/proxy"), MagicMock()
    monkeypatch.setattr(view, "_look", lambda: None)
    view._markers, view._recording, view._skin = ("a", "b", "c"), recording, None
    place_mm = np.array([[0.0, 0.0, 0.0], [np.nan] * 3, [100.0, 20.0, 5.0]])
    view.frame(MarkerFrame(1.0, 1, place_mm, np.array([0, 1, 0], np.int8)))
    path, drawn_mm, _, radius_mm, labels = recording.points.call_args_list[0].args
    assert (path, labels) == ("/rig/measured", ["a", "c"])
    assert drawn_mm.tolist() == place_mm[[0, 2]].tolist()
    assert radius_mm == pytest.approx(0.6)
