"""The rig: rig.yaml, the devices it names, and what keeps it safe."""

from labrig.rig._config import (
    ChamberConfig,
    DeviceConfig,
    RigConfig,
    SafetyConfig,
    load_rig,
    parse_rig,
)
from labrig.rig._factory import connect, device_makers
from labrig.rig._guard import GuardedPressure
from labrig.rig._rig import Rig

__all__ = [
    "ChamberConfig",
    "DeviceConfig",
    "GuardedPressure",
    "Rig",
    "RigConfig",
    "SafetyConfig",
    "connect",
    "device_makers",
    "load_rig",
    "parse_rig",
]
