"""A regulator that reports a fault of its own: it is let go of, and vented like any other."""

import numpy as np
import pytest

from labrig_drivers import Channel, DeviceError, RealClock, build_device
from labrig_drivers._modbus_map import load_map
from labrig_drivers.simulated._modbus_twin import ModbusTwin
from labrig_drivers.simulated._wire_plant import SharedPlant


def test_a_regulator_with_a_fault_is_vented(small_plant_class, closing, until):
    """What it reports ends the run, and does not hide the readings that confirm the vent, however seldom they come."""
    plant = SharedPlant(small_plant_class(chambers=("c1",)), RealClock())
    twin = closing(ModbusTwin(plant, load_map("festo-pgva.yaml")).start())
    device = closing(
        build_device(
            "modbus",
            {"host": "127.0.0.1", "port": twin.port, "map": "festo-pgva.yaml", "poll_hz": 2.0},
            name="pressure",
            clock=RealClock(),
            channels=[Channel("c1", 0, 40)],
        )
    )
    device.connect()
    device.set(np.array([20.0]))
    twin.faults["error"] = 7
    with pytest.raises(DeviceError, match="reports error 7"):
        until(lambda: device.samples() and False)
    assert abs(device.vent(30.0).pressure_kpa[0]) < 3.0
    with pytest.raises(DeviceError, match="reports error 7"):  # and it is not filled again
        until(lambda: device.set(np.array([20.0])) or (device.samples() and False))
