"""The viewer's process: on this machine only, silent about its use, and gone when it should be."""

import urllib.request

import psutil
import pytest

from labrig import LabrigError
from labrig.view import _viewer as viewer_module
from labrig.view import start_viewer
from labrig.view._page_server import POLICY
from labrig.view._viewer import quiet_environment


@pytest.fixture
def web_viewer():
    """A viewer for a browser."""
    viewer = start_viewer(web=True)
    yield viewer
    viewer.stop()


def test_it_listens_on_this_machine_only(web_viewer):
    """Neither the viewer nor its page is reachable from another machine."""
    connections = psutil.Process(web_viewer.process.pid).net_connections(kind="tcp")
    listening = {c.laddr.ip for c in connections if c.status == psutil.CONN_LISTEN}
    assert listening == {"127.0.0.1"}
    assert web_viewer.page.startswith("http://127.0.0.1:")


def test_the_page_may_not_call_home(web_viewer):
    """The browser is told to let the page connect to this machine alone."""
    with urllib.request.urlopen(web_viewer.page, timeout=180) as answer:
        assert answer.headers["Content-Security-Policy"] == POLICY
        assert b"<html" in answer.read()
    assert "connect-src 'self' data: blob: http://127.0.0.1:* ws://127.0.0.1:*" in POLICY


def test_a_missing_page_is_missing(web_viewer):
    """What the viewer does not have is an ordinary 404."""
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(web_viewer.page.split("?")[0] + "nothing.js", timeout=180)


def test_stop_ends_it(web_viewer):
    """After stop there is no process, and stopping again does no harm."""
    web_viewer.stop()
    web_viewer.stop()
    assert web_viewer.process.returncode is not None
    assert not psutil.pid_exists(web_viewer.process.pid)


def test_usage_statistics_are_off(monkeypatch):
    """The viewer sees an environment in which it sends no usage statistics."""
    monkeypatch.setenv("FORCE_RERUN_ANALYTICS", "1")
    environment = quiet_environment()
    assert environment["CI"] == "1"
    assert "FORCE_RERUN_ANALYTICS" not in environment


def test_a_viewer_that_is_not_there(monkeypatch, tmp_path):
    """A missing program is one clear line."""
    monkeypatch.setattr(viewer_module, "viewer_path", lambda: tmp_path / "rerun")
    with pytest.raises(LabrigError, match=r"^the rerun viewer does not start: No such file or directory$"):
        start_viewer()


def test_a_window_without_a_screen(monkeypatch):
    """Where there is no screen, the error says what to do instead."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    if viewer_module.sys.platform != "linux":
        pytest.skip("a window always finds its screen here")
    with pytest.raises(LabrigError) as raised:
        start_viewer()
    assert str(raised.value) == (
        "the rerun viewer found no screen; use --serve to watch in a browser, or open the .rrd file elsewhere"
    )
