"""The rigs of the development half, its third portion's among them."""

from labrig.bench.development.rigs._boom import Boom
from labrig.bench.development.rigs._cap import Cap
from labrig.bench.development.rigs._dome import Dome
from labrig.bench.development.rigs._finger import Finger
from labrig.bench.development.rigs._glove import Glove
from labrig.bench.development.rigs._gripper import Gripper
from labrig.bench.development.rigs._joint import Joint
from labrig.bench.development.rigs._muscle import Muscle
from labrig.bench.development.rigs._network import Network
from labrig.bench.development.rigs._origami import Origami
from labrig.bench.development.rigs._plate import Plate
from labrig.bench.development.rigs._platform import Platform
from labrig.bench.development.rigs._pouches import Pouches
from labrig.bench.development.rigs._sheet import Sheet
from labrig.bench.development.rigs._shell import Shell
from labrig.bench.development.rigs._trunk import Trunk
from labrig.bench.development.rigs._tube import Tube
from labrig.bench.development.rigs._wing import Wing
from labrig.bench.development.rigs._wrist import Wrist

__all__ = [
    "Boom",
    "Cap",
    "Dome",
    "Finger",
    "Glove",
    "Gripper",
    "Joint",
    "Muscle",
    "Network",
    "Origami",
    "Plate",
    "Platform",
    "Pouches",
    "Sheet",
    "Shell",
    "Trunk",
    "Tube",
    "Wing",
    "Wrist",
]
