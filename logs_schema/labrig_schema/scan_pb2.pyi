import datetime

from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class ScanMesh(_message.Message):
    __slots__ = ("timestamp", "files", "sha256", "vertices", "triangles", "min_mm", "max_mm", "registration_error_mm")
    TIMESTAMP_FIELD_NUMBER: _ClassVar[int]
    FILES_FIELD_NUMBER: _ClassVar[int]
    SHA256_FIELD_NUMBER: _ClassVar[int]
    VERTICES_FIELD_NUMBER: _ClassVar[int]
    TRIANGLES_FIELD_NUMBER: _ClassVar[int]
    MIN_MM_FIELD_NUMBER: _ClassVar[int]
    MAX_MM_FIELD_NUMBER: _ClassVar[int]
    REGISTRATION_ERROR_MM_FIELD_NUMBER: _ClassVar[int]
    timestamp: _timestamp_pb2.Timestamp
    files: _containers.RepeatedScalarFieldContainer[str]
    sha256: str
    vertices: int
    triangles: int
    min_mm: _containers.RepeatedScalarFieldContainer[float]
    max_mm: _containers.RepeatedScalarFieldContainer[float]
    registration_error_mm: float
    def __init__(self, timestamp: _Optional[_Union[datetime.datetime, _timestamp_pb2.Timestamp, _Mapping]] = ..., files: _Optional[_Iterable[str]] = ..., sha256: _Optional[str] = ..., vertices: _Optional[int] = ..., triangles: _Optional[int] = ..., min_mm: _Optional[_Iterable[float]] = ..., max_mm: _Optional[_Iterable[float]] = ..., registration_error_mm: _Optional[float] = ...) -> None: ...
