"""The classes in docs/how-to/add-a-device.md do what the page says, against a small counterpart."""

import json
import re
import socketserver
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.rig import RigConfig, connect, device_makers, parse_rig
from labrig_drivers import DeviceError, MarkerStatus, RealClock

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-a-device.md"


class Box:
    """The valve box and the camera of the page: chambers that follow at once, two markers, one of them covered."""

    def __init__(self) -> None:
        self.kpa, self.links, self.servers = [0.0, 0.0], [], []
        self.ports = [self._serve(self._valve), self._serve(self._camera)]

    def _serve(self, talk: Any) -> int:
        box = self

        class Handler(socketserver.StreamRequestHandler):
            def handle(self) -> None:
                box.links.append(self.connection)
                try:
                    talk(self)
                except (OSError, ValueError):
                    return

        class Server(socketserver.ThreadingTCPServer):
            daemon_threads = allow_reuse_address = True

        server = Server(("127.0.0.1", 0), Handler)
        self.servers.append(server)
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        return server.server_address[1]

    def _valve(self, link: Any) -> None:
        for line in link.rfile:
            link.wfile.write(self.answer(line))

    def answer(self, line: bytes) -> bytes:
        """What the valve box says to a line."""
        word, *values = line.decode().split()
        if word in ("SET", "VENT"):
            self.kpa = [float(value) for value in values] or [0.0, 0.0]
        said = {"ID": "box 3000", "READ": " ".join(map(str, self.kpa))}.get(word, "OK")
        return f"{said}\n".encode()

    def _camera(self, link: Any) -> None:
        for number in range(10_000):
            frame = {"number": number, "markers": {"m1": [1, 2, 3 + self.kpa[0]], "m2": None}}
            link.wfile.write(f"{json.dumps(frame)}\n".encode())
            time.sleep(0.01)

    def cut(self) -> None:
        """Break every link, as if the cables were pulled."""
        for link in self.links:
            link.shutdown(2)
        self.links.clear()


@pytest.fixture
def box() -> Iterator[Box]:
    """The counterpart of both devices."""
    box = Box()
    yield box
    for server in box.servers:
        server.shutdown()
        server.server_close()


@pytest.fixture
def config(tmp_path: Path, box: Box) -> RigConfig:
    """A rig of the page's two files."""
    blocks = re.findall(r"```python\n# (\w+\.py)\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert [name for name, _ in blocks] == ["my_valve.py", "my_board.py", "my_camera.py"]
    for name, text in blocks:
        (tmp_path / name).write_text(text, encoding="utf-8")
    content = {
        "name": "page",
        "chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 60}],
        "markers": ["m2", "m1"],
        "pressure": {"kind": "python", "file": "my_valve.py", "class": "MyValve", "port": box.ports[0]},
        "mocap": {"kind": "python", "file": "my_camera.py", "class": "MyCamera", "port": box.ports[1]},
    }
    return parse_rig(content, "rig.yaml", tmp_path)


def test_the_pages_classes_set_read_and_vent(config: RigConfig, box: Box) -> None:
    """Both connect, follow, tell a covered marker, refuse what is outside a limit, and leave the chambers vented."""
    with connect(config, RealClock(), guard=False) as rig:
        assert rig.mocap is not None
        assert rig.identity["pressure"].description == "box 3000"
        rig.pressure.set(np.array([40.0, 0.0]))
        with pytest.raises(DeviceError, match=r"70.0 kPa is outside the limits of c2"):
            rig.pressure.set(np.array([0.0, 70.0]))
        time.sleep(0.2)
        assert rig.pressure.samples()[-1].pressure_kpa.tolist() == [40.0, 0.0]
        frame = rig.mocap.frames()[-1]
        assert frame.status.tolist() == [MarkerStatus.OCCLUDED, MarkerStatus.SEEN]
        np.testing.assert_array_equal(frame.position_mm, [[np.nan] * 3, [1, 2, 43]])
    assert box.kpa == [0.0, 0.0]


def test_the_pages_vent_connects_again(config: RigConfig, box: Box) -> None:
    """After the link was lost, what was asked is an error of one line, and a vent opens it again and is confirmed."""
    valve = device_makers(config, RealClock())["pressure"]()
    valve.connect()
    valve.set(np.array([40.0, 40.0]))
    box.cut()
    time.sleep(0.2)
    with pytest.raises(DeviceError, match="pressure: it does not answer any more; check its cable"):
        valve.samples()
    assert valve.vent(3.0).pressure_kpa.tolist() == [0.0, 0.0]
    valve.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_the_pages_board_on_a_serial_port(config: RigConfig, box: Box) -> None:
    """The page's serial board sets, reads and vents over a terminal, and a board that went away is said in one line."""
    import os
    import pty
    import tty

    ours, theirs = pty.openpty()
    tty.setraw(theirs)

    def board() -> None:
        with suppress(OSError), os.fdopen(ours, "rb+", buffering=0) as link:
            pending = b""
            while data := link.read(256):
                *lines, pending = (pending + data).split(b"\n")
                for line in lines:
                    link.write(box.answer(line))

    threading.Thread(target=board, daemon=True).start()
    options = {"file": "my_board.py", "class": "MyBoard", "device": os.ttyname(theirs), "starts_s": 0.0}
    content: dict[str, Any] = {
        "name": "page",
        "chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 60}],
        "pressure": {"kind": "python", **options},
    }
    own = parse_rig(content, "rig.yaml", config.folder)
    valve = device_makers(own, RealClock())["pressure"]()
    valve.connect()
    assert valve.identify().description == "box 3000"
    valve.set(np.array([40.0, 10.0]))
    time.sleep(0.2)
    assert valve.samples()[-1].pressure_kpa.tolist() == [40.0, 10.0]
    assert valve.vent(3.0).pressure_kpa.tolist() == box.kpa == [0.0, 0.0]
    valve.close()
    os.close(theirs)
    content["pressure"] |= {"device": str(config.folder / "ttyACM9")}
    gone = device_makers(parse_rig(content, "rig.yaml", config.folder), RealClock())["pressure"]()
    with pytest.raises(DeviceError, match=r"pressure: cannot open .*ttyACM9: .*; plug it in"):
        gone.connect()
