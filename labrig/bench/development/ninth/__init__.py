"""The ninth portion of the development half: rigs and laws by three authors who did not know how effects are named.

Laws are those that each author held for the best known. It is drawn from apart. Its sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development.ninth import (
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
from labrig.bench.development.ninth.wrong import added_up, low_polynomial, stiffness_ratio

_RIGS = (rigs.Dome, rigs.FibreFinger, rigs.TwoSegmentArm, rigs.Twister, rigs.PouchSheet)

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (
        hysteresis.PreisachRelays,
        hysteresis.BoucWenSpring,
        hysteresis.PrandtlIshlinskiiPlays,
        hysteresis.EndochronicBody,
        hysteresis.SlippingElementsAtPlaces,
    ),
    (
        creep.BurgersBody,
        creep.CreepByDecades,
        creep.StretchedExponentialBody,
        creep.SpringpotInParallel,
        creep.SpectrumByPlace,
    ),
    (
        regulator.SpanError,
        regulator.ZeroShift,
        regulator.SpoolOverlap,
        regulator.BowedSensor,
        regulator.ExhaustHolds,
    ),
    (leak.Capillary, leak.Orifice, leak.PermeatedSkin, leak.CrackInTheWhole, leak.Pinholes),
    (
        coupling.SharedSupply,
        coupling.LeakyPartition,
        coupling.WallsTouch,
        coupling.SeptumBulges,
        coupling.HeldStiff,
    ),
    (
        stiffening.LimitedChains,
        stiffening.NeoHookean,
        stiffening.LargeDeflection,
        stiffening.Exponential,
        stiffening.SleeveLocks,
    ),
    (
        gravity.CantileverSags,
        gravity.LoadAtTheTip,
        gravity.HingeAtTheRoot,
        gravity.ChambersBearTheWeight,
        gravity.FilledWallsGiveLess,
    ),
    (drift.WarmsUp, drift.ZerosWander, drift.FrameBreathes, drift.RubberWarms, drift.SensorsAge),
    (
        contact.AdjustableEndStop,
        contact.HertzPad,
        contact.SpringBeforeTheWhole,
        contact.WallInSpace,
        contact.BedOfSprings,
    ),
    (
        marker_slip.KnockedAside,
        marker_slip.PeelsSteadily,
        marker_slip.Dangles,
        marker_slip.StuckOnElsewhere,
        marker_slip.StemBent,
    ),
    (frame.DatumOff, frame.CameraBumped, frame.WandTooLong, frame.BadRegistration, frame.CalibratedAnew),
    (delay.DeadTimeAndLag, delay.SlowValve, delay.HeavyBody, delay.AveragingSensor, delay.NarrowChannel),
    (
        friction.DahlFriction,
        friction.LuGreBristles,
        friction.TendonsRoundTheBend,
        friction.RubberSleeve,
        friction.DraggedPlaces,
    ),
    (
        rest_shape.Tolerances,
        rest_shape.Shrinkage,
        rest_shape.Warp,
        rest_shape.BlisteredLayer,
        rest_shape.MouldMismatch,
    ),
    (tension.BulgeEquation, tension.Prestretched, tension.Slack, tension.TautString, tension.CapOfLaplace),
)

NINTH = Half(
    name="ninth",
    rigs={rig.kind: rig for rig in _RIGS},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(
        outside.LensDistortion,
        outside.CompressorCycles,
        outside.SnapsThrough,
        outside.CoilsDisturb,
        outside.ValveMisses,
        outside.Draught,
    ),
    wrong={"added_up": added_up, "low_polynomial": low_polynomial, "stiffness_ratio": stiffness_ratio},
)
"""Five kinds of rig; five laws for each effect, and six that no effect describes."""
