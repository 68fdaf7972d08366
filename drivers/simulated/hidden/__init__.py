"""Hidden effects of the simulated plant, written from the physics of each, apart from any library that looks
for them.
"""

from drivers.simulated.hidden._base import Body, Hidden, Setting
from drivers.simulated.hidden._creep import Creep
from drivers.simulated.hidden._friction import Friction
from drivers.simulated.hidden._hysteresis import Hysteresis
from drivers.simulated.hidden._mechanics import Contact, Coupling, Stiffening, Tension
from drivers.simulated.hidden._observation import Drift, Frame, Gravity, MarkerSlip, RestShape
from drivers.simulated.hidden._pneumatics import Delay, Leak, Regulator
from drivers.simulated.hidden._unlisted import Lens, Softening, Supply, Wrinkle

LISTED: dict[str, type[Hidden]] = {
    effect.name: effect
    for effect in (
        Hysteresis, Creep, Regulator, Leak, Coupling, Stiffening, Gravity, Drift,
        Contact, MarkerSlip, Frame, Delay, Friction, RestShape, Tension,
    )
}  # fmt: skip
UNLISTED: dict[str, type[Hidden]] = {effect.name: effect for effect in (Wrinkle, Softening, Supply, Lens)}
EFFECTS: dict[str, type[Hidden]] = {**LISTED, **UNLISTED}

__all__ = ["EFFECTS", "LISTED", "UNLISTED", "Body", "Hidden", "Setting"]
