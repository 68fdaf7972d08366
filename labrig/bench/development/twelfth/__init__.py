"""The twelfth portion of the development half: its author did not know how effects are named.

Its rigs have two to eight sensors, of several units in one rig, and hardly a marker; its laws are such as happen there:
in one joint, in one sensor, in what is between them. Its sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development.twelfth import (
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
    rigs_more,
    stiffening,
    tension,
)
from labrig.bench.development.twelfth.outside import OUTSIDE
from labrig.bench.development.twelfth.wrong import WRONG

RIGS = (rigs.Elbow, rigs.Fingertip, rigs.Clasp, rigs_more.Thruster, rigs_more.Neck, rigs_more.Hoist)

LAWS: tuple[tuple[type[Law], ...], ...] = (
    (
        hysteresis.AimsAtItsPeak,
        hysteresis.RegulatorsOwnHysteresis,
        hysteresis.RayleighsLoops,
        hysteresis.BacklashInTheGear,
    ),
    (creep.HavriliakNegami, creep.LoadCellCreeps, creep.TendonStretches),
    (regulator.BoosterWithABias, regulator.SplitRangeWithAGap),
    (leak.SlipsThroughPores, leak.GaveWayOnce),
    (coupling.FrameFlexes, coupling.WhiffleTree),
    (stiffening.Carroll, stiffening.LopezPamies, stiffening.Ligaments),
    (gravity.LinksTurn, gravity.SlidesOnItsSlope),
    (drift.BridgesWarmUp, drift.WiperWearsItsTrack, drift.MountingSettles),
    (contact.EndStopOfOneJoint, contact.SoftBallInTheWay),
    (marker_slip.SlipsAtEachRecord, marker_slip.ScrewedOnAnew),
    (frame.PlateLiesAskew, frame.TrackersPlaceOnTheRig),
    (delay.AmplifiersLowPass, delay.OldReadings),
    (friction.DahlInTheJoint, friction.LoadedPivot),
    (rest_shape.CutTooLong, rest_shape.PartsHaveTolerances),
    (tension.ConstantForceSpring, tension.CloseWoundSpring),
)

TWELFTH = Half(
    name="twelfth",
    rigs={rig.kind: rig for rig in RIGS},
    laws={laws[0].effect: laws for laws in LAWS},
    outside=OUTSIDE,
    wrong=WRONG,
)
"""Six kinds of rig; two laws or more for each effect, and those that no effect describes."""
