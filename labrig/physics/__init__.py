"""The simulator that a rig's models start from: pressures in, the shape of the inflated surface out."""

from labrig.physics._surface import Surface, load_surface

__all__ = ["Surface", "load_surface"]
