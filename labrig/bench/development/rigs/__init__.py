"""The rigs of this half, one kind each file."""

from labrig.bench.development.rigs._finger import Finger
from labrig.bench.development.rigs._muscle import Muscle
from labrig.bench.development.rigs._plate import Plate
from labrig.bench.development.rigs._shell import Shell

__all__ = ["Finger", "Muscle", "Plate", "Shell"]
