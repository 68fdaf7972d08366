"""The exam half of the blind benchmark: rigs and laws from the literature, written without a look at the diagnosis."""

from labrig.bench._nature import Half
from labrig.bench.exam.arm import Arm
from labrig.bench.exam.contact import CylinderWall, HertzBarrier, TwoChamberStop
from labrig.bench.exam.coupling import ManifoldCrosstalk, SaturatingCrosstalk
from labrig.bench.exam.creep import BroadProny, Schapery, Springpot
from labrig.bench.exam.delay import MovingAverageSensor, TransportLine, ViscousValve
from labrig.bench.exam.drift import LogSettling, RandomWalk, RoomTemperature
from labrig.bench.exam.frame import AffineSkew, FarRotation, Reregistered
from labrig.bench.exam.friction import Capstan, IwanPresliding
from labrig.bench.exam.gravity import LargeSag, TipLoad
from labrig.bench.exam.gripper import Gripper
from labrig.bench.exam.hysteresis import ColemanHodgdon, KrasnoselskiiPokrovskii
from labrig.bench.exam.leak import LipSeal, NeighbourLeak
from labrig.bench.exam.marker_slip import LooseningUnderLoad, SwappedLabels
from labrig.bench.exam.outside import CompressorCycle, HotSpot, OrderMemory, SnapThrough
from labrig.bench.exam.regulator import QuantisedSetPoint, SensorSShape, SupplySaturation
from labrig.bench.exam.rest_shape import PermanentSet, SwellingPattern
from labrig.bench.exam.skin import Skin
from labrig.bench.exam.stiffening import ArrudaBoyce, BilinearWall, Yeoh
from labrig.bench.exam.tension import FopplPretension, PreStretchGradient
from labrig.bench.exam.wrong import saturating_wall, without_cross_curvature, wrong_lever_arm

EXAM = Half(
    name="exam",
    rigs={rig.kind: rig for rig in (Arm, Skin, Gripper)},
    laws={
        "hysteresis": (ColemanHodgdon, KrasnoselskiiPokrovskii),
        "creep": (Springpot, Schapery, BroadProny),
        "regulator": (SupplySaturation, QuantisedSetPoint, SensorSShape),
        "leak": (NeighbourLeak, LipSeal),
        "coupling": (ManifoldCrosstalk, SaturatingCrosstalk),
        "stiffening": (Yeoh, ArrudaBoyce, BilinearWall),
        "gravity": (LargeSag, TipLoad),
        "drift": (RoomTemperature, LogSettling, RandomWalk),
        "contact": (HertzBarrier, CylinderWall, TwoChamberStop),
        "marker_slip": (SwappedLabels, LooseningUnderLoad),
        "frame": (AffineSkew, FarRotation, Reregistered),
        "delay": (ViscousValve, TransportLine, MovingAverageSensor),
        "friction": (IwanPresliding, Capstan),
        "rest_shape": (SwellingPattern, PermanentSet),
        "tension": (FopplPretension, PreStretchGradient),
    },
    outside=(HotSpot, SnapThrough, CompressorCycle, OrderMemory),
    wrong={
        "without_cross_curvature": without_cross_curvature,
        "wrong_lever_arm": wrong_lever_arm,
        "saturating_wall": saturating_wall,
    },
)

__all__ = ["EXAM"]
