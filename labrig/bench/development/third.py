"""The third portion of the development half: rigs and laws that nobody had seen who worked on the naming before.

It is drawn from apart. Its sources are cited from memory.
"""

from labrig.bench._nature import Half, Law
from labrig.bench.development import (
    contact_third,
    coupling_third,
    creep_third,
    delay_third,
    drift_third,
    frame_third,
    friction_third,
    gravity_third,
    hysteresis_third,
    leak_third,
    marker_slip_third,
    outside_third,
    regulator_third,
    rest_shape_third,
    rigs,
    stiffening_third,
    tension_third,
)
from labrig.bench.development._wrong import another_wall, other_places

_RIGS = (
    *(rigs.Trunk, rigs.Wrist, rigs.Origami, rigs.Sheet, rigs.Gripper),
    *(rigs.Network, rigs.Cap, rigs.Wing, rigs.Boom),
)

_LAWS: tuple[tuple[type[Law], ...], ...] = (
    (hysteresis_third.KrasnoselskiiPokrovskii, hysteresis_third.MasingBranches, hysteresis_third.Endochronic),
    (creep_third.HardeningFlow, creep_third.BinghamBody, creep_third.QuasiLinear, creep_third.SinkingBacking),
    (
        regulator_third.EqualPercentage,
        regulator_third.IndependentLinearity,
        regulator_third.WrongTable,
        regulator_third.PulsedValve,
    ),
    (leak_third.Crack, leak_third.HiddenPocket, leak_third.StretchedPinhole, leak_third.DirtySeat),
    (
        coupling_third.RunsOut,
        coupling_third.TurnedAlong,
        coupling_third.BowedSeptum,
        coupling_third.BeamColumn,
    ),
    (
        stiffening_third.RambergOsgood,
        stiffening_third.HollomonPower,
        stiffening_third.RichardAbbott,
        stiffening_third.ChangingArea,
    ),
    (
        gravity_third.MovedMass,
        gravity_third.SpringMount,
        gravity_third.WeightAtTip,
        gravity_third.WeightOnLever,
    ),
    (
        drift_third.LogarithmOfTime,
        drift_third.Flicker,
        drift_third.WeatherFront,
        drift_third.SwellingFrame,
    ),
    (contact_third.RoundCage, contact_third.SpringBeyond, contact_third.Wedge, contact_third.Tether),
    (
        marker_slip_third.SaggingTape,
        marker_slip_third.SlipsAtLargeMotions,
        marker_slip_third.TurnedPlate,
        marker_slip_third.PushedAside,
    ),
    (frame_third.Screw, frame_third.DecentredLens, frame_third.Keystone, frame_third.NewWandEachTime),
    (
        delay_third.TanksInSeries,
        delay_third.OrificeFilling,
        delay_third.TakingTurns,
        delay_third.LeadAndLag,
    ),
    (
        friction_third.AgeingContacts,
        friction_third.LyingHairs,
        friction_third.BowdenSheath,
        friction_third.ConeUnderMarkers,
    ),
    (
        rest_shape_third.Saddle,
        rest_shape_third.TaperedCast,
        rest_shape_third.KinkedSeam,
        rest_shape_third.ZernikeFigure,
    ),
    (tension_third.PrestretchedCord, tension_third.SaggingGuy, tension_third.SlackBundle),
)

THIRD = Half(
    name="third",
    rigs={rig.kind: rig for rig in _RIGS},
    laws={laws[0].effect: laws for laws in _LAWS},
    outside=(
        outside_third.BucklesEitherWay,
        outside_third.LostCommands,
        outside_third.StickingWalls,
        outside_third.Thixotropy,
        outside_third.MergedBlobs,
    ),
    wrong={"another_wall": another_wall, "other_places": other_places},
)
"""Nine kinds of rig; three or four published laws for each effect, and five that no effect describes."""
