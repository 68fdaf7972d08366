"""Surfaces as labrig handles them: B-splines over the unit square, and what is done with them."""

from labrig.surface._spline import Spline, grid

__all__ = ["Spline", "grid"]
