"""The fourth portion of the development half: rigs and laws by an author who did not know how effects are named.

It is drawn from apart. Its sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development._wrong import another_wall, other_places
from labrig.bench.development.fourth import (
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

_RIGS = (rigs.Tower, rigs.Iris, rigs.Bell, rigs.Cushion, rigs.Toggle, rigs.Cuff)

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis.SuperelasticWires, hysteresis.PinchedLoop, hysteresis.VectorPlay),
    (creep.DrainingFoam, creep.DavidsonCole, creep.GreenRivlin),
    (regulator.BitWeights, regulator.NozzleFlapper, regulator.BridgeOfOneGauge),
    (leak.WetPores, leak.Labyrinth, leak.SelfSealing),
    (coupling.BridgedValley, coupling.MufflerBackPressure, coupling.SharedPowerSupply),
    (stiffening.CrushedFoam, stiffening.LockingFibres, stiffening.RealNetwork),
    (gravity.HangingSkin, gravity.StandingColumn, gravity.OffCentreLoad),
    (drift.WarmsAndCools, drift.BentBoom, drift.SettlingStand),
    (contact.RoughStop, contact.AdhesiveStop, contact.SelfContact),
    (marker_slip.HangsLoose, marker_slip.SlipsInAvalanches, marker_slip.BubblesUnderTape),
    (frame.SevenParameters, frame.ThroughPane, frame.WrongDisparity),
    (delay.TicksOfClock, delay.SmoothRamp, delay.SqueezedGas),
    (friction.PeakBeforeSliding, friction.RubberUnderLoad, friction.RowOfWells),
    (rest_shape.RippledEdge, rest_shape.Helix, rest_shape.MisplacedModules),
    (tension.BandOverHinge, tension.PreloadUsedUp, tension.TightHoop),
)

FOURTH = Half(
    name="fourth",
    rigs={rig.kind: rig for rig in _RIGS},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(outside.SwappedLabels, outside.Hunting, outside.WaterInLine, outside.Ratcheting),
    wrong={"another_wall": another_wall, "other_places": other_places},
)
"""Six kinds of rig; three published laws for each effect, and four that no effect describes."""
