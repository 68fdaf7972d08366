"""The rigs of the development half."""

from labrig.bench.development.rigs._dome import Dome
from labrig.bench.development.rigs._finger import Finger
from labrig.bench.development.rigs._glove import Glove
from labrig.bench.development.rigs._joint import Joint
from labrig.bench.development.rigs._muscle import Muscle
from labrig.bench.development.rigs._plate import Plate
from labrig.bench.development.rigs._platform import Platform
from labrig.bench.development.rigs._pouches import Pouches
from labrig.bench.development.rigs._shell import Shell
from labrig.bench.development.rigs._tube import Tube

__all__ = ["Dome", "Finger", "Glove", "Joint", "Muscle", "Plate", "Platform", "Pouches", "Shell", "Tube"]
