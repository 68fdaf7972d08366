"""The Vicon driver against the twin, and against servers that misbehave."""

import socket
import struct

import numpy as np
import pytest

from labrig_drivers import DeviceError, MarkerStatus, RealClock, build_device
from labrig_drivers._cgstream import CgObject, block, packet
from labrig_drivers.simulated._vicon_encode import Scene
from labrig_drivers.simulated._vicon_server import ViconServer

EMPTY = block(6, bytes(4))
SEEN, OCCLUDED, STALE, NOT_SUBSCRIBED = MarkerStatus


@pytest.fixture
def server(shared, closing):
    """Starts a twin: `server(**settings)`."""
    return lambda **settings: closing(ViconServer(shared, **{"rate_hz": 200.0, **settings}).start())


@pytest.fixture
def client(closing, plant):
    """Makes a driver: `client(port, **settings)`, not connected."""

    def make(port, markers=None, **settings):
        names = plant.marker_names if markers is None else markers
        settings = {"port": port, "timeout_s": 1.0, **settings}
        return closing(build_device("vicon", settings, name="mocap", clock=RealClock(), marker_names=names))

    return make


def hello(*objects):
    """A greeting that offers `objects`."""
    return packet([block(100001, struct.pack(f"<{len(objects) + 1}I", len(objects), *objects))])


def scene_frame(number, position, names=("a",), statics=True):
    """A frame of subject `arm` with markers at `position`."""
    scene = Scene("arm", names)
    made = scene.frame_blocks(number, np.array(position, float), 0.0)
    wanted = [made[n] for n in (5, 6)]
    return packet([*(scene.static_blocks().values() if statics else ()), *wanted])


def collect(device, until, count=1, keep=lambda frame: True):
    """At least `count` frames for which `keep` holds."""
    frames = []

    def enough():
        frames.extend(frame for frame in device.frames() if keep(frame))
        return len(frames) >= count

    until(enough)
    return frames


def test_markers_arrive_where_the_plant_has_them(server, client, plant, until):
    """Positions, order and frame numbers come through; occluded markers are NaN and OCCLUDED."""
    plant.occluded = {3, 30}
    device = client(server().port)
    device.connect()
    frames = collect(device, until, 50)
    for frame in frames:
        assert frame.status.tolist() == [OCCLUDED if i in (3, 30) else SEEN for i in range(34)]
        seen = frame.status == SEEN
        np.testing.assert_array_equal(frame.position_mm[seen], plant.rest_mm[seen])
        assert np.isnan(frame.position_mm[~seen]).all()
    numbers = [frame.number for frame in frames]
    assert numbers == list(range(numbers[0], numbers[0] + len(frames)))
    assert frames[0].rate_hz == 200.0
    assert frames[0].latency_s == pytest.approx(0.0055)
    assert frames[0].hardware_number == frames[0].number - 1
    assert frames[0].timecode is not None


class StoppedClock(RealClock):
    """It is one moment all the time."""

    def now_s(self):
        return 1000.0


def test_time_is_the_arrival_less_the_latency(client, script, until):
    """The latency that the server states is taken off the host's time of arrival."""

    def talk(connection):
        connection.sendall(hello(5, 6, 26))
        parts = struct.pack("<I", 1) + b"\x01\0\0\0a" + struct.pack("<d", 0.25)
        connection.sendall(packet([block(5, bytes(4)), block(6, bytes(4)), block(26, parts)]))
        connection.recv(4096)
        connection.recv(4096)

    device = client(script(talk).port, markers=("a",))
    device._clock = StoppedClock()
    device.connect()
    (frame, *_) = collect(device, until, 1)
    assert frame.time_s == 999.75


def test_frames_of_one_burst_are_spaced_by_the_rate(client, script, until):
    """Frames that arrive at once after a hiccup keep their distance in time."""

    def talk(connection):
        burst = b"".join(
            packet(
                [*Scene("arm", ("a",), 200.0).static_blocks().values(), block(5, struct.pack("<I", n)), EMPTY]
            )
            for n in range(5)
        )
        connection.sendall(hello(1, 2, 5, 6) + burst)
        connection.recv(4096)
        connection.recv(4096)

    device = client(script(talk).port, markers=("a",))
    device._clock = StoppedClock()  # however the burst is cut on its way
    device.connect()
    times = [frame.time_s for frame in collect(device, until, 5)[:5]]
    assert np.diff(times) == pytest.approx(0.005, abs=1e-6)


def test_y_up_servers_give_the_same_positions(server, client, plant, until):
    """A Y-up server is turned into the rig's Z-up frame, unlabelled markers too."""
    ghosts = np.array([[1.0, 2.0, 3.0]])
    device = client(server(up="y", ghosts_mm=ghosts).port)
    device.connect()
    frame = collect(device, until)[0]
    np.testing.assert_array_equal(frame.position_mm, plant.rest_mm)
    np.testing.assert_array_equal(frame.unlabeled_mm, ghosts)


@pytest.mark.parametrize("mode", ["push", "pull", "prefetch"])
def test_every_mode_streams(server, client, until, mode):
    """Push, pull and prefetch all deliver consecutive frames."""
    device = client(server().port, mode=mode)
    device.connect()
    numbers = [frame.number for frame in collect(device, until, 20)]
    assert numbers == sorted(set(numbers))


