"""The limits in a rig file's section `safety` reach the built-in drivers of pressure controllers."""

import pytest

from labrig.rig import device_makers, parse_rig
from labrig_drivers import RealClock, VentNotConfirmedError
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin


@pytest.fixture
def pressure(tmp_path):
    """Makes the pressure controller of a rig file: `pressure(safety, **device)`, not connected."""

    def make(safety, **device):
        chambers = [{"name": name, "max_kpa": 60} for name in ("c1", "c2", "c3", "c4")]
        content = {"name": "rig", "chambers": chambers, "pressure": device, "safety": safety}
        rig = parse_rig(content, "rig.yaml", tmp_path)
        return device_makers(rig, RealClock())["pressure"]()

    return make


@pytest.mark.parametrize(
    ("own", "confirmed"), [({}, True), ({"vent_below_kpa": 3.0}, False)], ids=["safety", "its own"]
)
def test_a_vent_is_confirmed_within_vented_kpa(shared, plant, closing, pressure, own, confirmed):
    """Chambers that read 4 kPa are vented where `safety.vented_kpa` is 6, unless the driver's section says less."""
    twin = closing(OpenPneuTwin(OpenPneuBoard(shared, "published", "full"), boot_s=0.0).start())
    device = closing(pressure({"vented_kpa": 6.0}, kind="openpneu", port=twin.port, boot_s=0.0, **own))
    device.connect()
    plant.stuck_kpa = 4.0
    if confirmed:
        assert device.vent().pressure_kpa.tolist() == [4.0] * 4
    else:
        with pytest.raises(VentNotConfirmedError, match="c1 reads 4"):
            device.vent(0.5)


@pytest.mark.parametrize(
    "device",
    [{"kind": "openpneu", "port": "COM3"}, {"kind": "modbus", "host": "h", "map": "festo-vtem.yaml"}],
    ids=["openpneu", "modbus"],
)
def test_a_driver_waits_for_readings_as_long_as_the_rig(pressure, device):
    """The driver trips after `safety.stale_pressure_s`, also a long one, unless its own section says another."""
    assert pressure({"stale_pressure_s": 90.0}, **device)._options.stale_after_s == 90.0
    assert pressure({"stale_pressure_s": 90.0}, **device, stale_after_s=2.0)._options.stale_after_s == 2.0
