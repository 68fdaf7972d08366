"""The tenth portion of the development half: its authors did not know how effects are named.

Of each effect there is one law that an engineer would write down first, and one of another kind. Its sources are cited
from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development.tenth import (
    contact,
    coupling,
    creep,
    delay,
    drift,
    frame,
    friction,
    gravity,
    hysteresis,
    leak,
    marker_slip,
    regulator,
    rest_shape,
    rigs,
    stiffening,
    tension,
)
from labrig.bench.development.tenth.outside import OUTSIDE
from labrig.bench.development.tenth.wrong import WRONG

RIGS = (rigs.Cilia, rigs.Wheel, rigs.Fan)

LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis.TwoSBranches, hysteresis.WithinABound),
    (creep.ModifiedPower, creep.GlueLineAtTheFoot),
    (regulator.WrongParabola, regulator.WobblingScrew),
    (leak.ShrinksAsItLeaks, leak.ToppedUp),
    (coupling.OnOneHalfSpace, coupling.TankThatEmpties),
    (stiffening.LogarithmicStrain, stiffening.PleatsOneByOne),
    (gravity.VirtualWork, gravity.SagsWhereAirIsShort),
    (drift.GyroscopesBias, drift.WarmsByItsWork),
    (contact.InASlot, contact.PushesABlock),
    (marker_slip.SlidesByTheLogarithm, marker_slip.BucklesOff),
    (frame.MovedForAWhile, frame.StitchedVolumes),
    (delay.DeadTimeAndTwoLags, delay.WarmAir),
    (friction.SmoothedCoulomb, friction.RubsOnItsNeighbour),
    (rest_shape.Leans, rest_shape.CreasesIronedOut),
    (tension.StripUnderTension, tension.TightCover),
)

TENTH = Half(
    name="tenth",
    rigs={rig.kind: rig for rig in RIGS},
    laws={laws[0].effect: laws for laws in LAWS},
    outside=OUTSIDE,
    wrong=WRONG,
)
"""Three kinds of rig; two laws for each effect, and those that no effect describes."""
