"""The simulated DataStream server, as any client sees it: bytes, subscriptions, and Vicon's own client."""

import contextlib
import importlib.util
import socket
import struct
import subprocess
import sys

import numpy as np
import pytest

from labrig_drivers._cgstream import CgObject, PacketReader, block, blocks, packet
from labrig_drivers._cgstream_objects import decode_contents, decode_labeled, decode_set, decode_subject
from labrig_drivers.simulated import _vicon_server
from labrig_drivers.simulated._vicon_server import ViconServer

STATICS = {1, 2, 28, 37}


class RawClient:
    """A client of a few lines that keeps every packet as (object, payload) pairs."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), 5)
        self.socket.settimeout(5)
        self.reader = PacketReader()
        self.packets = []

    def send(self, number, payload):
        self.socket.sendall(packet([block(number, payload)]))

    def enable(self, *objects):
        self.send(100001, struct.pack(f"<{len(objects) + 1}I", len(objects), *objects))

    def next(self):
        while not self.packets:
            data = self.socket.recv(65536)
            assert data, "the server hung up"
            self.packets += [list(blocks(body)) for body in self.reader.feed(data)]
        return self.packets.pop(0)

    def next_with(self, number):
        while True:
            received = dict(self.next())
            if number in received:
                return received

    def close(self):
        self.socket.close()


@pytest.fixture
def server(shared, closing):
    return closing(ViconServer(shared, subject="torso", rate_hz=200.0).start())


@pytest.fixture
def client(server, closing):
    """A raw client that has read the greeting."""
    client = closing(RawClient(server.port))
    client.greeting = client.next()
    return client


def test_greeting_lists_what_is_supported(client):
    """On accept the server sends one ObjectEnums, sorted, before anything is asked."""
    ((number, payload),) = client.greeting
    assert number == 100001
    supported = struct.unpack(f"<{len(payload) // 4}I", payload)[1:]
    assert list(supported) == sorted(supported)
    assert set(supported) >= {1, 2, 5, 6, 7, 8, 9, 23, 26, 28, 36, 37, 39, 42, 901, 100004}
    assert decode_set(payload, "") == set(supported)


def test_push_sends_only_what_is_enabled(client, plant):
    """Frames carry the enabled objects, Contents first and true; statics come once, then as unchanged."""
    plant.occluded = {2}
    client.enable(1, 2, 5, 6, 37, 100004)
    client.send(100002, b"\x01")
    first = client.next_with(5)
    assert next(iter(first)) == 100004
    counts, unchanged = decode_contents(first[100004])
    assert counts == {1: 1, 2: 1, 5: 1, 6: 1, 37: 1}
    assert unchanged == set()
    assert first[1] == struct.pack("<q", 675000)  # 135e6 / 200 Hz
    subject = decode_subject(first[2])
    assert (subject.name, tuple(subject.markers.values())) == ("torso", plant.marker_names)
    assert subject.segments == {1: "torso"}  # a root segment of the subject's own name
    assert len(first[6]) == 4 + 33 * 116
    assert 3 not in decode_labeled(first[6])["marker"]  # occluded: absent
    second = client.next_with(5)
    counts, unchanged = decode_contents(second[100004])
    assert counts == {5: 1, 6: 1}
    assert unchanged == {1, 2, 37}
    assert struct.unpack("<I", second[5])[0] == struct.unpack("<I", first[5])[0] + 1


def test_a_changed_subscription_brings_the_statics_again(client):
    """After ObjectEnums with other objects the statics are sent anew."""
    client.enable(2, 5)
    client.send(100002, b"\x01")
    client.next_with(2)
    assert not STATICS & set(client.next_with(5))
    client.enable(2, 5, 6)
    assert {2, 5, 6} <= set(client.next_with(6))


def test_pull_sends_one_frame_for_each_request(client):
    """RequestFrame(0) and RequestNextFrame bring one frame each, and no more."""
    client.enable(5, 6)
    for number, payload in ((100002, b"\0"), (100008, struct.pack("<I", 1))):
        client.send(number, payload)
        assert 5 in dict(client.next())
        client.socket.settimeout(0.1)
        with pytest.raises(TimeoutError):
            client.next()
        client.socket.settimeout(5)


def test_pings_come_back(client):
    """A ping is echoed with its number, with the next frame or on its own."""
    client.send(42, struct.pack("<Q", 77))
    assert client.next() == [(42, struct.pack("<Q", 77))]
    client.enable(5, 42)
    client.send(100002, b"\x01")
    client.send(42, struct.pack("<Q", 78))
    assert client.next_with(42)[42] == struct.pack("<Q", 78)


@pytest.mark.parametrize(
    "nonsense",
    [b"GET / HTTP/1.1\r\n", bytes.fromhex("01002b1affffff7f"), packet([b"\x06\0\0\0\xff\xff\xff\xff"])],
)
def test_a_client_that_talks_nonsense_is_hung_up_on(server, client, closing, nonsense):
    """Nonsense ends that connection; the other ones go on."""
    with contextlib.closing(RawClient(server.port)) as other:
        other.next()
        other.socket.sendall(nonsense)
        with contextlib.suppress(ConnectionError):
            assert other.socket.recv(1000) == b""
    client.enable(5)
    client.send(100002, b"\x01")
    assert 5 in dict(client.next())


def test_a_client_that_does_not_read_costs_the_others_nothing(shared, closing, monkeypatch):
    """A client that stops reading loses whole frames; another one gets them all."""
    monkeypatch.setattr(_vicon_server, "MAX_LATE_FRAMES", 10**6)  # a busy machine is not what is tested
    server = closing(ViconServer(shared, rate_hz=400.0).start())
    lazy, keen = closing(RawClient(server.port)), closing(RawClient(server.port))
    for client in (lazy, keen):
        client.next()
        client.enable(*range(1, 50))
        client.send(100002, b"\x01")
    numbers = [struct.unpack("<I", keen.next_with(5)[5])[0] for _ in range(800)]
    assert np.all(np.diff(numbers) == 1)
    late = [struct.unpack("<I", lazy.next_with(5)[5])[0] for _ in range(400)]
    assert np.all(np.diff(late) >= 1)


def test_quick_connections_do_no_harm(server, client):
    """Clients that come and go at once leave the stream alone."""
    for _ in range(50):
        socket.create_connection(("127.0.0.1", server.port), 5).close()
    client.enable(5)
    client.send(100002, b"\x01")
    assert 5 in dict(client.next())


CONFORMANCE = """
import sys, motioncapture
capture = motioncapture.connect("vicon", {"hostname": sys.argv[1]})
for _ in range(20):
    capture.waitForNextFrame()
