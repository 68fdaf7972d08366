"""The eighth portion of the development half: rigs and laws by authors who did not know how effects are named.

Two laws of each effect are those that any engineer writes down first. It is drawn from apart. Its sources are cited
from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development.eighth import (
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
    stiffening,
    tension,
)
from labrig.bench.development.eighth.wrong import needless_products, other_power

_RIGS = (rigs.Mattress, rigs.Tripod, rigs.Press, rigs.Lung, rigs.Curl)

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (
        hysteresis.Backlash,
        hysteresis.UpAndDownCurves,
        hysteresis.BergSpring,
        hysteresis.CoverOfJersey,
        hysteresis.FoldsThatPop,
    ),
    (
        creep.OneVoigtElement,
        creep.NuttingLaw,
        creep.UnconditionedYarn,
        creep.ThinPlacesCreep,
        creep.SeamTapeCreeps,
    ),
    (
        regulator.FullScaleError,
        regulator.FallsShortAtTop,
        regulator.MinimumOnTime,
        regulator.LeakyCurrentLoop,
        regulator.TrimmedAtMidScale,
    ),
    (
        leak.ExponentialBleed,
        leak.ConstantLossRate,
        leak.PinholeStretchesOpen,
        leak.SeamWeepsAboveLoad,
        leak.DissolvesInRubber,
    ),
    (
        coupling.LinearCrosstalk,
        coupling.BilinearNeighbours,
        coupling.PinholedSeptum,
        coupling.BulgingPartition,
        coupling.SharedSleeve,
    ),
    (
        stiffening.ComplianceFallsOff,
        stiffening.DuffingWall,
        stiffening.WavyFibresStraighten,
        stiffening.ThinsAsItStretches,
        stiffening.FillerNetwork,
    ),
    (
        gravity.SagsByOwnWeight,
        gravity.HangingMass,
        gravity.WallsLiftTheBody,
        gravity.DroopsAsItReaches,
        gravity.InflatedBeamCarries,
    ),
    (
        drift.ClockDrift,
        drift.SoftensAsItWarms,
        drift.HeatingOnAndOff,
        drift.GaugesWalk,
        drift.NylonDrinksWater,
    ),
    (
        contact.StopAtDeflection,
        contact.AgainstTheBench,
        contact.SoftBumper,
        contact.LandsOnCradle,
        contact.ClosesOnObject,
    ),
    (
        marker_slip.MarkerMoves,
        marker_slip.FewMarkersMove,
        marker_slip.SlidesDownhill,
        marker_slip.WipedByACloth,
        marker_slip.HalfPeeledDot,
    ),
    (
        frame.FrameShiftedAndTurned,
        frame.OriginOff,
        frame.TripodKicked,
        frame.ClampedAnew,
        frame.TurningAxisElsewhere,
    ),
    (delay.OnePole, delay.DeadTimeAndPole, delay.LongHoses, delay.OneEuroFilter, delay.SmallExhaust),
    (
        friction.DryFriction,
        friction.StribeckCurve,
        friction.BraidRubs,
        friction.RestsOnTable,
        friction.SealOfPiston,
    ),
    (
        rest_shape.RestGeometryOff,
        rest_shape.PreBentBody,
        rest_shape.ShrunkInMould,
        rest_shape.KinkFromStorage,
        rest_shape.SeamPuckers,
    ),
    (
        tension.InitialTension,
        tension.FilmOnRing,
        tension.LooseSkin,
        tension.PreStrainOfElastomer,
        tension.SkinPulledAskew,
    ),
)

EIGHTH = Half(
    name="eighth",
    rigs={rig.kind: rig for rig in _RIGS},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(
        outside.ToolLeftOnIt,
        outside.HosesStraighten,
        outside.LampInTheEye,
        outside.LinesOfTheScale,
        outside.StrandBreaks,
    ),
    wrong={"other_power": other_power, "needless_products": needless_products},
)
"""Five kinds of rig; five laws for each effect, and five that no effect describes."""
