"""Recordings of raw sessions, and twins that answer from them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrig_drivers import Channel, DeviceError, RealClock, build_device
from labrig_drivers._recording import Recorder, RecordingError, read_header, read_pieces
from labrig_drivers.simulated._modbus_twin import ModbusTwin
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin
from labrig_drivers.simulated._replay import ReplayTwin
from labrig_drivers.simulated._vicon_server import ViconServer

CHANNELS = tuple(Channel(name, 0.0, 60.0) for name in ("c1", "c2", "c3", "c4"))
TARGET = np.array([10.0, 20.0, 30.0, 40.0])


def use(device, until):
    """What is done while recording and again while replaying: the last pressures and the vent."""
    device.connect()
    device.set(TARGET)
    until(lambda: any(np.allclose(s.pressure_kpa, TARGET, atol=0.15) for s in device.samples()))
    return device.vent()


def test_openpneu_session_replays(tmp_path, shared, closing, until):
    """A recorded OpenPneu session answers a driver as the board did: same dialect, same pressures."""
    twin = closing(OpenPneuTwin(OpenPneuBoard(shared), boot_s=0.0).start())
    file = tmp_path / "pressure.wire"
    settings = {"port": twin.port, "boot_s": 0.0, "build": "full"}
    build = {"name": "pressure", "clock": RealClock(), "channels": CHANNELS}
    device = build_device("openpneu", settings, record=file, **build)
    use(device, until)
    device.close()
    replay = closing(ReplayTwin(file, speed=4.0, patience_s=0.5).start())
    assert replay.kind == "openpneu"
    again = closing(
        build_device("openpneu", {**settings, "port": f"socket://127.0.0.1:{replay.port}"}, **build)
    )
    assert np.all(np.abs(use(again, until).pressure_kpa) < 3)


def test_vicon_session_replays_byte_for_byte(tmp_path, shared, plant, closing, until):
    """A recorded capture gives the frames that were recorded, and the client says what it said then."""
    plant.occluded = {5}
    server = closing(ViconServer(shared, rate_hz=100.0).start())
    file = tmp_path / "mocap.wire"
    build = {"name": "mocap", "clock": RealClock(), "marker_names": plant.marker_names}

    def frames(device, count):
        got = []
        until(lambda: got.extend(device.frames()) or len(got) >= count)
        return got[:count]

    device = build_device("vicon", {"port": server.port}, record=file, **build)
    device.connect()
    recorded = frames(device, 30)
    device.close()
    replay = closing(ReplayTwin(file, speed=10.0).start())
    again = closing(build_device("vicon", {"port": replay.port}, **build))
    again.connect()
    replayed = frames(again, 30)
    assert [frame.number for frame in replayed] == [frame.number for frame in recorded]
    for one, other in zip(recorded, replayed, strict=True):
        np.testing.assert_array_equal(one.position_mm, other.position_mm)
    assert replay.differing == replay.missing == 0


def test_modbus_session_replays(tmp_path, shared, closing, until):
    """A recorded Modbus session answers requests in the order in which they were made."""
    from labrig_drivers._modbus_map import load_map

    twin = closing(ModbusTwin(shared, load_map("festo-vtem.yaml")).start())
    file = tmp_path / "pressure.wire"
    settings = {"host": "127.0.0.1", "port": twin.port, "map": "festo-vtem.yaml"}
    build = {"name": "pressure", "clock": RealClock(), "channels": CHANNELS}
    device = build_device("modbus", settings, record=file, **build)
    device.connect()
    until(device.samples)
    device.close()
    replay = closing(ReplayTwin(file).start())
    again = closing(build_device("modbus", {**settings, "port": replay.port}, **build))
    again.connect()
    assert until(again.samples)[0].pressure_kpa.tolist() == [0, 0, 0, 0]
    assert replay.differing == 0


def test_a_client_that_says_less_is_answered_after_a_while(tmp_path, closing):
    """A replay does not wait for ever for what the host said then; it counts what is missing."""
    import socket

    file = tmp_path / "a.wire"
    recorder = Recorder(file, "openpneu", "pressure")
    for sent, data in ((True, b"AT\r\n"), (False, b"OK\r\n"), (True, b"never said"), (False, b"bye")):
        recorder.piece(sent, data)
    recorder.close()
    replay = closing(ReplayTwin(file, patience_s=0.2).start())
    with socket.create_connection(("127.0.0.1", replay.port), 5) as client:
        client.sendall(b"at\r\n")
        got = b""
        while piece := client.recv(100):
            got += piece
    assert got == b"OK\r\nbye"
    assert (replay.differing, replay.missing) == (1, 1)


@settings(max_examples=50)
@given(st.lists(st.tuples(st.booleans(), st.binary(min_size=1, max_size=50)), max_size=20), st.floats(0, 1))
def test_recordings_round_trip_and_survive_a_cut(tmp_path_factory, pieces, part):
    """Every piece comes back as it passed; of a file that was cut only the last line is lost."""
    file = tmp_path_factory.mktemp("r") / "a.wire"
    recorder = Recorder(file, "vicon", "mocap")
    for sent, content in pieces:
        recorder.piece(sent, content)
    recorder.close()
    assert [(piece.sent, piece.data) for piece in read_pieces(file)] == pieces
    assert read_header(file)["device"] == "mocap"
    whole = file.read_bytes()
    head = whole.index(b"\n") + 1
    cut = head + int(part * (len(whole) - head))
    file.write_bytes(whole[:cut])
    left = [(piece.sent, piece.data) for piece in read_pieces(file)]
    assert left == pieces[: whole[head:cut].count(b"\n")]


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"hello\n", "not a recording (Expecting value: line 1 column 1 (char 0))"),
        (b"{}\n", "not a recording (its first line is not a 'labrig wire recording 1' header)"),
        (
            b'{"format": "labrig wire recording 1"}\n1 < zz\n',
            "line 2 is not 'seconds < hex' or 'seconds > hex'",
        ),
        (
            b'{"format": "labrig wire recording 1"}\nnan < 00\n',
            "line 2 is not 'seconds < hex' or 'seconds > hex'",
        ),
        (
            b'{"format": "labrig wire recording 1"}\n1 <> 00\n',
            "line 2 is not 'seconds < hex' or 'seconds > hex'",
        ),
    ],
)
def test_what_is_no_recording(tmp_path, content, text):
    """A file that is no recording is named, with the line."""
    file = tmp_path / "a.wire"
    file.write_bytes(content)
    with pytest.raises(RecordingError) as error:
        list(read_pieces(file))
    assert str(error.value) == f"{file}: {text}"


def test_a_recording_is_never_overwritten(tmp_path):
    """Recording into a file that exists is refused."""
    file = tmp_path / "a.wire"
    file.write_text("mine")
    with pytest.raises(DeviceError) as error:
        build_device("vicon", {}, name="mocap", clock=RealClock(), record=file)
    assert str(error.value) == f"mocap: {file} exists already; record into a new file"
    assert file.read_text() == "mine"