for name, body in capture.rigidBodies.items():
    print(name, *[f"{value:.6f}" for value in body.position], f"{body.rotation.w:.3f}")
"""


@pytest.mark.skipif(
    importlib.util.find_spec("motioncapture") is None, reason="motioncapture is not installed"
)
@pytest.mark.parametrize("up", ["z", "y"])
def test_vicons_own_client_reads_the_twin(shared, closing, plant, up):
    """The PyPI client with Vicon's SDK inside finds the subject where the plant has it, whichever axis is up."""
    server = closing(ViconServer(shared, subject="torso", rate_hz=100.0, up=up).start())
    # It cannot be interrupted when it hangs, so it runs where it can be killed.
    done = subprocess.run(
        [sys.executable, "-c", CONFORMANCE, f"127.0.0.1:{server.port}"],
        capture_output=True,
        text=True,
        timeout=180,
        check=True,
    )
    name, *numbers = done.stdout.split()
    assert name == "torso"
    assert [float(value) for value in numbers[:3]] == pytest.approx(
        plant.rest_mm.mean(axis=0) / 1000.0, abs=1e-5
    )
    assert float(numbers[3]) == pytest.approx(1.0, abs=1e-3)


def test_object_numbers():
    """Control objects have the numbers of the protocol."""
    assert (CgObject.REQUEST_FRAME, CgObject.REQUEST_NEXT_FRAME) == (100002, 100008)
