import datetime

from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Step(_message.Message):
    __slots__ = ("timestamp", "index", "kind", "state", "step_json", "result_json", "started_s", "ended_s", "wall_s")
    class State(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = ()
        UNKNOWN: _ClassVar[Step.State]
        STARTED: _ClassVar[Step.State]
        DONE: _ClassVar[Step.State]
        FAILED: _ClassVar[Step.State]
    UNKNOWN: Step.State
    STARTED: Step.State
    DONE: Step.State
    FAILED: Step.State
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    INDEX_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    STEP_JSON_FIELD_NUMBER: _ClassVar[int]
    RESULT_JSON_FIELD_NUMBER: _ClassVar[int]
    STARTED_S_FIELD_NUMBER: _ClassVar[int]
    ENDED_S_FIELD_NUMBER: _ClassVar[int]
    WALL_S_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    index: int
    kind: str
    state: Step.State
    step_json: str
    result_json: str
    started_s: float
    ended_s: float
    wall_s: float
    def __init__(self, timestamp: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., index: _Optional[int] = ..., kind: _Optional[str] = ..., state: _Optional[_Union[Step.State, str]] = ..., step_json: _Optional[str] = ..., result_json: _Optional[str] = ..., started_s: _Optional[float] = ..., ended_s: _Optional[float] = ..., wall_s: _Optional[float] = ...) -> None: ...

class Capture(_message.Message):
    __slots__ = ("timestamp", "capture", "setpoint", "session", "repeat", "event", "segment")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    CAPTURE_FIELD_NUMBER: _ClassVar[int]
    SETPOINT_FIELD_NUMBER: _ClassVar[int]
    SESSION_FIELD_NUMBER: _ClassVar[int]
    REPEAT_FIELD_NUMBER: _ClassVar[int]
    EVENT_FIELD_NUMBER: _ClassVar[int]
    SEGMENT_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    capture: int
    setpoint: _containers.RepeatedScalarFieldContainer[float]
    session: str
    repeat: str
    event: int
    segment: str
    def __init__(self, timestamp: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., capture: _Optional[int] = ..., setpoint: _Optional[_Iterable[float]] = ..., session: _Optional[str] = ..., repeat: _Optional[str] = ..., event: _Optional[int] = ..., segment: _Optional[str] = ...) -> None: ...

class Plan(_message.Message):
    __slots__ = ("timestamp", "procedure", "parameters_json", "plan_sha256", "steps", "estimate_s", "run_json", "layout_json")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    PROCEDURE_FIELD_NUMBER: _ClassVar[int]
    PARAMETERS_JSON_FIELD_NUMBER: _ClassVar[int]
    PLAN_SHA256_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    ESTIMATE_S_FIELD_NUMBER: _ClassVar[int]
    RUN_JSON_FIELD_NUMBER: _ClassVar[int]
    LAYOUT_JSON_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    procedure: str
    parameters_json: str
    plan_sha256: str
    steps: int
    estimate_s: float
    run_json: str
    layout_json: str
    def __init__(self, timestamp: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., procedure: _Optional[str] = ..., parameters_json: _Optional[str] = ..., plan_sha256: _Optional[str] = ..., steps: _Optional[int] = ..., estimate_s: _Optional[float] = ..., run_json: _Optional[str] = ..., layout_json: _Optional[str] = ...) -> None: ...
