"""How often each verdict, and each name that was sure, was right on laws that nothing was learnt from.

The probability of a verdict takes for granted that each law is of one of the families, which no law quite is. How much
that is worth was counted: `labrig bench blind --record`.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

from labrig.contents import TimesThere, TrackRecord

FILE = Path(__file__).with_name("track_record.json")


def track_record(verdict: str) -> TrackRecord | None:
    """How many such verdicts were right, of how many; None of one that was not counted."""
    return shipped().get("verdicts", {}).get(verdict)


def times_there(effect: str) -> TimesThere | None:
    """How often this effect was there where it was called sure; None of one that never was, or not of labrig's own."""
    return shipped().get("effects", {}).get(effect)


@cache
def shipped() -> dict[str, dict[str, Any]]:
    """What was counted, by verdict and by effect."""
    return json.loads(FILE.read_text(encoding="utf-8")) if FILE.is_file() else {}
