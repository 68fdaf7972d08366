"""How a run ends, whatever ended it: vented first, and then said."""

from collections.abc import Callable

from labrig._own_code import FAULTS
from labrig.rig import Rig, by_hand, impatient
from labrig_drivers import DeviceError, VentReport

_RETRY_S = 0.5


def vent_for_sure(rig: Rig, tell: Callable[[str], None]) -> VentReport | DeviceError:
    """Vent, again and again for as long as the rig's `vent_patience_s`, until it is confirmed.

    A link that was lost may come back. `tell` hears of it as soon as the first vent is not confirmed, or takes long:
    a person may be faster. Returns the report, or the last error.
    """
    patience_s = rig.config.safety.vent_patience_s
    end_s = rig.clock.now_s() + patience_s
    told = False
    with impatient(tell) as unsaid:
        while True:
            try:
                return rig.vent()
            except DeviceError as error:
                problem = error
            except FAULTS as error:  # a driver's own fault must not keep the next attempt from being made
                problem = DeviceError(f"{rig.pressure.name}: {type(error).__name__}: {error}")
            if rig.clock.now_s() >= end_s:
                return problem
            if not told:
                told = True
                unsaid.cancel()
                tell(f"{by_hand(str(problem))}; trying again for {patience_s:g} s")
            rig.clock.sleep(_RETRY_S)


def reason_of(error: BaseException | None) -> str:
    """What ended a run, in words."""
    if error is None:
        return "completed"
    if isinstance(error, KeyboardInterrupt):
        return str(error) or "Ctrl-C"
    return str(error) or type(error).__name__


def state_of(error: BaseException | None, vented: VentReport | DeviceError) -> str:
    """What stands in the log for how a run ended: it is not `completed` where the vent was not confirmed."""
    if isinstance(vented, VentReport):
        return reason_of(error)
    if error is None:
        return f"NOT VENTED: {vented}; everything was measured"
    before = "" if str(error) == str(vented) else f"; it had ended because: {reason_of(error)}"
    return f"NOT VENTED: {vented}{before}"
