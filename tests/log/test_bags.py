"""Logs of messages: what is in a message becomes a column, whatever kind of number it is."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.log import import_guessed, write_dataset
from labrig.tables._bags import read_bag
from labrig.tables._mapping import Format

SET = np.repeat([0.0, 10.0, 30.0, 20.0], 15)
START_NS = 1_777_000_000_000_000_000


def write(name: str) -> Path:
    """An MCAP of protobuf messages: a time, a double, and counters of 64 bits, one of them in a message of its own."""
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2
    from mcap.writer import Writer

    file = descriptor_pb2.FileDescriptorProto(name="lab.proto", package="lab", syntax="proto3")
    file.dependency.append("google/protobuf/timestamp.proto")
    inner = file.message_type.add(name="Encoder")
    inner.field.add(name="counts", number=1, type=3, label=3)
    row = file.message_type.add(name="Row")
    row.field.add(name="stamp", number=1, type=11, label=1, type_name=".google.protobuf.Timestamp")
    row.field.add(name="p_set", number=2, type=1, label=1)
    row.field.add(name="steps", number=3, type=4, label=1)
    row.field.add(name="encoder", number=4, type=11, label=1, type_name=".lab.Encoder")
    clock = descriptor_pb2.FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(clock)
    files = descriptor_pb2.FileDescriptorSet(file=[clock, file])
    pool = descriptor_pool.DescriptorPool()
    for one in files.file:
        pool.Add(one)
    kind: Any = message_factory.GetMessageClass(pool.FindMessageTypeByName("lab.Row"))
    with Path(name).open("wb") as out:
        writer = Writer(out)
        writer.start()
        schema = writer.register_schema("lab.Row", "protobuf", files.SerializeToString())
        channel = writer.register_channel("/rig", "protobuf", schema)
        for k, p in enumerate(SET):
            message = kind(p_set=p, steps=int(100 * p + k), encoder={"counts": [int(-7 * p), k % 3]})
            message.stamp.FromNanoseconds(START_NS + k * 100_000_000)
            writer.add_message(channel, START_NS + k * 100_000_000, message.SerializeToString(), 0)
        writer.finish()
    return Path(name)


def test_numbers_of_64_bits(desk: Path) -> None:
    """Counters of 64 bits in protobuf are numbers, alone, in lists and in messages of their own; times are s."""
    run, guess, _ = import_guessed([write("t.mcap")], Path("run"))
    assert [o["column"] for o in guess.mapping["observables"]] == [
        "steps",
        "encoder.counts.0",
        "encoder.counts.1",
    ]
    seen = run["observed"].to_numpy().reshape(-1, 3)
    assert seen[:, 0] == pytest.approx(100 * SET + np.arange(len(SET)))
    assert seen[:, 1] == pytest.approx(-7 * SET)
    assert np.nanmax(run["time_s"].to_numpy()) == pytest.approx(0.1 * (len(SET) - 1), abs=1e-6)


def test_a_run_of_labrigs_own_is_no_table(make_lab, tmp_path: Path) -> None:
    """Its log is an MCAP file, too, and is not guessed at: the message says that it is a run already."""
    lab = make_lab(captures=3, repeats=False)
    run = write_dataset(lab.dataset(lab.predict(lab.u)), tmp_path / "recorded", run_yaml={})
    for given in (run, run / "log.000.mcap"):
        with pytest.raises(LabrigError) as caught:
            import_guessed([given], tmp_path / "again")
        assert str(caught.value) == f"{given} is a run already, with nothing to import: labrig show {given}"
    assert not list(tmp_path.glob("again*"))


def test_a_long_array_is_thinned_out_and_that_is_said(desk: Path) -> None:
    """Of a scanner's 1,081 ranges every third is read, from the first to the last; the guess says so."""
    from mcap.writer import Writer

    with Path("scan.mcap").open("wb") as out:
        writer = Writer(out)
        writer.start()
        channel = writer.register_channel("/scan", "json", 0)
        for k, p in enumerate(SET):
            message = {
                "p_set": p,
                "ranges": [p + place for place in range(1081)],
                "few": [p] * 512,
                "grid": [[p, 2 * p], [k, p]],
            }
            at_ns = START_NS + k * 100_000_000
            writer.add_message(channel, at_ns, json.dumps(message).encode(), 0)
        writer.finish()
    table = read_bag(Path("scan.mcap"), Format())
    ranges = [str(c) for c in table.frame.columns if str(c).startswith("ranges")]
    assert ranges == [f"ranges.{place}" for place in range(0, 1081, 3)]
    assert table.frame["ranges.1080"].to_numpy() == pytest.approx(SET + 1080)
    assert "few.511" in table.frame.columns
    said = "array 'ranges' has up to 1081 entries a message: one in 3 of the longest is read, 361 in all"
    assert table.said == (said,)
    _, guess, _ = import_guessed([Path("scan.mcap")], Path("run"))
    assert any(said in remark for remark in guess.remarks)
