"""When a text table says, above its names, that its recording began."""

import re
from datetime import UTC, datetime, timedelta
from itertools import islice
from pathlib import Path

from labrig.tables._mapping import Format
from labrig.tables._names import TIME, take_apart
from labrig.tables._packed import open_text
from labrig.tables._text import find_encoding

_DAY = r"(?P<day>\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/.]\d{1,2}[-/.]\d{4})"
_CLOCK = r"(?P<clock>\d{1,2}[:.]\d{2}[:.]\d{2}(?:[.,]\d+)?)\s*(?P<half>[AP]M)?"
_BOTH = re.compile(rf"\b{_DAY}[T ,;\t]+{_CLOCK}", re.I)
_DAY_ALONE = re.compile(rf"\b{_DAY}\b")
_CLOCK_ALONE = re.compile(rf"\b{_CLOCK}", re.I)
_STARTS = {
    "start", "started", "begin", "began", "begins", "beginning", "beginn", "startzeit", "début", "debut", "inicio",
    "inizio",
}  # fmt: skip
_OF = {
    "capture", "captured", "recording", "record", "recorded", "measurement", "measured", "acquisition", "test", "trial",
    "log", "data", "experiment", "aufnahme", "messung", "and", "at", "on", "of", "the",
}  # fmt: skip
_LINES = 200


def begun(path: Path, how: Format) -> tuple[tuple[float, ...], int] | None:
    """When the recording began, s since 1970 by the clock on the wall, and the line that says it; None where none does.

    There are two where the line leaves open which number is the day, as in 04/05/2026. A name of it says that it is a
    beginning, a time or a date, and nothing else: when a file was exported is another time.
    """
    encoding = how.encoding or find_encoding(path)
    with open_text(path, encoding, "replace") as file:
        lines = [line.strip() for line in islice(file, min(how.skip_rows, _LINES))]
    found: list[tuple[bool, int, tuple[float, ...]]] = []
    day: tuple[str, int] | None = None
    for number, line in enumerate(lines, start=1):
        whole = False
        for both in _BOTH.finditer(line):
            if words := _words_before(line, both.start()):
                found.append(
                    (not words & _STARTS, number, _seconds(both["day"], both["clock"], both["half"]))
                )
            whole = True
        if whole:
            continue
        if (alone := _DAY_ALONE.search(line)) and _words_before(line, alone.start()):
            day = day or (alone["day"], number)
        elif day and (clock := _CLOCK_ALONE.search(line)) and _words_before(line, clock.start()):
            found.append((True, day[1], _seconds(day[0], clock["clock"], clock["half"])))
            day = None
    known = [one for one in found if one[2]]
    return next(((own, number) for _, number, own in sorted(known)), None)


def _words_before(line: str, at: int) -> set[str]:
    """The words of the name before a date, where they call it a beginning, a time or a date; else none."""
    name = re.split(r"[,;\t]", line[:at].rstrip(" \"',;:=\t"))[-1].strip(" \"'#%")
    words = set(take_apart(name).words) if name else set()
    return words if words & (_STARTS | TIME) and words <= _STARTS | TIME | _OF else set()


def _seconds(day: str, clock: str, half: str | None) -> tuple[float, ...]:
    """A date and a time of day, s since 1970, in each way in which the date can be read."""
    one, two, three = (int(part) for part in re.split(r"[-/.]", day))
    if len(day.split(re.sub(r"\d", "", day)[0])[0]) == 4:
        dates = [(one, two, three)]
    else:
        dates = [(three, two, one)] + [(three, one, two)] * ("." not in day and one != two)
    hour, minute, second = re.split(r"[:.]", clock.replace(",", "."), maxsplit=2)
    hours = int(hour) % 12 + 12 * (half.lower() == "pm") if half else int(hour)
    out = []
    for date in dates:
        try:
            out.append(
                (datetime(*date, tzinfo=UTC) + timedelta(hours=hours, minutes=int(minute))).timestamp()
                + float(second)
            )
        except ValueError:
            continue
    return tuple(out)
