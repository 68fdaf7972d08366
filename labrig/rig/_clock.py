"""The clock of a rig: a simulated one where nothing has to be waited for."""

from labrig.rig._config import RigConfig
from labrig_drivers import Clock, RealClock, SimulatedClock


def is_simulated(config: RigConfig) -> bool:
    """Whether every device is simulated in this process."""
    return {device.kind for device in config.devices.values() if device is not None} == {"simulated"}


def clock_of(config: RigConfig, realtime: bool = False) -> Clock:
    """The real clock; for a rig that is simulated in this process one that does not wait, unless `realtime`."""
    waits = realtime or not is_simulated(config)
    return RealClock() if waits else SimulatedClock(RealClock().now_s())
