"""May a run be left alone? Only where something vents the chambers when this computer is gone."""

from labrig._errors import LabrigError
from labrig.rig._rig import Rig


def what_vents_alone(rig: Rig) -> str:
    """What vents a connected rig when runner and guard are both gone, in words; empty when nothing does."""
    if rig.config.pressure.kind == "simulated":
        return "nothing is under pressure: the rig is simulated here"
    identity = rig.identity.get("pressure")
    if identity is not None and (watchdog := identity.details.get("watchdog")):
        return f"the watchdog of {identity.description}, after {watchdog}"
    return rig.config.safety.vents_alone


def check_unattended(rig: Rig) -> str:
    """What vents the rig alone; raises `LabrigError` where nothing does."""
    if what := what_vents_alone(rig):
        return what
    raise LabrigError(
        f"rig {rig.config.name} is not left unattended: its pressure controller has no watchdog of its own, so "
        "nothing vents when this computer is gone; if something else does, say what in rig.yaml "
        "(safety: {vents_alone: ...})"
    )
