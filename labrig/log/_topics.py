"""The topics of a log: fixed numbers, so that a log whose first bytes are damaged can still be read."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Any


class Topic(IntEnum):
    """A topic's number is its channel and schema id in every log that labrig writes."""

    COMMAND = 1
    MEASURED = 2
    MARKERS = 3
    OBSERVATION = 4
    CAPTURE = 5
    STEP = 6
    PLAN = 7
    EVENTS = 8
    SCAN = 9
    ENVIRONMENT = 10
    PREDICTION = 11
    RESIDUAL = 12
    TABLE = 13


@dataclass(frozen=True)
class TopicInfo:
    """A topic's name in the log and the class of its messages."""

    name: str
    message: Any


def topic_table() -> dict[Topic, TopicInfo]:
    """Every topic with its name and message class; imports the generated code on first use."""
    from foxglove_schemas_protobuf.Log_pb2 import Log
    from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

    from labrig_schema import model_pb2, observation_pb2, pressure_pb2, scan_pb2, step_pb2, table_pb2

    return {
        Topic.COMMAND: TopicInfo("/pressure/command", pressure_pb2.PressureCommand),
        Topic.MEASURED: TopicInfo("/pressure/measured", pressure_pb2.PressureMeasured),
        Topic.MARKERS: TopicInfo("/mocap/markers", PointCloud),
        Topic.OBSERVATION: TopicInfo("/observation", observation_pb2.Observation),
        Topic.CAPTURE: TopicInfo("/capture", step_pb2.Capture),
        Topic.STEP: TopicInfo("/step", step_pb2.Step),
        Topic.PLAN: TopicInfo("/plan", step_pb2.Plan),
        Topic.EVENTS: TopicInfo("/events", Log),
        Topic.SCAN: TopicInfo("/scan/mesh", scan_pb2.ScanMesh),
        Topic.ENVIRONMENT: TopicInfo("/environment", observation_pb2.Environment),
        Topic.PREDICTION: TopicInfo("/model/prediction", model_pb2.MarkerVectors),
        Topic.RESIDUAL: TopicInfo("/model/residual", model_pb2.MarkerVectors),
        Topic.TABLE: TopicInfo("/table", table_pb2.TableBlock),
    }


def descriptor_set(message: Any) -> bytes:
    """The message's .proto file and everything that it imports, as MCAP wants a protobuf schema."""
    from google.protobuf.descriptor_pb2 import FileDescriptorSet

    files = FileDescriptorSet()
    for file in _with_imports(message.DESCRIPTOR.file, set()):
        file.CopyToProto(files.file.add())
    return files.SerializeToString()


def _with_imports(file: Any, seen: set[str]) -> Iterator[Any]:
    if file.name in seen:
        return
    seen.add(file.name)
    for imported in file.dependencies:
        yield from _with_imports(imported, seen)
    yield file
