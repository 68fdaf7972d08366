"""State machines: each driver against its twin, in any order of calls and mishaps."""

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule

from labrig_drivers import Channel, DeviceError, MarkerStatus, RealClock, _openpneu, build_device
from labrig_drivers._modbus_map import load_map
from labrig_drivers.simulated._modbus_twin import ModbusTwin
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin
from labrig_drivers.simulated._vicon_server import ViconServer
from labrig_drivers.simulated._wire_plant import SharedPlant
from tests.waiting import wait_for

CHANNELS = tuple(Channel(name, 0.0, 60.0) for name in ("c1", "c2", "c3", "c4"))
PLANTS = []


@pytest.fixture(autouse=True)
def _plant_class(small_plant_class, monkeypatch):
    """Hands the plant of the other tests to the machines, and does not ask a silent board for long: three times this,
    which is more than the age at which its readings count as stale.
    """
    PLANTS[:] = [small_plant_class]
    monkeypatch.setattr(_openpneu, "REPLY_S", 0.25)


def refuses(device):
    """Whether the device has noticed that something is wrong."""
    try:
        device.samples()
    except DeviceError as error:
        return str(error).startswith("pressure: ")
    return False


class ViconMachine(RuleBasedStateMachine):
    """Markers are covered, the server goes and comes back: statuses and positions are always the truth."""

    def __init__(self):
        super().__init__()
        self.plant = PLANTS[0](markers=("a", "b", "c", "d"))
        self.shared = SharedPlant(self.plant, RealClock())
        self.server = ViconServer(self.shared, rate_hz=400.0).start()
        options = {"port": self.server.port, "stale_after_s": 0.05}
        names = (*self.plant.marker_names, "stranger")
        self.device = build_device("vicon", options, name="mocap", clock=RealClock(), marker_names=names)
        self.device.connect()
        self.up = True

    def latest(self):
        """The last frame of those that came since the call before."""
        frames = self.device.frames()
        assert all(frame.position_mm.shape == (5, 3) for frame in frames)
        for frame in frames:
            seen = frame.status == MarkerStatus.SEEN
            assert np.isfinite(frame.position_mm[seen]).all()
            assert np.isnan(frame.position_mm[~seen]).all()
        return frames[-1] if frames else None

    @precondition(lambda self: self.up)
    @rule(covered=st.sets(st.integers(0, 3)))
    def cover(self, covered):
        self.plant.occluded = covered
        wanted = [MarkerStatus.OCCLUDED if i in covered else MarkerStatus.SEEN for i in range(4)]
        wanted.append(MarkerStatus.NOT_SUBSCRIBED)
        frame = wait_for(lambda: (f := self.latest()) is not None and f.status.tolist() == wanted and f)
        seen = frame.status == MarkerStatus.SEEN
        np.testing.assert_array_equal(frame.position_mm[seen], self.plant.rest_mm[seen[:4]])

    @precondition(lambda self: self.up)
    @rule()
    def kill(self):
        self.server.stop()
        self.up = False

    @precondition(lambda self: not self.up)
    @rule()
    def everything_is_stale(self):
        wait_for(lambda: (f := self.latest()) is not None and np.all(f.status == MarkerStatus.STALE))

    @precondition(lambda self: not self.up)
    @rule()
    def come_back(self):
        self.server = ViconServer(self.shared, rate_hz=400.0, port=self.server.port).start()
        self.up = True

    @rule()
    def connect_again(self):
        self.device.connect()

    def teardown(self):
        self.device.close()
        self.server.stop()


