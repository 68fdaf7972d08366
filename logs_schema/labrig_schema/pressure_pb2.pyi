import datetime

from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PressureCommand(_message.Message):
    __slots__ = ("timestamp", "setpoint", "event", "reason", "time_s", "session")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    SETPOINT_FIELD_NUMBER: _ClassVar[int]
    EVENT_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    TIME_S_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    setpoint: _containers.RepeatedScalarFieldContainer[float]
    event: bool
    reason: str
    time_s: float
    session: str
    def __init__(self, timestamp: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., setpoint: _Optional[_Iterable[float]] = ..., event: _Optional[bool] = ..., reason: _Optional[str] = ..., time_s: _Optional[float] = ..., session: _Optional[str] = ...) -> None: ...

class PressureMeasured(_message.Message):
    __slots__ = ("timestamp", "pressure")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    PRESSURE_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    pressure: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, timestamp: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., pressure: _Optional[_Iterable[float]] = ...) -> None: ...
