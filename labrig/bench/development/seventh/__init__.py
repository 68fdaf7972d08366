"""The seventh portion of the development half: rigs and laws by an author who did not know how effects are named.

It is drawn from apart. Its sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development.seventh import (
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
from labrig.bench.development.seventh.wrong import bent_ways, wavy_wall

_RIGS = (rigs.Auger, rigs.Spine, rigs_blind.Choke, rigs_blind.Gullet)

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis.TellinensBranches, hysteresis.FromAsymptoteToAsymptote),
    (creep.ThirdRootAndFlow, creep.AgesAsItYields),
    (regulator.TapInTheStream, regulator.SaturatedIron),
    (leak.GapUnderASeal, leak.EasesOpen),
    (coupling.CoilsSideBySide, coupling.PulledBothWays),
    (stiffening.FoamedRubber, stiffening.GrainsYield),
    (gravity.ShearsUnderItsWeight, gravity.FlattensLikeARing),
    (drift.LaserHopsModes, drift.DriesOut),
    (contact.RubberBuffer, contact.PropUnderIt),
    (marker_slip.CrackInTheGlue, marker_slip.WarmGlue),
    (frame.ThreeBadTargets, frame.BowedRail),
    (delay.SaturatedValve, delay.FilterAndHole),
    (friction.PulledFromOneEnd, friction.UpTheWedge),
    (rest_shape.ShiftedHalves, rest_shape.CoreShowsThrough),
    (tension.CrimpPulledOut, tension.SpokesOfAWheel),
)

SEVENTH = Half(
    name="seventh",
    rigs={rig.kind: rig for rig in _RIGS},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(
        outside.NeighbourDraws,
        outside.RubsItselfFull,
        outside.FocusBreathes,
        outside.BehindAWire,
        outside.GrossErrors,
    ),
    wrong={"wavy_wall": wavy_wall, "bent_ways": bent_ways},
)
"""Four kinds of rig; two published laws for each effect, and five that no effect describes."""
