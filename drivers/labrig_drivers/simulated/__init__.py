"""The simulated rig: devices that behave like the real ones, over one shared plant."""

from labrig_drivers.simulated._calibration import Programme, calibrate, run_programme
from labrig_drivers.simulated._devices import SimulatedMocap, SimulatedPressure, SimulatedScanner
from labrig_drivers.simulated._plant import Plant, SimulatedPlant, build_plant
from labrig_drivers.simulated._sealed import SEALED_NAME, choose, hide, reveal, seal
from labrig_drivers.simulated.hidden import LISTED

HIDDEN_EFFECTS: tuple[str, ...] = tuple(LISTED)

__all__ = [
    "HIDDEN_EFFECTS",
    "SEALED_NAME",
    "Plant",
    "Programme",
    "SimulatedMocap",
    "SimulatedPlant",
    "SimulatedPressure",
    "SimulatedScanner",
    "build_plant",
    "calibrate",
    "choose",
    "hide",
    "reveal",
    "run_programme",
    "seal",
]
