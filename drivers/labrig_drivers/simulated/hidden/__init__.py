"""Hidden effects of the simulated plant, from the physics of each, apart from any library that looks for
them.
"""

from labrig_drivers.simulated.hidden._base import Body, Hidden, Setting
from labrig_drivers.simulated.hidden._contact import Contact
from labrig_drivers.simulated.hidden._coupling import Coupling
from labrig_drivers.simulated.hidden._creep import Creep
from labrig_drivers.simulated.hidden._delay import Delay
from labrig_drivers.simulated.hidden._drift import Drift
from labrig_drivers.simulated.hidden._frame import Frame
from labrig_drivers.simulated.hidden._friction import Friction
from labrig_drivers.simulated.hidden._gravity import Gravity
from labrig_drivers.simulated.hidden._hysteresis import Hysteresis
from labrig_drivers.simulated.hidden._kink import Kink
from labrig_drivers.simulated.hidden._leak import Leak
from labrig_drivers.simulated.hidden._lens import Lens
from labrig_drivers.simulated.hidden._marker_slip import MarkerSlip
from labrig_drivers.simulated.hidden._mount import Mount
from labrig_drivers.simulated.hidden._regulator import Regulator
from labrig_drivers.simulated.hidden._rest_shape import RestShape
from labrig_drivers.simulated.hidden._softening import Softening
from labrig_drivers.simulated.hidden._stiffening import Stiffening
from labrig_drivers.simulated.hidden._tension import Tension

LISTED: dict[str, type[Hidden]] = {
    effect.name: effect
    for effect in (
        Hysteresis, Creep, Regulator, Leak, Coupling, Stiffening, Gravity, Drift,
        Contact, MarkerSlip, Frame, Delay, Friction, RestShape, Tension,
    )
}  # fmt: skip
UNLISTED: dict[str, type[Hidden]] = {effect.name: effect for effect in (Mount, Softening, Lens, Kink)}
EFFECTS: dict[str, type[Hidden]] = {**LISTED, **UNLISTED}

__all__ = ["EFFECTS", "LISTED", "UNLISTED", "Body", "Hidden", "Setting"]