class OpenPneuMachine(RuleBasedStateMachine):
    """Set-points, vents, silence and unplugging: the board never gets a target outside the limits."""

    def __init__(self):
        super().__init__()
        self.plant = PLANTS[0]()
        self.shared = SharedPlant(self.plant, RealClock())
        self.start_twin(0)
        settings = {"port": self.twin.port, "boot_s": 0.0, "build": "full", "stale_after_s": 0.3}
        self.device = build_device(
            "openpneu", settings, name="pressure", clock=RealClock(), channels=CHANNELS
        )
        self.device.connect()
        self.well = True

    def start_twin(self, port):
        board = OpenPneuBoard(self.shared)
        self.twin = OpenPneuTwin(board, boot_s=0.0, interleave=0.7, tcp_port=port).start()

    @precondition(lambda self: self.well)
    @rule(kpa=st.lists(st.integers(0, 60), min_size=4, max_size=4))
    def set(self, kpa):
        self.device.set(np.array(kpa, float))
        wait_for(lambda: any(np.allclose(s.pressure_kpa, kpa, atol=0.1) for s in self.device.samples()))

    @rule(index=st.integers(0, 3), value=st.sampled_from([-0.1, 60.1, float("nan"), 1e9]))
    def set_outside(self, index, value):
        target = np.zeros(4)
        target[index] = value
        with pytest.raises(DeviceError, match=f"c{index + 1} set to .*; nothing was moved"):
            self.device.set(target)

    @precondition(lambda self: self.well)
    @rule()
    def vent(self):
        assert np.all(self.device.vent().pressure_kpa < 3)

    @precondition(lambda self: self.well)
    @rule()
    def go_silent_and_recover(self):
        self.twin.muted = True
        wait_for(lambda: refuses(self.device))
        with pytest.raises(DeviceError):
            self.device.set(np.zeros(4))
        self.twin.muted = False
        self.device.vent()

    @precondition(lambda self: self.well)
    @rule()
    def unplug(self):
        self.twin.stop()
        self.well = False
        wait_for(lambda: refuses(self.device))

    @precondition(lambda self: not self.well)
    @rule(by_vent=st.booleans())
    def plug_in(self, by_vent):
        self.start_twin(int(self.twin.port.rsplit(":", 1)[1]))
        if by_vent:
            self.device.vent()
        else:
            self.device.connect()
        self.well = True

    def teardown(self):
        self.device.close()
        self.twin.stop()
        for commanded in self.plant.commands:
            assert np.all((commanded >= 0) & (commanded <= 60))


class ModbusMachine(RuleBasedStateMachine):
    """The same over Modbus."""

    def __init__(self):
        super().__init__()
        self.plant = PLANTS[0]()
        self.shared = SharedPlant(self.plant, RealClock())
        self.twin = ModbusTwin(self.shared, load_map("festo-vtem.yaml")).start()
        settings = {"host": "127.0.0.1", "port": self.twin.port, "map": "festo-vtem.yaml", "timeout_s": 0.3}
        self.device = build_device("modbus", settings, name="pressure", clock=RealClock(), channels=CHANNELS)
        self.device.connect()
        self.well = True

    @precondition(lambda self: self.well)
    @rule(kpa=st.lists(st.integers(0, 60), min_size=4, max_size=4))
    def set(self, kpa):
        self.device.set(np.array(kpa, float))
        wait_for(lambda: any(np.allclose(s.pressure_kpa, kpa, atol=0.15) for s in self.device.samples()))

    @precondition(lambda self: self.well)
    @rule()
    def vent(self):
        assert np.all(np.abs(self.device.vent().pressure_kpa) < 3)

    @precondition(lambda self: self.well)
    @rule()
    def unplug(self):
        self.twin.stop()
        self.well = False
        wait_for(lambda: refuses(self.device))

    @precondition(lambda self: not self.well)
    @rule(by_vent=st.booleans())
    def plug_in(self, by_vent):
        self.twin = ModbusTwin(self.shared, load_map("festo-vtem.yaml"), port=self.twin.port).start()
        if by_vent:
            self.device.vent()
        else:
            self.device.connect()
        self.well = True

    def teardown(self):
        self.device.close()
        self.twin.stop()
        for commanded in self.plant.commands:
            assert np.all((commanded >= 0) & (commanded <= 60))


MANY = settings(max_examples=3, stateful_step_count=8)

TestVicon = ViconMachine.TestCase
TestVicon.settings = MANY
TestOpenPneu = pytest.mark.slow(OpenPneuMachine.TestCase)
TestOpenPneu.settings = MANY
TestModbus = ModbusMachine.TestCase
TestModbus.settings = MANY
