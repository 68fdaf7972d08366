"""Logs of messages: MCAP (JSON, protobuf, ROS) and ROS bags; each topic is a table with its own clock.

Columns are the numbers in a topic's messages by the path to them, and `log_time_s`, when each was logged.
"""

import json
from collections.abc import Iterator, Mapping
from itertools import starmap
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._extras import missing
from labrig.tables._mapping import Format
from labrig.tables._table import Table

_MCAP = b"\x89MCAP"
CLOCK = "log_time_s"
_WIDEST = 512
"""Numbers of one array, at most: longer ones are thinned out."""
_DEEPEST = 8


def topics(path: Path) -> dict[str, int]:
    """The topics of a log and how many messages each has."""
    if _is_mcap(path):
        from mcap.reader import make_reader

        with path.open("rb") as file:
            summary = make_reader(file).get_summary()
            if summary is not None and summary.statistics is not None:
                count = summary.statistics.channel_message_counts
                out: dict[str, int] = {}
                for number, channel in summary.channels.items():
                    out[channel.topic] = out.get(channel.topic, 0) + count.get(number, 0)
                return out
        out = {}
        for topic, _, _ in _mcap_messages(path, None):
            out[topic] = out.get(topic, 0) + 1
        return out
    with _ros_reader(path) as reader:
        return {topic: info.msgcount for topic, info in reader.topics.items()}


def read_bag(path: Path, how: Format) -> Table:
    """Read the topic `part`, else the one with most messages; raises `LabrigError` if it has no numbers."""
    import numpy as np
    import pandas as pd

    known = topics(path)
    if not known:
        raise LabrigError(f"{path}: has no messages")
    if how.part is not None and how.part not in known:
        raise LabrigError(f"{path}: has no topic {how.part!r}; it has {', '.join(known)}")
    topic = how.part or max(known, key=lambda name: known[name])
    messages = _mcap_messages(path, topic) if _is_mcap(path) else _ros_messages(path, topic)
    clock, rows = [], []
    long: dict[str, int] = {}
    for _, time_ns, message in messages:
        clock.append(time_ns)
        rows.append(dict(_numbers("", message, 0, long)))
    if not rows or not any(rows):
        raise LabrigError(f"{path}: the messages of {topic} hold no numbers that could be columns")
    stamps = np.array(clock, dtype=np.int64)
    order = np.argsort(stamps, kind="stable")
    frame = pd.DataFrame(rows).iloc[order].reset_index(drop=True)
    frame.insert(0, CLOCK, (stamps[order] - stamps.min()) * 1e-9 + stamps.min() * 1e-9)
    return Table(path, frame, 1, ".", "message", said=tuple(starmap(_thinned, long.items())))


def _is_mcap(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(_MCAP)) == _MCAP


def _thinned(name: str, length: int) -> str:
    return (
        f"array {name!r} has up to {length} entries a message: one in {_every(length)} of the longest is read, "
        f"{len(range(0, length, _every(length)))} in all"
    )


