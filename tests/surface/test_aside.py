"""Open3D lives in a process of its own; what becomes of it there is one line here."""

import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import Mesh, grid, register
from labrig.surface._aside import Aside


def membrane(side=31):
    """A membrane with three bulges, 300 x 240 mm."""
    uv, triangles = grid(side, side)
    u, v = uv.T
    rise = [(40, 0.25, 0.25), (25, 0.75, 0.25), (50, 0.3, 0.8)]
    z = sum(h * np.exp(-((u - a) ** 2 + (v - b) ** 2) / 0.03) for h, a, b in rise)
    return Mesh(np.stack([300 * u, 240 * v, z], axis=1), triangles)


@pytest.fixture
def aside():
    """A worker of the test's own."""
    worker = Aside()
    yield worker
    worker.close()


def test_open3d_is_not_imported_here():
    """Registering a scan leaves the process that asked, which may hold a rig's pressures, without Open3D."""
    found = register(membrane(), membrane())
    assert found.share > 0.9
    assert "open3d" not in sys.modules


def test_a_missing_open3d_is_one_line(monkeypatch, aside):
    """Without the extra the error says what to type."""
    monkeypatch.setattr("labrig._extras.find_spec", lambda name: None)
    with pytest.raises(LabrigError) as error:
        aside.call("cloud_frame", membrane().vertices_mm)
    assert str(error.value).endswith("type: pip install '.[scan]'")


def test_a_worker_that_dies_is_said_and_replaced(aside):
    """Where Open3D takes its process with it, that is an error in one line, and the next call has a new one."""
    normals, _, _ = aside.call("cloud_frame", membrane().vertices_mm)
    assert np.abs(np.linalg.norm(normals, axis=1) - 1.0).max() < 1e-9
    first = aside._process
    first.kill()
    first.wait()
    aside.call("cloud_frame", membrane().vertices_mm)
    assert aside._process.pid != first.pid
    second = aside._process
    with ThreadPoolExecutor(1) as pool:
        asked = pool.submit(aside.call, "tidy_cloud", np.random.default_rng(0).random((2_000_000, 3)), None)
        while not aside._lock.locked():
            time.sleep(0.01)
        second.kill()
        with pytest.raises(LabrigError) as error:
            asked.result()
    assert str(error.value).startswith("Open3D died")


def test_what_fails_inside_is_one_line(aside):
    """What Open3D or numpy throw becomes an error that says what was asked, and the worker goes on."""
    with pytest.raises(LabrigError) as error:
        aside.call("cloud_frame", np.zeros((5, 2)))
    assert str(error.value).startswith("Open3D could not do it (cloud frame): ")
    assert "\n" not in str(error.value)
    assert len(aside.call("cloud_frame", membrane().vertices_mm)[0]) == 961


def test_the_worker_ends_with_its_parent():
    """A parent that is killed outright leaves no worker behind."""
    script = (
        "import os, signal, sys\nimport numpy as np\nfrom labrig.surface import _aside\n"
        "_aside.call('cloud_frame', np.random.default_rng(0).random((50, 3)))\n"
        "print(_aside._ASIDE._process.pid, flush=True)\nos.kill(os.getpid(), signal.SIGTERM)"
    )
    psutil = pytest.importorskip("psutil")
    ran = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=180, check=False
    )
    assert ran.returncode in (-signal.SIGTERM, signal.SIGTERM)
    worker = int(ran.stdout)
    if psutil.pid_exists(worker):
        psutil.wait_procs([psutil.Process(worker)], timeout=180)
    assert not psutil.pid_exists(worker)


def test_a_refusal_arrives_as_it_is():
    """What the worker refuses has the words that it gave: a triangle is not laid onto a membrane."""
    corner = Mesh(np.array([[0.0, 0, 0], [90, 0, 0], [0, 90, 0]]), np.array([[0, 1, 2]]))
    with pytest.raises(LabrigError) as error:
        register(corner, membrane())
    assert str(error.value).startswith("the scan and the surface do not fit each other")
