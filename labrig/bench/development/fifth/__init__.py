"""The fifth portion of the development half: rigs and laws by an author who did not know how effects are named.

It is drawn from apart. Its sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development._wrong import another_wall, other_places
from labrig.bench.development.fifth import (
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
    outside,
    regulator,
    rest_shape,
    rigs,
    rigs_blind,
    stiffening,
    tension,
)

_RIGS = (
    *(rigs.Snake, rigs.Face, rigs.Balloon, rigs.Walker),
    *(rigs_blind.Tugs, rigs_blind.Lens, rigs_blind.Comb, rigs_blind.Hand, rigs_blind.Bragg),
)

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis.BackStresses, hysteresis.GrowingLoops, hysteresis.FewCreases),
    (creep.WagnersBell, creep.RossHyperbola, creep.SlowWayBack),
    (regulator.SpanAndZero, regulator.CubicCalibration, regulator.LoadedPotentiometer),
    (leak.TurbulentGap, leak.PartlyMadeUp, leak.SharedManifold),
    (coupling.GroundLoop, coupling.LeastResistance, coupling.BendTwist),
    (stiffening.LevelsOff, stiffening.SecondOrder, stiffening.WormLikeChains),
    (gravity.FarBowedRod, gravity.OverAPulley, gravity.LongerArm),
    (drift.JerkyStand, drift.SunPatch, drift.RunDownBattery),
    (contact.LiftedWeight, contact.AirCushion, contact.TautHose),
    (
        marker_slip.SwingsAboutCorner,
        marker_slip.SlidesToEdge,
        marker_slip.TwoSeats,
        marker_slip.KnockedByHand,
    ),
    (frame.SquareLaidAskew, frame.BadlyLevelled, frame.StretchedPrint, frame.MetalNearTracker),
    (delay.LateMessages, delay.TrapezoidProfile, delay.SoftStart),
    (friction.TightSpots, friction.RoundContacts, friction.JammingDrawer),
    (rest_shape.BowedCast, rest_shape.FlattenedTube, rest_shape.DrawnUnevenly),
    (tension.SlopingBands, tension.KnittedSleeve, tension.LacedCover),
)

FIFTH = Half(
    name="fifth",
    rigs={rig.kind: rig for rig in _RIGS},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(
        outside.StaleFrames,
        outside.CrossedHoses,
        outside.Footsteps,
        outside.DraggedAlong,
        outside.PoorRepeatability,
        outside.PulledCable,
    ),
    wrong={"another_wall": another_wall, "other_places": other_places},
)
"""Nine kinds of rig; three or four published laws for each effect, and six that no effect describes."""
