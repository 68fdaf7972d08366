"""Motion capture frames as Foxglove point clouds, encoded with little more work than copying their numbers."""

from typing import Any

import numpy as np

from labrig_drivers import MarkerFrame

POINT = np.dtype([("position_mm", "<f4", (3,)), ("status", "u1")])
"""One marker in a cloud: positions as 32 bit floats (below 0.0001 mm at 1 m), `MarkerStatus`."""


_LONGEST_STAMP = 32


class FrameEncoder:
    """Makes the messages of /mocap/markers.

    What every message shares is encoded once; a message is its time, that part, and the points: protobuf allows
    fields to be put together like this. (A message object that is reused would keep the memory of every cloud.)
    """

    def __init__(self, markers: int) -> None:
        from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
        from google.protobuf.timestamp_pb2 import Timestamp

        numbers = {name: field.number for name, field in PointCloud.DESCRIPTOR.fields_by_name.items()}
        self._points = np.zeros(markers, dtype=POINT)
        self._position, self._status = self._points["position_mm"], self._points["status"]
        self._stamp = Timestamp()
        self._heads = [bytes([numbers["timestamp"] << 3 | 2, length]) for length in range(_LONGEST_STAMP + 1)]
        size = _varint(self._points.nbytes)
        self._shared = _empty_cloud().SerializeToString() + bytes([numbers["data"] << 3 | 2]) + size

    def encode(self, frame: MarkerFrame, time_ns: int) -> bytes:
        """The message of one frame."""
        points, stamp = self._points, self._stamp
        self._position[...] = frame.position_mm
        self._status[...] = frame.status
        stamp.seconds, stamp.nanos = divmod(time_ns, 1_000_000_000)
        time = stamp.SerializeToString()
        return b"".join((self._heads[len(time)], time, self._shared, points.tobytes()))


def _empty_cloud() -> Any:
    from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
    from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

    cloud = PointCloud(frame_id="rig", point_stride=POINT.itemsize)
    cloud.pose.position.x = 0.0  # present, although it says nothing: viewers ask for it
    cloud.pose.orientation.w = 1.0
    for offset, name in ((0, "x"), (4, "y"), (8, "z")):
        cloud.fields.add(name=name, offset=offset, type=PackedElementField.FLOAT32)
    cloud.fields.add(name="status", offset=12, type=PackedElementField.UINT8)
    return cloud


def _varint(number: int) -> bytes:
    """A length as protobuf writes it."""
    encoded = bytearray()
    while number > 0x7F:
        encoded.append(number & 0x7F | 0x80)
        number >>= 7
    encoded.append(number)
    return bytes(encoded)
