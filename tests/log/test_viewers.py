"""Viewers open a log as it is: the mcap library's own reader and rerun's loader find everything in it."""

from collections import Counter
from pathlib import Path
from typing import Any

from mcap.reader import make_reader


def _topics(path: Path) -> Counter[str]:
    with path.open("rb") as file:
        found = make_reader(file, validate_crcs=True).iter_messages()
        return Counter(channel.topic for _, channel, _ in found)


def test_schemas_are_complete(small_log) -> None:
    """A reader that knows nothing of labrig decodes every message from the schemas in the file."""
    from google.protobuf.descriptor_pb2 import FileDescriptorSet
    from google.protobuf.descriptor_pool import DescriptorPool
    from google.protobuf.message_factory import GetMessageClass

    decoded: Counter[str] = Counter()
    with (small_log.folder / "log.000.mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            pool = DescriptorPool()
            for proto in FileDescriptorSet.FromString(schema.data).file:
                pool.Add(proto)
            kind: Any = GetMessageClass(pool.FindMessageTypeByName(schema.name))
            text = kind.FromString(message.data)
            assert text.timestamp.seconds > 1_700_000_000
            decoded[channel.topic] += 1
    assert decoded["/mocap/markers"] == 120
    assert decoded["/pressure/measured"] == 120


def test_a_chunk_is_a_mebibyte_at_most(tmp_path: Path) -> None:
    """What a power cut can cost before a step is done is bounded."""
    import numpy as np

    from labrig.log import Layout, LogWriter
    from labrig_drivers import MarkerFrame

    names = tuple(f"m{index}" for index in range(34))
    writer = LogWriter(tmp_path / "log.000.mcap", Layout(("c1",), (0.0,), (1.0,), markers=names))
    rng = np.random.default_rng(0)
    for number in range(6000):
        writer.frame(MarkerFrame(1.0 + number, number, rng.normal(size=(34, 3)), np.zeros(34, np.int8)))
    writer.close()
    with (tmp_path / "log.000.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    sizes = [chunk.uncompressed_size for chunk in summary.chunk_indexes]
    assert len(sizes) > 3
    assert max(sizes) <= 1024 * 1024


def test_rerun_shows_every_topic(small_log) -> None:
    """rerun's own MCAP loader makes an entity of each topic with a row for each message, markers as 3D points."""
    from rerun.chunk import McapReader

    path = small_log.folder / "log.000.mcap"
    rows: Counter[str] = Counter()
    columns: dict[str, set[str]] = {}
    for chunk in McapReader(path).stream():
        entity = str(chunk.entity_path)
        rows[entity] += 0 if chunk.is_static else chunk.num_rows
        columns.setdefault(entity, set()).update(field.name for field in chunk.to_record_batch().schema)
    for topic, count in _topics(path).items():
        assert rows[topic] == count, topic
    assert "Points3D:positions" in columns["/mocap/markers"]
    assert "labrig.PressureMeasured:message" in columns["/pressure/measured"]
