"""The rig: rig.yaml, the devices it names, and what keeps it safe."""

from labrig.rig._config import (
    ChamberConfig,
    DeviceConfig,
    RigConfig,
    SafetyConfig,
    describe,
    load_rig,
    parse_rig,
)
from labrig.rig._factory import connect
from labrig.rig._rig import Rig

__all__ = [
    "ChamberConfig",
    "DeviceConfig",
    "Rig",
    "RigConfig",
    "SafetyConfig",
    "connect",
    "describe",
    "load_rig",
    "parse_rig",
]
