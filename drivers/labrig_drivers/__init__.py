"""Devices: small protocols, the clock they run on, and one module per real device."""

from labrig_drivers._build import KINDS, build_device, one_target, set_together
from labrig_drivers._check import Finding, State, check_devices
from labrig_drivers._choices import register_maps, serial_ports
from labrig_drivers._clock import Clock, RealClock, SimulatedClock
from labrig_drivers._protocols import (
    Channel,
    Device,
    DeviceError,
    Identity,
    MarkerFrame,
    MarkerStatus,
    MotionCapture,
    PressureController,
    PressureSample,
    Scan,
    Scanner,
    VentNotConfirmedError,
    VentReport,
    frames_missing,
)
from labrig_drivers._recording import RecordingError
from labrig_drivers._settings import SETTINGS
from labrig_drivers._short_traceback import short_traceback

__all__ = [
    "KINDS",
    "SETTINGS",
    "Channel",
    "Clock",
    "Device",
    "DeviceError",
    "Finding",
    "Identity",
    "MarkerFrame",
    "MarkerStatus",
    "MotionCapture",
    "PressureController",
    "PressureSample",
    "RealClock",
    "RecordingError",
    "Scan",
    "Scanner",
    "SimulatedClock",
    "State",
    "VentNotConfirmedError",
    "VentReport",
    "build_device",
    "check_devices",
    "frames_missing",
    "one_target",
    "register_maps",
    "serial_ports",
    "set_together",
    "short_traceback",
]
