import datetime

from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class TableBlock(_message.Message):
    __slots__ = ("timestamp", "row_capture", "time_s", "hold_s", "settled", "measured", "observed", "covariates", "position_mm", "label", "setpoint", "event", "session", "repeat", "segment", "event_time_s", "event_setpoint", "event_session", "capture_number", "event_number")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    ROW_CAPTURE_FIELD_NUMBER: _ClassVar[int]
    TIME_S_FIELD_NUMBER: _ClassVar[int]
    HOLD_S_FIELD_NUMBER: _ClassVar[int]
    SETTLED_FIELD_NUMBER: _ClassVar[int]
    MEASURED_FIELD_NUMBER: _ClassVar[int]
    OBSERVED_FIELD_NUMBER: _ClassVar[int]
    COVARIATES_FIELD_NUMBER: _ClassVar[int]
    POSITION_MM_FIELD_NUMBER: _ClassVar[int]
    LABEL_FIELD_NUMBER: _ClassVar[int]
    SETPOINT_FIELD_NUMBER: _ClassVar[int]
    EVENT_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    REPEAT_FIELD_NUMBER: _ClassVar[int]
    SEGMENT_FIELD_NUMBER: _ClassVar[int]
    EVENT_TIME_S_FIELD_NUMBER: _ClassVar[int]
    EVENT_SETPOINT_FIELD_NUMBER: _ClassVar[int]
    EVENT_SESSION_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_NUMBER_FIELD_NUMBER: _ClassVar[int]
    EVENT_NUMBER_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    row_capture: _containers.RepeatedScalarFieldContainer[int]
    time_s: _containers.RepeatedScalarFieldContainer[float]
    hold_s: _containers.RepeatedScalarFieldContainer[float]
    settled: _containers.RepeatedScalarFieldContainer[bool]
    measured: _containers.RepeatedScalarFieldContainer[float]
    observed: _containers.RepeatedScalarFieldContainer[float]
    covariates: _containers.RepeatedScalarFieldContainer[float]
    position_mm: _containers.RepeatedScalarFieldContainer[float]
    label: _containers.RepeatedScalarFieldContainer[str]
    setpoint: _containers.RepeatedScalarFieldContainer[float]
    event: _containers.RepeatedScalarFieldContainer[int]
    session: _containers.RepeatedScalarFieldContainer[int]
    repeat: _containers.RepeatedScalarFieldContainer[int]
    segment: _containers.RepeatedScalarFieldContainer[int]
    event_time_s: _containers.RepeatedScalarFieldContainer[float]
    event_setpoint: _containers.RepeatedScalarFieldContainer[float]
    event_session: _containers.RepeatedScalarFieldContainer[int]
    capture_number: _containers.RepeatedScalarFieldContainer[int]
    event_number: _containers.RepeatedScalarFieldContainer[int]
    def __init__(self, timestamp: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., row_capture: _Optional[_Iterable[int]] = ..., time_s: _Optional[_Iterable[float]] = ..., hold_s: _Optional[_Iterable[float]] = ..., settled: _Optional[_Iterable[bool]] = ..., measured: _Optional[_Iterable[float]] = ..., observed: _Optional[_Iterable[float]] = ..., covariates: _Optional[_Iterable[float]] = ..., position_mm: _Optional[_Iterable[float]] = ..., label: _Optional[_Iterable[str]] = ..., setpoint: _Optional[_Iterable[float]] = ..., event: _Optional[_Iterable[int]] = ..., session: _Optional[_Iterable[int]] = ..., repeat: _Optional[_Iterable[int]] = ..., segment: _Optional[_Iterable[int]] = ..., event_time_s: _Optional[_Iterable[float]] = ..., event_setpoint: _Optional[_Iterable[float]] = ..., event_session: _Optional[_Iterable[int]] = ..., capture_number: _Optional[_Iterable[int]] = ..., event_number: _Optional[_Iterable[int]] = ...) -> None: ...
