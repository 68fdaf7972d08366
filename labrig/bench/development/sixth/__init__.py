"""The sixth portion of the development half: rigs and laws by an author who did not know how effects are named.

It is drawn from apart. Its sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development._wrong import another_wall, other_places
from labrig.bench.development.sixth import (
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
    *(rigs.Vine, rigs.Tongue, rigs.Crawler, rigs.Ray),
    *(rigs_blind.Heart, rigs_blind.Suit, rigs_blind.Mirror, rigs_blind.Links),
)

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis.FlagLoops, hysteresis.TrainsRubberSpring, hysteresis.RoundedPlateaus),
    (creep.LogOfPower, creep.WaterInGel, creep.WedgeOfTimes),
    (regulator.CapacitiveGauge, regulator.SlantedPointer, regulator.LowSupply, regulator.DiodeDrop),
    (leak.FillsSites, leak.FoamOfCells, leak.BubbleByBubble),
    (coupling.KinkedHoses, coupling.PullsAtAnAngle, coupling.OnlyThreeTogether),
    (
        stiffening.StrainedBeforehand,
        stiffening.PowerOfStrain,
        stiffening.TurningBraid,
        stiffening.DiscSprings,
    ),
    (gravity.InvertedPendulum, gravity.OnTwoSupports, gravity.LoadedPlate, gravity.InABath),
    (drift.OpenedDoors, drift.IntegratedTwice, drift.StillCuring),
    (contact.ConeTip, contact.FlattenedBulge, contact.PlatesInTurn, contact.RoundBar),
    (marker_slip.WandersByChance, marker_slip.OilUnderIt, marker_slip.UnscrewsItself),
    (frame.FisheyeAsPinhole, frame.DomedModel, frame.EncoderOffAxis),
    (delay.BesselsFilter, delay.TubeByConductance, delay.PilotValve, delay.GrowingVolume),
    (friction.ResetBristles, friction.BrittleOrDuctile, friction.AreaFillsUp),
    (
        rest_shape.PrintedInLayers,
        rest_shape.RoughSkin,
        rest_shape.SwollenSpot,
        rest_shape.SinksOverRibs,
    ),
    (tension.CapOfFilm, tension.SpringsAcross, tension.WoundOnTight),
)

SIXTH = Half(
    name="sixth",
    rigs={rig.kind: rig for rig in _RIGS},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(
        outside.CameraHandover,
        outside.EveryOtherTime,
        outside.CarryOver,
        outside.LooseContact,
        outside.NewFolds,
    ),
    wrong={"another_wall": another_wall, "other_places": other_places},
)
"""Eight kinds of rig; three or four published laws for each effect, and five that no effect describes."""
