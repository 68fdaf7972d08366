"""How often each verdict was right in the benchmark, on laws and rigs that nothing was learnt from.

The probability of a verdict takes for granted that each law is of one of the families, which no law quite is. How much
that is worth was counted: `labrig bench blind --record`.
"""

import json
from functools import cache
from pathlib import Path

from labrig.contents import TrackRecord

FILE = Path(__file__).with_name("track_record.json")


def track_record(verdict: str) -> TrackRecord | None:
    """How many such verdicts were right, of how many; None of one that was not counted."""
    return shipped().get(verdict)


@cache
def shipped() -> dict[str, TrackRecord]:
    """What was counted, by verdict."""
    return json.loads(FILE.read_text(encoding="utf-8"))["verdicts"] if FILE.is_file() else {}
