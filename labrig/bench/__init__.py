"""Blind benchmark: campaigns with hidden effects from a separate plant, and how well they are named."""

from labrig.bench._bodies import make_base
from labrig.bench._classes import CLASSES
from labrig.bench._draw import Campaign, draw
from labrig.bench._files import write_campaign, write_model

__all__ = ["CLASSES", "Campaign", "draw", "make_base", "write_campaign", "write_model"]
