"""A diagnosis that runs beside the campaign, and what it decides."""

from labrig.live._adviser import LiveDiagnosis
from labrig.live._look import Look
from labrig.live._looker import Looker
from labrig.live._rule import MISSED, STEADY, Rule
from labrig.live._serve import RECORD, lower_priority, serve
from labrig.live._settings import EVERY, Settings
from labrig.live._words import look_line

__all__ = [
    "EVERY",
    "MISSED",
    "RECORD",
    "STEADY",
    "LiveDiagnosis",
    "Look",
    "Looker",
    "Rule",
    "Settings",
    "look_line",
    "lower_priority",
    "serve",
]
