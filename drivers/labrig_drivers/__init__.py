"""Devices: small protocols, the clock they run on, and one module per real device."""

from labrig_drivers._build import KINDS, build_device
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
)

__all__ = [
    "KINDS",
    "Channel",
    "Clock",
    "Device",
    "DeviceError",
    "Identity",
    "MarkerFrame",
    "MarkerStatus",
    "MotionCapture",
    "PressureController",
    "PressureSample",
    "RealClock",
    "Scan",
    "Scanner",
    "SimulatedClock",
    "VentNotConfirmedError",
    "VentReport",
    "build_device",
]
