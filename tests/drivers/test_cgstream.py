"""The DataStream codec, byte for byte, without a socket."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrig_drivers._cgstream import CgObject, CgstreamError, PacketReader, block, blocks, packet
from labrig_drivers._cgstream_session import MAX_BAD_PACKETS, ClientSession
from labrig_drivers.simulated._vicon_encode import Scene, contents

HELLO = bytes.fromhex(
    "01002b1a 1c000000  a1860100 14000000 04000000 02000000 05000000 06000000 a4860100".replace(" ", "")
)
REQUEST = bytes.fromhex("01002b1a09000000a28601000100000001")
FRAME = bytes.fromhex(
    (
        "01002b1a 0c010000"
        "a4860100 20000000 03000000 02000000 01000000 05000000 01000000 06000000 01000000 00000000"
        "05000000 04000000 29000000"
        "02000000 50000000 01000000 03000000 61726d 01000000 00000000 01000000"
        + 24
        * "00"
        + "03000000 61726d"
        "01000000 01000000 02000000 6d31 01000000 01000000 01000000"
        "06000000 78000000 01000000 01000000 01000000 0000000000001c40"
        "0000000000005940 00000000008034c0 0000000000428f40" + 72 * "00" + "09000000"
    ).replace(" ", "")
)


def greeted(*objects):
    """A session whose subscription to `objects` has taken effect."""
    session = ClientSession()
    numbers = struct.pack(f"<{len(objects) + 1}I", len(objects), *objects)
    session.receive(packet([block(CgObject.OBJECT_ENUMS, numbers)]))
    session.outgoing()
    session.accept_all()
    return session


def test_smallest_session_is_byte_exact():
    """The client answers the published smallest greeting with the published bytes, and reads its frame."""
    session = ClientSession()
    assert session.receive(HELLO) == []
    assert session.outgoing() == HELLO + REQUEST
    (frame,) = session.receive(FRAME)
    assert frame.number == 42
    assert frame.labeled["position"].tolist() == [[100.0, -20.5, 1000.25]]
    assert frame.labeled["trajectory"].tolist() == [9]
    subject = frame.statics.subjects[1]
    assert (subject.name, subject.markers, subject.segments) == ("arm", {1: "m1"}, {1: "arm"})
    assert subject.parents == {1: 0}
    assert session.outgoing() == b""  # the server offers no Ping, so none is sent


@pytest.mark.parametrize("size", [1, 7, 64])
def test_pieces_of_any_size_give_the_same(size):
    """Bytes that dribble in give the frames that they give at once."""
    session = ClientSession()
    stream = HELLO + FRAME + FRAME
    frames = [
        frame for at in range(0, len(stream), size) for frame in session.receive(stream[at : at + size])
    ]
    assert [frame.number for frame in frames] == [42, 42]


def test_unknown_objects_and_keep_alive_are_skipped():
    """Objects that labrig does not know, and KeepAlive packets, disturb nothing."""
    session = greeted(5, 6)
    strange = [
        block(777, b"??"),
        block(4_000_000_000, b""),
        block(5, struct.pack("<I", 6)),
        block(12, b"xyz"),
    ]
    assert session.receive(packet([block(CgObject.KEEP_ALIVE, b"")])) == []
    assert [frame.number for frame in session.receive(packet(strange))] == [7]


def test_bad_magic_is_named():
    """A stream that is not CGStream says what it begins with."""
    with pytest.raises(CgstreamError) as error:
        PacketReader().feed(b"HTTP/1.1 400 Bad Request\r\n")
    assert str(error.value) == "a packet begins with b'HTTP/1.1', not with 0x1a2b0001"


def test_absurd_length_is_refused_before_it_is_awaited():
    """A packet of 2 GB is refused at its header, so nothing is kept for it."""
    reader = PacketReader()
    with pytest.raises(CgstreamError) as error:
        reader.feed(bytes.fromhex("01002b1affffff7f"))
    assert str(error.value) == "a packet of 2147483647 bytes is above the cap of 4194304"


def test_truncated_block_costs_one_packet():
    """A block that overruns its packet is left out with it; the next packet is read."""
    session = greeted(5, 6)
    cut = struct.pack("<IIII", 0x1A2B0001, 8, 6, 5000)
    good = packet([block(5, struct.pack("<I", 1))])
    assert [frame.number for frame in session.receive(cut + good)] == [2]
    assert session.bad_packets == 1


def test_nothing_but_bad_packets_is_an_error():
    """A server that only sends damaged packets is given up, with the reason."""
    session = greeted(5, 6)
    cut = struct.pack("<IIII", 0x1A2B0001, 8, 6, 5000)
    with pytest.raises(CgstreamError) as error:
        session.receive(cut * MAX_BAD_PACKETS)
    assert str(error.value) == "block 6 claims 5000 bytes, its packet has 0 left"


@pytest.mark.parametrize("payload", [b"\xff" * 4, b"\x01\x00\x00", b""])
@pytest.mark.parametrize("number", [2, 6, 7, 26, 100004])
def test_counts_beyond_the_payload_are_refused(number, payload):
    """A payload that claims four thousand million items, or is too short, is a bad packet, not a hang."""
    session = greeted(2, 5, 6, 7, 26, 100004)
    assert session.receive(packet([block(number, payload)])) == []
    assert session.bad_packets == 1


@pytest.mark.parametrize(("number", "needed"), [(1, 8), (5, 4), (23, 17), (36, 4), (37, 1)])
def test_payloads_of_fixed_size_may_not_be_shorter(number, needed):
    """A payload one byte short is a bad packet, one of the right size is not."""
    session = greeted(1, 5, 23, 36, 37)
    session.receive(packet([block(number, bytes(needed - 1))]))
    assert session.bad_packets == 1
    session.receive(packet([block(number, bytes(needed))]))
    assert session.bad_packets == 1


def test_subjects_without_end_are_refused():
    """A packet full of subjects is a bad packet, not a heap of memory."""
    session = greeted(2, 5)
    info = [block(2, struct.pack("<6I", n, 0, 0, 0, 0, 0)) for n in range(1001)]
    session.receive(packet(info[:1000]))
    assert (session.bad_packets, len(session.statics.subjects)) == (0, 1000)
    session.receive(packet(info))
    assert session.bad_packets == 1


def test_packet_without_dynamic_object_makes_no_frame():
    """Statics and pings alone are no frame."""
    session = greeted(1, 2, 5, 6)
    statics = Scene("arm", ("m1",)).static_blocks()
    assert session.receive(packet([*statics.values(), block(CgObject.PING, bytes(8))])) == []
    assert session.statics.rate_hz == 100.0
    assert session.pings_echoed == 1


def test_statics_are_replaced_unless_declared_unchanged():
    """A packet with one static object drops the other ones, unless Contents lists them as unchanged."""
    statics = Scene("arm", ("m1",), rate_hz=250.0).static_blocks()
    session = greeted(1, 2, 5, 6, 37, 100004)
    session.receive(packet(statics.values()))
    kept = block(CgObject.CONTENTS, contents({37: 1}, [CgObject.STREAM_INFO, CgObject.SUBJECT_INFO]))
    session.receive(packet([kept, block(37, b"\x01")]))
    assert session.statics.y_up
    assert session.statics.rate_hz == 250.0
    assert session.statics.subjects[1].markers == {1: "m1"}
    session.receive(packet([block(37, b"\x00")]))
    assert not session.statics.subjects
    assert np.isnan(session.statics.rate_hz)


def test_unchanged_markers_are_carried_over():
    """Labelled markers that Contents declares unchanged stay those of the frame before."""
    session = ClientSession()
    session.receive(HELLO + FRAME)
    again = [block(100004, contents({5: 1}, [2, 6])), block(5, struct.pack("<I", 50))]
    (frame,) = session.receive(packet(again))
    assert frame.labeled["position"].tolist() == [[100.0, -20.5, 1000.25]]
    assert CgObject.LABELED_RECONS in frame.types


def test_frames_from_before_the_subscription_are_dropped():
    """Until the requested types appear frames are dropped: every marker would look occluded in them."""
    session = ClientSession()
    session.receive(HELLO)
    early = packet([block(5, struct.pack("<I", 1))])
    assert session.receive(early + early) == []
    assert (session.dropped, session.waiting) == (2, True)
    assert [frame.number for frame in session.receive(FRAME)] == [42]
    session.outgoing()
    session.subscribe([5, 6])
    assert session.waiting
    assert session.outgoing() == packet([block(100001, struct.pack("<3I", 2, 5, 6))])


@pytest.mark.parametrize(
    ("mode", "request_bytes"),
    [
        ("pull", packet([block(CgObject.REQUEST_FRAME, b"\x00")])),
        ("prefetch", packet([block(CgObject.REQUEST_NEXT_FRAME, struct.pack("<I", 1))])),
    ],
)
def test_pull_modes_ask_for_each_frame(mode, request_bytes):
    """In pull and prefetch mode each frame is asked for, the first right after the subscription."""
    session = ClientSession(mode=mode)
    session.receive(HELLO)
    assert session.outgoing() == HELLO + request_bytes
    session.receive(FRAME)
    assert session.outgoing() == request_bytes


def test_ping_follows_each_frame_where_the_server_knows_pings():
    """The client pings after each frame, counting up, if the server offers Ping."""
    session = greeted(5, 42)
    frame = packet([block(5, struct.pack("<I", 1))])
    session.receive(frame + frame)
    assert session.outgoing() == b"".join(packet([block(42, struct.pack("<Q", n))]) for n in (1, 2))


def test_latency_is_summed_and_nonsense_is_none():
    """The latency is the sum of its parts; one that is negative or no number counts as none."""
    session = greeted(5, 26)
    for value, expected in ((0.004, 0.0055), (float("nan"), 0.0), (-5.0, 0.0)):
        parts = struct.pack("<I", 2) + b"\x01\0\0\0a" + struct.pack("<d", value)
        parts += b"\x01\0\0\0b" + struct.pack("<d", 0.0015)
        (frame,) = session.receive(packet([block(5, bytes(4)), block(26, parts)]))
        assert frame.latency_s == pytest.approx(expected)


def test_timecode_and_hardware_frame_are_read():
    """Timecode and the hardware's frame number come out as they were sent."""
    session = greeted(5, 23, 36)
    timecode = struct.pack("<BBBBHHIIB", 13, 59, 1, 24, 2, 4, 1, 77, 1)
    (frame,) = session.receive(
        packet([block(5, bytes(4)), block(23, timecode), block(36, struct.pack("<I", 12345))])
    )
    assert frame.hardware_number == 12345
    assert frame.timecode is not None
    assert (frame.timecode.hours, frame.timecode.frames, frame.timecode.subframes_per_frame) == (13, 24, 4)
    assert (frame.timecode.standard, frame.timecode.user_bits, frame.timecode.field) == (1, 77, 1)


