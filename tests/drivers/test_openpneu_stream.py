"""Telemetry and replies of an OpenPneu board, told apart wherever they land."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrig_drivers._openpneu_stream import MAX_LINE_BYTES, Reply, StreamParser, Telemetry, telemetry_line

VALUES = (0.0, -12.34, 100.0, 5.5, 1.0, 2.0, 3.0, 4.0, 5.0, 60.25)
LINE = b"T0.00,-12.34,100.00,5.50,1.00,2.00,3.00,4.00,5.00,60.25;\r\n"


def test_telemetry_is_byte_exact():
    """The firmware's line is what the twin prints and the driver reads."""
    assert telemetry_line(VALUES) == LINE
    assert StreamParser().feed(LINE) == [Telemetry(VALUES)]


@pytest.mark.parametrize("reply", [b"Timer Starts...\r\n", b"OK;Successful\r\n", b"TTT\r\n", b"T1.0,2\r\n"])
def test_telemetry_inside_a_reply_at_every_place(reply):
    """Telemetry may land anywhere in a reply, between its CR and LF too, and both come out whole."""
    text = Reply(reply.decode().strip())
    for at in range(len(reply)):
        events = StreamParser().feed(reply[:at] + LINE + reply[at:])
        assert events == [Telemetry(VALUES), text], at
    assert StreamParser().feed(reply + LINE) == [text, Telemetry(VALUES)]


def test_two_lines_of_telemetry_in_one_reply():
    """More than one line may land in one reply."""
    events = StreamParser().feed(b"Stop All" + LINE + LINE + b" Motors\r\n")
    assert events == [Telemetry(VALUES), Telemetry(VALUES), Reply("Stop All Motors")]


def test_a_lost_byte_makes_no_pressure_that_nobody_measured():
    """Whichever byte of a line the link loses: a run does not end for 1234 kPa where there were 12.34."""
    for at in range(len(LINE)):
        events = StreamParser().feed(LINE[:at] + LINE[at + 1 :] + LINE)
        measured = [event for event in events if isinstance(event, Telemetry)]
        assert measured
        assert all(abs(value) <= 100.0 for event in measured for value in event.pressure_kpa)


def test_values_that_are_no_numbers():
    """What the firmware prints for no number becomes NaN; a line with other words is no telemetry."""
    line = LINE.replace(b"100.00", b"nan").replace(b"5.50", b"ovf")
    (event,) = StreamParser().feed(line)
    assert isinstance(event, Telemetry)
    assert [math.isnan(value) for value in event.pressure_kpa] == [False, False, True, True] + [False] * 6
    assert StreamParser().feed(LINE.replace(b"5.50", b"5a0")) == [
        Reply(LINE.replace(b"5.50", b"5a0").decode().strip())
    ]


@pytest.mark.parametrize("bad", [LINE.replace(b",60.25", b""), LINE.replace(b";", b",1;"), b"T;\r\n"])
def test_a_wrong_number_of_values_is_no_telemetry(bad):
    """Nine, eleven or no values are a line like any other."""
    assert StreamParser().feed(bad) == [Reply(bad.decode().strip())]


def test_long_lines_are_cut():
    """A flood without line ends passes in pieces; little is held."""
    parser = StreamParser()
    events = parser.feed(b"x" * 10_000)
    assert events == [Reply("x" * MAX_LINE_BYTES)] * (10_000 // MAX_LINE_BYTES)
    assert len(parser._line) < MAX_LINE_BYTES
    parser.feed(b"T" + b"1" * 10_000)
    assert len(parser._line) + len(parser._candidate) < 2 * MAX_LINE_BYTES


@settings(max_examples=300)
@given(st.lists(st.one_of(st.binary(max_size=60), st.just(LINE), st.sampled_from([b"T", b";\r\n", b"\n"]))))
def test_any_bytes_in_any_pieces(pieces):
    """Whatever arrives, cut in any way, gives the same events and holds less than a kilobyte."""
    whole = StreamParser().feed(b"".join(pieces))
    parser = StreamParser()
    assert [event for piece in pieces for event in parser.feed(piece)] == whole
    assert len(parser._line) + len(parser._candidate) < 1000


@settings(max_examples=100)
@given(
    st.lists(st.floats(-999, 999), min_size=10, max_size=10),
    st.text("OKSelct 1234=.T;,", min_size=1),
    st.data(),
)
def test_any_reply_and_any_telemetry(values, reply, data):
    """Any telemetry inside any reply that holds none itself is found, and the reply is left whole."""
    reply = reply.strip() or "OK"
    at = data.draw(st.integers(0, len(reply)))
    line = telemetry_line(tuple(values))
    events = StreamParser().feed(reply[:at].encode() + line + reply[at:].encode() + b"\r\n")
    assert Reply(reply) in events
    (found,) = [event for event in events if isinstance(event, Telemetry)]
    assert found.pressure_kpa == pytest.approx(values, abs=0.005001)
