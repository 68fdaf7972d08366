"""A diagnosis that runs beside the campaign, and what it decides."""

from labrig.live._adapt import MINUTES, Range
from labrig.live._adviser import LiveDiagnosis
from labrig.live._look import Look
from labrig.live._looker import Looker
from labrig.live._rule import MISSED, STEADY, Rule
from labrig.live._serve import RECORD, lower_priority, serve
from labrig.live._settings import EVERY, Settings
from labrig.live._words import look_line

__all__ = [
    "EVERY",
    "MINUTES",
    "MISSED",
    "RECORD",
    "STEADY",
    "LiveDiagnosis",
    "Look",
    "Looker",
    "Range",
    "Rule",
    "Settings",
    "look_line",
    "lower_priority",
    "serve",
]
