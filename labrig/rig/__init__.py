"""The rig: rig.yaml, the devices it names, and what keeps it safe."""

from labrig.rig._asked import link_of
from labrig.rig._chambers import Filling, Fillings, fill_in_turn
from labrig.rig._clock import clock_of, is_simulated
from labrig.rig._config import (
    ChamberConfig,
    DeviceConfig,
    FollowConfig,
    RigConfig,
    SafetyConfig,
    check_rig,
    load_rig,
    parse_rig,
)
from labrig.rig._factory import connect, device_makers, driver_limits
from labrig.rig._findings import chamber_findings, swapped_markers
from labrig.rig._guard import GuardedPressure
from labrig.rig._in_use import in_use
from labrig.rig._last_words import VENTED, and_vented, by_hand, impatient, not_vented, retold
from labrig.rig._pressure_watch import PressureWatch
from labrig.rig._rig import Rig
from labrig.rig._silence import Silence, dated
from labrig.rig._unattended import check_unattended, what_vents_alone
from labrig.rig._vent_now import NOBODY, VentNow, investigations_on, is_there, runs_on, users_of, vent_now

__all__ = [
    "NOBODY",
    "VENTED",
    "ChamberConfig",
    "DeviceConfig",
    "Filling",
    "Fillings",
    "FollowConfig",
    "GuardedPressure",
    "PressureWatch",
    "Rig",
    "RigConfig",
    "SafetyConfig",
    "Silence",
    "VentNow",
    "and_vented",
    "by_hand",
    "chamber_findings",
    "check_rig",
    "check_unattended",
    "clock_of",
    "connect",
    "dated",
    "device_makers",
    "driver_limits",
    "fill_in_turn",
    "impatient",
    "in_use",
    "investigations_on",
    "is_simulated",
    "is_there",
    "link_of",
    "load_rig",
    "not_vented",
    "parse_rig",
    "retold",
    "runs_on",
    "swapped_markers",
    "users_of",
    "vent_now",
    "what_vents_alone",
]
