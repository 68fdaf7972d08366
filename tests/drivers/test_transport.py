"""A TCP link sends all of it or says why not, and a peer that hung up is not one that is silent."""

import socket
import threading

import pytest

from labrig_drivers._transport import LinkError, TcpLink

MANY_BYTES = 32_000_000
"""More than any system keeps for a peer that does not read."""


@pytest.fixture
def ends():
    """A link, and the other end of it."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        link = TcpLink("127.0.0.1", listener.getsockname()[1], timeout_s=0.5)
        peer, _ = listener.accept()
    yield link, peer
    link.close()
    peer.close()


def test_a_peer_that_hung_up_is_lost(ends):
    """The end of the stream is an error, not an empty answer; silence is an empty answer."""
    link, peer = ends
    assert link.read(0.0) == b""
    peer.sendall(b"last words")
    peer.close()
    assert link.read(5.0) == b"last words"
    with pytest.raises(LinkError, match=r"^127\.0\.0\.1:\d+ closed the connection$"):
        link.read(5.0)


def test_a_long_write_arrives_whole(ends):
    """Every byte, though the peer takes them in parts."""
    link, peer = ends
    received = []

    def read():
        while data := peer.recv(65536):
            received.append(len(data))

    reader = threading.Thread(target=read)
    reader.start()
    try:
        link._timeout_s = 30.0
        link.write(bytes(MANY_BYTES))
    finally:
        link.close()
        reader.join()
    assert sum(received) == MANY_BYTES


def test_a_peer_that_does_not_read_is_given_up(ends):
    """A write is bounded in time."""
    link, _ = ends
    with pytest.raises(LinkError, match=r"^127\.0\.0\.1:\d+ does not take what is sent to it$"):
        link.write(bytes(MANY_BYTES))
