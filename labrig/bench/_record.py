"""The track record that labrig shows beside a verdict: how often such a verdict, and such a name, was right."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from labrig.bench._judge import called
from labrig.bench.records import Record
from labrig.contents import TimesThere, TrackRecord
from labrig.diagnosis import SURE, _spectra

NAMING = ("identified", "multiple")
CLAIMS = (*NAMING, "nothing_missing", "unknown")
"""Verdicts that are right or wrong; the others leave the answer open."""


def track_records(records: Iterable[Record]) -> dict[str, TrackRecord]:
    """By their word: how many verdicts were right, of how many; and how often all that they named was there."""
    said: dict[str, list[Record]] = {}
    for record in records:
        said.setdefault(record["answer"]["verdict"], []).append(record)
    return {verdict: _counted(verdict, said[verdict]) for verdict in CLAIMS if verdict in said}


def _counted(verdict: str, records: Sequence[Record]) -> TrackRecord:
    counted: TrackRecord = {"right": sum(bool(r["right"]) for r in records), "of": len(records)}
    if verdict in NAMING:
        counted["there"] = sum(set(r["answer"]["effects"]) <= _may_be_named(r) for r in records)
    return counted


def times_there(records: Iterable[Record]) -> dict[str, TimesThere]:
    """By effect: how often it was there where it was called sure, of how many times."""
    out: dict[str, TimesThere] = {}
    for record in records:
        for effect in sorted(called(record["answer"], SURE) or ()):
            counted = out.setdefault(effect, {"there": 0, "of": 0})
            counted["of"] += 1
            counted["there"] += effect in _may_be_named(record)
    return dict(sorted(out.items()))


def _may_be_named(record: Record) -> set[str]:
    """What is hidden, and the names that the base's own error may go by."""
    return {*record["truth"]["effects"], *(record["truth"].get("also") or ())}


def write_track_records(records: Sequence[Record], path: Path, how: str) -> None:
    """Write both as the file that labrig ships, with how the spectra in use were learnt."""
    spectra = json.loads(_spectra.FILE.read_text(encoding="utf-8"))["how"]
    content = {
        "how": how,
        "spectra": spectra,
        "verdicts": track_records(records),
        "effects": times_there(records),
    }
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
