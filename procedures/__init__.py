"""Procedures: what a lab user reads, copies and edits."""

from procedures._capture import Capture

__all__ = ["Capture"]