def test_a_server_that_dies_and_returns_is_subscribed_again(server, client, plant, until):
    """After the server's return the subscription is sent anew: markers are SEEN again, STALE in between."""
    first = server()
    device = client(first.port, stale_after_s=0.05)
    device.connect()
    collect(device, until, 5)
    first.stop()
    stale = collect(device, until, 2, lambda frame: frame.status[0] == STALE)
    assert all((frame.status == STALE).all() and np.isnan(frame.position_mm).all() for frame in stale)
    server(port=first.port)
    again = collect(device, until, 5, lambda frame: frame.status[0] != STALE)
    assert all((frame.status == SEEN).all() for frame in again)
    np.testing.assert_array_equal(again[-1].position_mm, plant.rest_mm)
    assert device.reconnects == 1


def test_a_server_that_stays_away_is_an_error_that_names_the_device(server, client, until):
    """After `lost_after_s` without a connection the next call says so, and why."""
    twin = server()
    device = client(twin.port, lost_after_s=0.2)
    device.connect()
    collect(device, until, 1)
    twin.stop()
    with pytest.raises(DeviceError, match=r"^mocap: no connection for \d+ s: 127\.0\.0\.1:\d+ refuses"):
        until(lambda: device.frames() and False)


def test_markers_that_the_server_does_not_know(server, client, until):
    """Markers of another subject, or of no subject, are NOT_SUBSCRIBED, not occluded."""
    device = client(server().port, subject="somebody else")
    device.connect()
    assert (collect(device, until)[0].status == NOT_SUBSCRIBED).all()


def test_a_server_without_marker_data(client, script, until):
    """Where labelled markers are not offered, frames come through with every marker NOT_SUBSCRIBED."""

    def talk(connection):
        connection.sendall(hello(5))
        for number in range(100_000):
            connection.sendall(packet([block(5, struct.pack("<I", number))]))

    device = client(script(talk).port, markers=("a",))
    device.connect()
    assert (collect(device, until)[0].status == NOT_SUBSCRIBED).all()


def test_early_frames_without_the_subscribed_types_are_not_delivered(client, script, until):
    """Frames from before the subscription took effect would show every marker covered; none is delivered."""

    def talk(connection):
        connection.sendall(hello(2, 5, 6))
        for number in range(20):
            connection.sendall(packet([block(5, struct.pack("<I", number))]))
        connection.sendall(scene_frame(20, [[1, 2, 3]]))
        connection.recv(4096)
        connection.recv(4096)

    device = client(script(talk).port, markers=("a",))
    device.connect()
    frames = collect(device, until)
    assert (frames[0].number, frames[0].status.tolist()) == (21, [SEEN])


def test_repeated_and_backward_frame_numbers(client, script, until):
    """A repeated frame is no news (STALE); numbers that run backward pass, in the order of arrival."""

    def talk(connection):
        connection.sendall(hello(2, 5, 6))
        connection.sendall(b"".join(scene_frame(n, [[1, 2, 3]]) for n in (10, 11, 11, 5, 6)))
        connection.recv(4096)
        connection.recv(4096)

    device = client(script(talk).port, markers=("a",))
    device.connect()
    frames = collect(device, until, 5)[:5]
    assert [frame.number for frame in frames] == [11, 12, 12, 6, 7]
    assert [frame.status[0] for frame in frames] == [SEEN, SEEN, STALE, SEEN, SEEN]
    assert np.isnan(frames[2].position_mm).all()
    times = [frame.time_s for frame in frames]
    assert times == sorted(times)


def test_a_flood_keeps_memory_bounded(client, script, until):
    """Frames that nobody fetches push out the oldest, and are counted."""
    data = b"".join(scene_frame(number, [[1, 2, 3]], statics=number == 0) for number in range(40_000))

    def talk(connection):
        connection.sendall(hello(2, 5, 6) + data)
        connection.recv(4096)
        connection.recv(4096)

    device = client(script(talk).port, markers=("a",))
    device.connect()
    until(lambda: device.dropped == 40_000 - 16384, seconds=60)
    frames = device.frames()
    assert [frame.number for frame in frames] == list(range(40_000 - 16384 + 1, 40_001))


def test_unnamed_markers_are_all_of_the_subject(server, client, plant, until):
    """A rig that names no markers gets the server's."""
    device = client(server().port, markers=())
    device.connect()
    assert device.marker_names == plant.marker_names
    assert collect(device, until)[0].position_mm.shape == (34, 3)


def test_a_subject_that_is_not_there_is_named(server, client):
    """With those that there are, and what to do."""
    with pytest.raises(DeviceError) as error:
        client(server(subject="torso").port, markers=(), subject="haut").connect()
    assert str(error.value).startswith("mocap: subject is 'haut', and the server at 127.0.0.1:")
    assert str(error.value).endswith(" has 'torso': set `subject` to one of them")


