"""The development half of the blind benchmark: its rigs and laws may be looked at while the diagnosis is built."""

from labrig.bench._nature import Half, Law
from labrig.bench.development import (
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
from labrig.bench.development._wrong import another_wall, other_places

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis.PrandtlIshlinskii, hysteresis.Preisach, hysteresis.BoucWen, hysteresis.MaxwellSlip),
    (creep.KelvinVoigtChain, creep.LogarithmicCreep, creep.FindleyPowerLaw, creep.StretchedExponential),
    (regulator.WrongGain, regulator.ZeroOffset, regulator.DeadBand, regulator.BentCharacteristic),
    (leak.ExponentialLeak, leak.OrificeLeak, leak.PorousWall, leak.LiftingSeal),
    (coupling.SupplySag, coupling.PressingNeighbours, coupling.TwoFactorInteraction, coupling.SharedSkin),
    (stiffening.CubicSpring, stiffening.Fung, stiffening.GentLimit, stiffening.SofteningBalloon),
    (gravity.OwnWeight, gravity.InflatedDroop, gravity.LiftedPayload, gravity.PayloadAtAPoint),
    (drift.SteadyDrift, drift.CameraWarmUp, drift.Wander, drift.WarmingRubber, drift.SensorZeroDrift),
    (contact.HardStop, contact.FoamStop, contact.Plane, contact.Post),
    (marker_slip.Jump, marker_slip.SlidingGlue, marker_slip.StickSlip),
    (frame.Shifted, frame.Turned, frame.Scaled, frame.MovedBetweenSessions),
    (delay.FirstOrderLag, delay.DeadTime, delay.CriticallyDamped, delay.DiffusiveLine, delay.SlowSensor),
    (friction.Coulomb, friction.Dahl, friction.LuGre, friction.LoadedCoulomb),
    (rest_shape.ScatteredMarkers, rest_shape.SmoothWarp, rest_shape.CurledSide),
    (tension.LaplaceTension, tension.StringTension, tension.OrthotropicTension),
)

DEVELOPMENT = Half(
    name="development",
    rigs={rig.kind: rig for rig in (rigs.Shell, rigs.Plate, rigs.Finger, rigs.Muscle)},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(
        outside.CyclicSoftening,
        outside.SnapThrough,
        outside.OrderMemory,
        outside.CompressorCycle,
        outside.HealingMullins,
    ),
    wrong={"another_wall": another_wall, "other_places": other_places},
)
"""Four kinds of rig; three to five published laws for each effect, and five that no effect describes."""
