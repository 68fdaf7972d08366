"""What a log says of itself before its first message: names, units, limits, and where it came from."""

import json
import zlib
from dataclasses import asdict, dataclass, field
from typing import Any

from labrig._errors import LabrigError
from labrig_schema import VERSION


@dataclass(frozen=True)
class Layout:
    """The names and units of everything in a log; lists of numbers are in the order of their names.

    `chamber_min`, `chamber_max` are in `unit`; `rest_mm` is None where nobody knows; observables are
    (name, unit, marker or "", axis or ""), covariates (name, unit). `observable_rest_mm`: where the marker of each
    observable is at rest, NaN where nobody knows, or None. `variables` names the optional Dataset variables of a table
    (`table`: the rows are on /observation). `attributes` are passed on to the Dataset.
    """

    chambers: tuple[str, ...]
    chamber_min: tuple[float, ...]
    chamber_max: tuple[float, ...]
    unit: str = "kPa"
    markers: tuple[str, ...] = ()
    rest_mm: tuple[tuple[float, float, float], ...] | None = None
    observables: tuple[tuple[str, str, str, str], ...] = ()
    covariates: tuple[tuple[str, str], ...] = ()
    variables: tuple[str, ...] = ()
    source: str = "rig"
    between_sessions: str = "vented"
    start_s: float = 0.0
    table: bool = False
    session: str = "0"
    attributes: dict[str, Any] = field(default_factory=dict)
    observable_rest_mm: tuple[tuple[float, float, float], ...] | None = None


def layout_to_text(layout: Layout) -> str:
    """The layout as JSON; NaN and infinity are written as Python's json does."""
    fields = asdict(layout)
    if layout.observable_rest_mm is None:  # so that an older labrig reads it
        del fields["observable_rest_mm"]
    return json.dumps(fields)


def layout_from_text(text: str) -> Layout:
    """The inverse of `layout_to_text`."""
    fields = json.loads(text)
    for name in ("chambers", "chamber_min", "chamber_max", "markers", "variables"):
        fields[name] = tuple(fields[name])
    for name in ("observables", "covariates"):
        fields[name] = tuple(tuple(item) for item in fields[name])
    if fields.get("between_sessions") == "released":  # the word of older logs
        fields["between_sessions"] = "vented"
    for name in ("rest_mm", "observable_rest_mm"):
        if fields.get(name) is not None:
            fields[name] = tuple(tuple(point) for point in fields[name])
    return Layout(**fields)


def pack_metadata(text: str) -> dict[str, str]:
    """A metadata record that says whether it is whole: MCAP has no checksum for metadata."""
    version = str(VERSION)
    return {"version": version, "json": text, "crc32": _checksum(version, text)}


def _checksum(version: str, text: str) -> str:
    return f"{zlib.crc32(f'{version} {text}'.encode()):08x}"


def unpack_metadata(record: dict[str, str], where: str) -> str | None:
    """The text of a metadata record, or None if it is damaged.

    Raises `LabrigError` when a newer labrig wrote it.
    """
    text, number = record.get("json"), record.get("version", "")
    if text is None or record.get("crc32") != _checksum(number, text):
        return None
    version = int(number)
    if version > VERSION:
        raise LabrigError(
            f"{where} was written by a newer labrig (log version {version}, this one reads up to {VERSION}); "
            "update labrig"
        )
    return migrate(text, version)


MIGRATIONS: dict[int, Any] = {}
"""Log version -> function that turns that version's layout or run text into the next version's."""


def migrate(text: str, version: int) -> str:
    """Bring a layout or run text of an older version up to date, one version at a time."""
    while version < VERSION:
        text = MIGRATIONS[version](text)
        version += 1
    return text