def test_identity_lists_rate_subjects_and_axis(server, client):
    """The server is identified by its rate, its subjects and its vertical axis."""
    device = client(server(subject="torso").port)
    device.connect()
    identity = device.identify()
    assert identity.description == f"Vicon DataStream at 127.0.0.1:{device._options.port}, 200 Hz"
    assert identity.details == {"up": "z", "subject torso": "34 markers"}


def free_port():
    """A port on which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


def test_nothing_listens(client):
    """A port without a server is refused in one line that names device and address."""
    port = free_port()
    with pytest.raises(DeviceError) as error:
        client(port).connect()
    assert str(error.value) == (
        f"mocap: 127.0.0.1:{port} refuses the connection (nothing listens on that port; is the server running?)"
    )


def test_dead_host(client, monkeypatch):
    """A host that does not answer is given up after the timeout."""

    def nobody(address, timeout_s):
        raise TimeoutError

    monkeypatch.setattr(socket, "create_connection", nobody)
    with pytest.raises(DeviceError) as error:
        client(801, host="192.0.2.1").connect()
    assert str(error.value) == (
        "mocap: nothing answers at 192.0.2.1:801 within 1 s (is the address right, and the device switched on?)"
    )


def test_a_port_that_says_nothing(client, script):
    """A server that accepts and is silent is given up after the timeout."""
    server = script(lambda connection: connection.recv(1))
    with pytest.raises(DeviceError) as error:
        client(server.port, timeout_s=0.3).connect()
    assert str(error.value) == (
        f"mocap: 127.0.0.1:{server.port} accepts connections but sends no DataStream greeting within 0.3 s "
        "(is that the port of the DataStream server? Vicon's is 801)"
    )


def test_a_wrong_port(client, script):
    """A server of another kind is recognised by what it says."""
    server = script(lambda connection: connection.sendall(b"SSH-2.0-OpenSSH_9.6\r\n"))
    with pytest.raises(DeviceError) as error:
        client(server.port).connect()
    assert str(error.value) == (
        f"mocap: 127.0.0.1:{server.port} is no Vicon DataStream server: a packet begins with b'SSH-2.0-', "
        "not with 0x1a2b0001"
    )


def test_dribbled_bytes_arrive(client, script, until):
    """A server that sends seven bytes at a time is understood."""

    def talk(connection):
        stream = hello(2, 5, 6) + scene_frame(1, [[1, 2, 3]])
        for at in range(0, len(stream), 7):
            connection.sendall(stream[at : at + 7])
        connection.recv(4096)
        connection.recv(4096)

    device = client(script(talk).port, markers=("a",))
    device.connect()
    assert collect(device, until)[0].position_mm.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize("cut", [0, 1, 7, 8, 20, 31])
def test_unplugging_in_the_greeting(client, script, cut):
    """Cut off before the greeting is complete, connect says that the server hung up."""
    greeting = hello(2, 5, 6)
    assert cut < len(greeting)
    server = script(lambda connection: connection.sendall(greeting[:cut]))
    with pytest.raises(DeviceError) as error:
        client(server.port, markers=("a",)).connect()
    assert str(error.value) == f"mocap: 127.0.0.1:{server.port} closed the connection"


@pytest.mark.parametrize("cut", range(40, 900, 71))
def test_unplugging_in_the_stream(client, script, until, cut):
    """Cut off at any byte of the stream, the driver is back as soon as the server is."""
    stream = hello(2, 5, 6) + b"".join(scene_frame(n, [[1, 2, 3]]) for n in range(3))
    assert cut < len(stream)

    def talk(connection):
        connection.sendall(stream[:cut] if server.accepted == 1 else stream)
        connection.recv(4096)
        if server.accepted > 1:
            connection.recv(4096)

    server = script(talk)
    device = client(server.port, markers=("a",))
    device.connect()
    until(lambda: server.accepted == 2 and any(frame.number == 3 for frame in device.frames()))


def test_calls_before_connect_and_after_close(client, server):
    """Without a connection calls are refused; closing twice is allowed."""
    device = client(server().port)
    for call in (device.frames, device.identify):
        with pytest.raises(DeviceError, match=r"^mocap: not connected$"):
            call()
    device.connect()
    device.connect()
    device.close()
    device.close()
    with pytest.raises(DeviceError, match=r"^mocap: not connected$"):
        device.frames()


def test_settings_are_checked():
    """A setting that is wrong, or unknown, is named."""
    for settings, text in (
        ({"prot": 801}, "mocap: prot: Extra inputs are not permitted"),
        ({"up": "x"}, "mocap: up: Input should be 'y' or 'z'"),
    ):
        with pytest.raises(DeviceError) as error:
            build_device("vicon", settings, name="mocap", clock=RealClock())
        assert str(error.value) == text
    with pytest.raises(DeviceError) as error:
        build_device("optitrack", {}, name="mocap", clock=RealClock())
    assert str(error.value) == (
        "mocap: no kind of device is called 'optitrack' (there are openpneu, modbus, vicon, artec)"
    )


def test_object_numbers_are_vicons():
    """The numbers of the objects are those on the wire."""
    assert [CgObject.LABELED_RECONS, CgObject.PING, CgObject.CONTENTS] == [6, 42, 100004]