def _every(length: int) -> int:
    return -(-length // _WIDEST)


def _numbers(name: str, value: Any, depth: int, long: dict[str, int]) -> Iterator[tuple[str, float]]:
    """The numbers within a message and the paths to them; arrays that are thinned out, and their length, to `long`."""
    if isinstance(value, bool | int | float):
        yield name, float(value)
    elif depth >= _DEEPEST or value is None or isinstance(value, str | bytes):
        return
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(f"{name}.{key}" if name else str(key), inner, depth + 1, long)
    elif hasattr(value, "__dataclass_fields__"):
        for key in value.__dataclass_fields__:
            if not key.startswith("__"):
                yield from _numbers(f"{name}.{key}" if name else key, getattr(value, key), depth + 1, long)
    elif hasattr(value, "tolist") and not hasattr(value, "__len__"):
        yield from _numbers(name, value.tolist(), depth, long)
    elif isinstance(value, list | tuple) or hasattr(value, "tolist"):
        every = max(_every(len(value)), 1)
        if every > 1:
            long[name] = max(len(value), long.get(name, 0))
        kept: Any = value[::every]
        for i, inner in enumerate(kept.tolist() if hasattr(kept, "tolist") else kept):
            yield from _numbers(f"{name}.{i * every}", inner, depth + 1, long)


def _mcap_messages(path: Path, topic: str | None) -> Iterator[tuple[str, int, Any]]:
    """Topic, time (ns) and content of the messages of a topic, or of all."""
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    decoders: dict[int, Any] = {}
    try:
        with path.open("rb") as file:
            for schema, channel, message in make_reader(file).iter_messages(
                topics=None if topic is None else [topic]
            ):
                if topic is None:
                    yield channel.topic, message.log_time, None
                    continue
                if channel.id not in decoders:
                    decoders[channel.id] = _decoder(path, channel.topic, channel.message_encoding, schema)
                yield channel.topic, message.log_time, decoders[channel.id](message.data)
    except McapError as error:
        raise LabrigError(f"{path}: can't be read as MCAP ({error or type(error).__name__})") from None


def _decoder(path: Path, topic: str, encoding: str, schema: Any) -> Any:
    if encoding == "json":
        return json.loads
    if encoding == "protobuf" and schema is not None:
        return _protobuf(schema)
    if encoding in {"cdr", "ros1"} and schema is not None:
        return _ros(schema, encoding)
    raise LabrigError(f"{path}: the messages of {topic} are written as {encoding!r}, which labrig can't read")


def _protobuf(schema: Any) -> Any:
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))

    return lambda data: _plain(kind.FromString(data))


def _plain(value: Any) -> Any:
    """A message as dicts and lists by the names of its fields; times are in s.

    Fields that are not set, and enumerations, are left out.
    Protobuf's own way to JSON writes whole numbers of 64 bits, such as counters and clocks, as text.
    """
    from google.protobuf import json_format
    from google.protobuf.message import Message

    if isinstance(value, Message):
        kind = value.DESCRIPTOR
        fields = [f for f in kind.fields if f.type != f.TYPE_ENUM]
        if kind.file.name == "google/protobuf/struct.proto":
            return json_format.MessageToDict(value)
        if kind.file.name == "google/protobuf/wrappers.proto":
            return value.value  # type: ignore[attr-defined]
        if kind.full_name in {"google.protobuf.Timestamp", "google.protobuf.Duration"}:
            return value.seconds + 1e-9 * value.nanos  # type: ignore[attr-defined]
        given = [f.name for f in fields if not f.has_presence or value.HasField(f.name)]
        return {name: _plain(getattr(value, name)) for name in given}
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, bool | int | float | str | bytes):
        return value
    return [_plain(one) for one in value]


def _ros(schema: Any, encoding: str) -> Any:
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise missing("reading messages of ROS", "ros") from None
    store = get_typestore(Stores.EMPTY)
    known: dict[str, Any] = {}
    text = schema.data.decode()
    first, *others = text.split("=" * 80 + "\n")
    known.update(get_types_from_msg(first, schema.name))
    for other in others:
        head, _, body = other.partition("\n")
        known.update(get_types_from_msg(body, head.removeprefix("MSG: ").strip()))
    store.register(known)
    name = schema.name if "/msg/" in schema.name else schema.name.replace("/", "/msg/")
    if encoding == "ros1":
        return lambda data: store.deserialize_ros1(data, name)
    return lambda data: store.deserialize_cdr(data, name)


def _ros_reader(path: Path) -> Any:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing("reading ROS bags", "ros") from None
    folder = path.parent if path.suffix == ".db3" else path
    return AnyReader([folder], default_typestore=get_typestore(Stores.LATEST))


def _ros_messages(path: Path, topic: str) -> Iterator[tuple[str, int, Any]]:
    with _ros_reader(path) as reader:
        chosen = [c for c in reader.connections if c.topic == topic]
        for connection, time_ns, data in reader.messages(connections=chosen):
            yield topic, time_ns, reader.deserialize(data, connection.msgtype)