@settings(max_examples=200)
@given(st.lists(st.binary(max_size=200), max_size=8))
def test_any_bytes_end_in_frames_or_in_a_clear_error(pieces):
    """Whatever arrives, the session returns or raises CgstreamError, and holds no more than it was given."""
    session = ClientSession()
    for piece in pieces:
        try:
            session.receive(piece)
        except CgstreamError:
            return
    assert session._reader.pending_bytes <= sum(map(len, pieces))


@settings(max_examples=100)
@given(
    st.lists(st.tuples(*[st.floats(-1e6, 1e6)] * 3), max_size=40),
    st.integers(0, 2**32 - 2),
    st.text("abcäö_0", max_size=8),
    st.integers(1, 300),
)
def test_what_the_twin_encodes_the_client_decodes(positions, number, subject, size):
    """A scene of any markers passes through encoder, cutter and decoder unchanged."""
    names = tuple(f"m{index}" for index in range(len(positions)))
    scene = Scene(subject, names)
    made = scene.frame_blocks(number, np.array(positions, float).reshape(-1, 3), 0.0)
    session = greeted(1, 2, 5, 6, 7, 23, 26, 36, 37)
    stream = packet([*scene.static_blocks().values(), *made.values()])
    frames = [f for at in range(0, len(stream), size) for f in session.receive(stream[at : at + size])]
    assert [frame.number for frame in frames] == [number + 1]
    np.testing.assert_array_equal(
        frames[0].labeled["position"].reshape(-1, 3), np.reshape(positions, (-1, 3))
    )
    assert tuple(frames[0].statics.subjects[1].markers.values()) == names
    assert frames[0].statics.subjects[1].name == subject


def test_blocks_leave_no_rest():
    """Bytes after the last block that are no block are an error."""
    with pytest.raises(CgstreamError) as error:
        list(blocks(block(5, b"1234") + b"xyz"))
    assert str(error.value) == "3 bytes are left after the last block"
