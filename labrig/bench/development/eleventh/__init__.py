"""The eleventh portion of the development half: its authors did not know how effects are named.

Of each effect there is one law that is published and common in laboratories, and one that happens on real rigs. Its
sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development.eleventh import (
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
from labrig.bench.development.eleventh.outside import OUTSIDE
from labrig.bench.development.eleventh.wrong import WRONG

RIGS = (rigs.Truss, rigs.Lantern, rigs.Tail, rigs.Honeycomb)

LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis.RubberBearing, hysteresis.TackyCells),
    (creep.SecondNetworkFlows, creep.ThreadBedsIn),
    (regulator.SyringeOfAir, regulator.PumpAgainstBleed),
    (leak.ThroughStitches, leak.FittingPulledAside),
    (coupling.BeamOnElasticBed, coupling.SqueezedInTheDeadBand),
    (stiffening.ExtendedTube, stiffening.FacesMeet),
    (gravity.ChainOfHinges, gravity.LoopSlidesDown),
    (drift.BoltsWorkLoose, drift.TableOnAirLegs),
    (contact.SticksToABlock, contact.HeelsOver),
    (marker_slip.OverlapShrinks, marker_slip.TopplesInItsHole),
    (frame.DirectLinearTransform, frame.ReferenceRides),
    (delay.AlphaBetaTracker, delay.BagUnfoldsFirst),
    (friction.BoltedJoint, friction.TalcWearsOff),
    (rest_shape.Barrelled, rest_shape.CinchedByTies),
    (tension.OneTensionAllAlong, tension.TightSeam),
)

ELEVENTH = Half(
    name="eleventh",
    rigs={rig.kind: rig for rig in RIGS},
    laws={laws[0].effect: laws for laws in LAWS},
    outside=OUTSIDE,
    wrong=WRONG,
)
"""Four kinds of rig; two laws for each effect, and those that no effect describes."""
