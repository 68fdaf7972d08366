"""The rerun viewer as a process of its own: bound to this machine only, its usage statistics off."""

import contextlib
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlencode, urlsplit

from labrig._errors import LabrigError
from labrig.view._page_server import LOOPBACK, PageServer

START_S = 20.0
STOP_S = 5.0
WINDOW_S = 1.5  # in which a viewer finds out that there is no screen for its window


@dataclass(frozen=True)
class Viewer:
    """A running viewer: its process, and the address that recordings are sent to."""

    process: subprocess.Popen[bytes]
    url: str
    server: PageServer | None = None

    @property
    def page(self) -> str:
        """The address for a browser on this machine; empty where the viewer is no web viewer."""
        if self.server is None:
            return ""
        query = urlencode({"url": self.url, "persist": 0, "theme": "dark", "hide_welcome_screen": 1})
        return f"http://{LOOPBACK}:{self.server.port}/?{query}"

    def stop(self) -> None:
        """End the viewer; kills it if it does not go by itself."""
        if self.server is not None:
            self.server.close()
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(STOP_S)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait(STOP_S)


def start_viewer(
    *files: Path,
    headless: bool = False,
    web: bool = False,
    size: str = "",
    wait_s: float = START_S,
) -> Viewer:
    """Start a viewer that shows `files`, in a window, without one (`headless`), or for a browser (`web`).

    It listens on 127.0.0.1 alone, on free ports. Raises `LabrigError` when it does not
    answer within `wait_s`.
    """
    port, web_port = free_port(), free_port()
    command = [
        str(viewer_path()),
        *map(str, files),
        "--bind",
        LOOPBACK,
        "--port",
        str(port),
        "--hide-welcome-screen",
    ]
    if headless:
        command.append("--headless")
    if web:
        # A web viewer that is handed files would not take a live stream as well: it is a proxy for either.
        command += ["--serve-web", "--web-viewer-port", str(web_port)]
    if size:
        command += ["--window-size", size]
    try:
        process = subprocess.Popen(
            command,
            env=quiet_environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=sys.platform != "win32",  # Ctrl-C stops the run, not the viewer
            creationflags=subprocess.CREATE_NEW_PROCESS_GROUP if sys.platform == "win32" else 0,
        )
    except OSError as error:
        raise LabrigError(f"the rerun viewer does not start: {error.strerror or error}") from None
    url = f"rerun+http://{LOOPBACK}:{port}/proxy"
    answers = _answers(process, web_port if web else port, wait_s)
    if answers and not (headless or web):
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(WINDOW_S)  # without a screen it answers, and ends
    if not answers or process.poll() is not None:
        Viewer(process, url).stop()
        raise LabrigError(_why_not(process, headless))
    return Viewer(process, url, PageServer(web_port) if web else None)


def _why_not(process: subprocess.Popen[bytes], headless: bool) -> str:
    if process.returncode in (0, None):
        return "the rerun viewer does not answer; start it by hand with `rerun` to see why"
    if headless:
        return (
            "the rerun viewer cannot draw without a screen here; install a software renderer "
            "(Debian: apt-get install mesa-vulkan-drivers libvulkan1)"
        )
    return (
        "the rerun viewer found no screen; use --serve to watch in a browser, or open the .rrd file elsewhere"
    )


def viewer_path() -> Path:
    """The viewer's program, as the rerun package brings it."""
    import rerun_cli

    folder = Path(rerun_cli.__file__).parent
    bundled = folder / "Rerun.app" / "Contents" / "MacOS" / "Rerun"
    if sys.platform == "darwin" and bundled.exists():
        return bundled
    return folder / ("rerun.exe" if sys.platform == "win32" else "rerun")


def quiet_environment() -> dict[str, str]:
    """The environment with the viewer's usage statistics off: it sends none where CI is set."""
    return {**{k: v for k, v in os.environ.items() if k != "FORCE_RERUN_ANALYTICS"}, "CI": "1"}


def free_port() -> int:
    """A TCP port that nobody listens on just now."""
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


def reachable(url: str, timeout_s: float = 1.0) -> bool:
    """Whether anybody listens at a viewer's address."""
    address = urlsplit(url.removeprefix("rerun+"))
    try:
        with socket.create_connection((address.hostname or LOOPBACK, address.port or 0), timeout_s):
            return True
    except OSError:
        return False


def _answers(process: subprocess.Popen[bytes], port: int, wait_s: float) -> bool:
    deadline = time.monotonic() + wait_s
    while process.poll() is None and time.monotonic() < deadline:
        with contextlib.suppress(OSError), socket.create_connection((LOOPBACK, port), timeout=0.5):
            return True
        time.sleep(0.05)
    return False


@contextlib.contextmanager
def headless_viewer(*files: Path, size: str = "1600x1000") -> Iterator[Viewer]:
    """A viewer without a window, ended on the way out."""
    viewer = start_viewer(*files, headless=True, size=size)
    try:
        yield viewer
    finally:
        viewer.stop()


def screenshot(
    recording: str | Path, picture: str | Path, size: str = "1600x1000", capture: int | None = None
) -> list[str]:
    """Draw an .rrd recording without a screen into a .png; returns what its views had to complain of.

    `capture` moves the time cursor to that capture. Raises `LabrigError` when nothing can be drawn here.
    """
    recording, picture = Path(recording), Path(picture)
    with headless_viewer(recording.resolve(), size=size) as viewer:
        return snap(viewer, picture, capture)


def snap(viewer: Viewer, picture: Path, capture: int | None = None) -> list[str]:
    """Wait until `viewer` has loaded what it was given, and save what it shows; returns its views' complaints."""
    from rerun.experimental import ViewerClient

    client = ViewerClient.connect(viewer.url)
    deadline = time.monotonic() + START_S
    state = client.get_state()
    while not state.views or state.loading:
        if time.monotonic() > deadline:
            raise LabrigError("the rerun viewer has not loaded the recording in time")
        time.sleep(0.1)
        state = client.get_state()
    if capture is not None:
        client.set_time("capture", sequence=capture)
    client.save_screenshot(str(picture.resolve()))
    client.save_screenshot(str(picture.resolve()))  # the first frame lays out, the second one has everything
    state = client.get_state()
    return [f"{view.name}: {report.summary}" for view in state.views for report in view.reports]
