"""Captures of one file: holds are checked, and a moving input is cut into named segments whose rows count singly."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.log._part import Part, session_blocks
from labrig.tables import Segment, find_segments, goes_back_and_forth, held_share, is_set

_HELD = 0.8
_BRIEF = 0.5
_MOVING = 4
"""In so many rows an input changes within a capture at least, if it is a ramp and no hold that was cut wrongly."""
_LEVELS = 5
"""What has fewer different values flickers by the step in which it was recorded, and does not move."""
_STREAM_ROWS = 30
_EVEN = 0.5
_HELD_JITTER = 0.05
_WAITED = 2.0
"""How many times as long as between two rows of a hold it is before the first, from which on it is asked since when."""
_APART = 0.15
"""Share of the range from which on two rows are other set-points, and no neighbours of a record."""
_CELLS = 20_000_000
"""Holds of very unequal lengths are padded to the longest: beyond this many cells their rows count singly."""


def cut(part: Part) -> None:
    """Settle the captures of a file and name its segments."""
    how = part.mapping.capture
    if part.file.events:
        _holds(part)
    elif how is not None and how.per == "segment":
        _segments(part)
    elif how is not None:
        _holds(part)
    elif part.mapping.time is not None and _is_stream(part) and not _scattered(part):
        _name(part)
    _settled(part)
    lengths = np.diff(np.r_[part.starts, part.n])
    if len(lengths) * lengths.max() > max(_CELLS, 20 * part.n):
        part.remarks.append(
            f"{part.table.path.name}: its captures are too unequal: their rows count one by one"
        )
        part.each_alone(np.ones(part.n, dtype=bool))
    _say_unmeasured(part)


def _say_unmeasured(part: Part) -> None:
    """Say how many captures, or rows of one each, have no measurement: they make no capture of the run."""
    starts = part.starts
    meant = np.logical_or.reduceat(part.keep, starts)
    seen = np.logical_or.reduceat(np.isfinite(part.values).any(axis=1), starts)
    lost = np.flatnonzero(meant & ~seen)
    if not len(lost) or not seen.any() or part.file.events:
        return
    what = "rows" if len(starts) == part.n else "captures"
    have = "has" if len(lost) == 1 else "have"
    first = part.table.at(int(starts[lost[0]])).rpartition(", ")[2]
    part.remarks.append(
        f"{part.table.path.name}: {len(lost)} of {int(meant.sum())} {what} {have} no measurement ({first}"
        f"{', ...' if len(lost) > 1 else ''}): what was commanded there is history, and there is nothing to compare"
    )


def _settled(part: Part) -> None:
    """Set-points were actuated `settle_s` before their first row; a remark where there was time, and nobody says so.

    Rows of a moving input, which count one by one, belong to no hold. Raises `LabrigError` where the row before is
    nearer than that.
    """
    starts, lengths = part.starts, np.diff(np.r_[part.starts, part.n])
    if part.mapping.hold is not None or part.file.events or part.mapping.time is None:
        return
    held = (lengths > 1) | (part.segment[starts] == "")
    follows = np.r_[False, part.session[starts[1:]] == part.session[starts[1:] - 1]]
    gap_s = part.time_s[starts] - np.r_[-np.inf, part.time_s[starts[1:] - 1]]
    settle_s = part.mapping.settle_s
    if settle_s is None:
        within_s = np.diff(part.time_s)[np.diff(part.capture) == 0]
        usual_s = float(np.median(gap_s[held & follows])) if (held & follows).any() else 0.0
        if len(within_s) and usual_s > _WAITED * float(np.median(within_s)):
            part.remarks.append(
                f"{part.table.path.name}: {usual_s:.3g} s lie between the last row of a set-point and the first of the "
                "next, and each hold is taken to begin at its first row: if it was actuated before, write how long "
                "before, such as 'settle_s: 3'"
            )
        return
    early = held & follows & (gap_s < settle_s)
    if early.any():
        i = int(np.argmax(early))
        raise LabrigError(
            f"{part.table.at(int(starts[i]))}: settle_s is {settle_s:g} s, but the row before, of another set-point, "
            f"is only {gap_s[i]:.3g} s earlier"
        )
    since = part.time_s - np.repeat(part.time_s[starts], lengths) + settle_s
    part.hold_s = np.where(np.repeat(held, lengths), since, part.hold_s)


def _holds(part: Part) -> None:
    """A capture is held at one actuation, small jitter of a measured one let pass; what moves all along is a stream.

    Raises `LabrigError` where it only steps: then two holds are called one.
    """
    starts, u = part.starts, part.actuation
    span = np.maximum(np.ptp(u, axis=0), np.abs(u).max(axis=0) * 0.05)
    spread = np.maximum.reduceat(u, starts) - np.minimum.reduceat(u, starts)
    moved = (spread > np.maximum(0.05 * span, 1e-12)).any(axis=1)
    if not moved.any():
        return
    steps = np.r_[False, (np.abs(np.diff(u, axis=0)) > 1e-3 * span + 1e-12).any(axis=1)]
    steps[starts] = False
    lengths = np.diff(np.r_[starts, part.n])
    wrong = moved & (np.add.reduceat(steps, starts) < _MOVING)
    if wrong.any():
        name = part.mapping.actuation[int(np.argmax(spread[wrong][0]))].name
        raise LabrigError(
            f"{part.table.at(int(starts[wrong][0]))}: actuation {name!r} changes within one capture; leave 'capture:' "
            "out to take every row as one, or write 'capture: {per: segment}' to have the holds found"
        )
    rows = np.repeat(moved, lengths)
    first = int(starts[moved][0])
    c = int(np.argmax(spread[moved][0]))
    names = _labels(part)
    part.segment[rows] = np.repeat(names, lengths)[rows]
    part.each_alone(rows)
    part.remarks.append(
        f"{part.table.at(first)}: actuation {part.mapping.actuation[c].name!r} moves within {names[moved][0]}: "
        f"{int(moved.sum())} of {len(starts)} captures are no holds, and their rows count one by one"
    )


def _labels(part: Part) -> NDArray[np.object_]:
    """What each capture is called: by the label of its first row, or by its file."""
    starts = part.starts
    how = part.mapping.capture
    if how is not None and how.column is not None:
        own = part.table.labels(how.column, "capture")[starts]
        return np.array([f"capture {label}" for label in own], dtype=object)
    if len(starts) == 1:
        return np.array([part.table.path.stem], dtype=object)
    return np.array([f"{part.table.path.stem} {i + 1}" for i in range(len(starts))], dtype=object)


def _segments(part: Part) -> None:
    """Plateaus become captures where the input is held most of the time; otherwise every row is one, with a name."""
    if _scattered(part):
        part.each_alone(np.ones(part.n, dtype=bool))
        part.remarks.append(f"{part.table.path.name}: {part.n} set-points of one row each")
        return
    found = _name(part)
    if _are_holds(part, [s for _, s in found]):
        _plateaus(part, found)
        return
    part.each_alone(np.ones(part.n, dtype=bool))
    count = {kind: sum(s.kind == kind for _, s in found) for kind in ("plateau", "ramp", "cycle")}
    words = ", ".join(f"{n} {kind}{'s' if n > 1 else ''}" for kind, n in count.items() if n)
    how = f": {words}" if words else " that moves neither by ramps nor by even cycles"
    part.remarks.append(f"{part.table.path.name}: a stream of {part.n} rows{how}")


def _are_holds(part: Part, found: Sequence[Segment]) -> bool:
    """Whether the input is held most of the time; where it never moves at all, whether nothing else moved the body."""
    moves = [s.end - s.begin for s in found if s.kind != "plateau"]
    holds = [s.end - s.begin for s in found if s.kind == "plateau"]
    brief = not moves or (holds and max(moves) <= _BRIEF * np.median(holds))
    if not holds or not brief or held_share(found) < _HELD:
        return False
    if moves or len(holds) > 1 or (name := _driven(part)) is None:
        return True
    part.remarks.append(
        f"{part.table.path.name}: no input moves, and {name!r} goes back and forth to the end: something else moved "
        "it, and the rows count one by one; if that was logged, put it under 'actuation:'"
    )
    return False


def _driven(part: Part) -> str | None:
    """What was measured, and goes back and forth over most of its range until the end; None where nothing does.

    What a hold does by itself (creep, a leak, a vibration at its beginning) goes one way, or comes to rest.
    """
    names = [m.name for m in part.mapping.actuation] + [o.name for o in part.observables]
    for name, column in zip(names, np.column_stack([part.measured, part.values]).T, strict=True):
        seen = column[np.isfinite(column)]
        if len(np.unique(seen)) >= _LEVELS and goes_back_and_forth(seen):
            return name
    return None


def _plateaus(part: Part, found: Sequence[tuple[int, Segment]]) -> None:
    """Make each plateau of `found`, with the row at which its session begins, a capture; rows between are history."""
    number = np.zeros(part.n, dtype=np.int64)
    alone = np.ones(part.n, dtype=bool)
    for i, (offset, s) in enumerate(found):
        rows = slice(offset + s.begin, offset + s.end)
        number[rows] = i
        alone[rows] = s.kind != "plateau"
    part.capture = number
    if between := int(alone.sum()):
        holds = sum(s.kind == "plateau" for _, s in found)
        part.keep &= ~alone
        of = "holds; {} of {} rows between them" if holds > 1 else "hold; {} of {} rows beside it"
        part.remarks.append(
            f"{part.table.path.name}: {holds} {of.format(between, part.n)}, where the input moves, are history and are "
            "not compared"
        )
    part.each_alone(alone)


def _name(part: Part) -> list[tuple[int, Segment]]:
    """Find the segments of each session, and write their names to the rows."""
    unit = part.mapping.actuation[0].unit
    found: list[tuple[int, Segment]] = []
    blocks = session_blocks([part])
    for _, own in blocks:
        u = part.actuation[own]
        if _trembles(u):
            u = np.broadcast_to(u.mean(axis=0), u.shape)
        for s in find_segments(u, part.time_s[own], unit):
            found.append((own.start, s))
            part.segment[own.start + s.begin : own.start + s.end] = s.name
    return found


def _trembles(u: Floats) -> bool:
    """Whether measured inputs (n, C) stand still but for their noise: they move little, and without a course."""
    spread = u.var(axis=0)
    steps = (np.diff(u, axis=0) ** 2).sum(axis=0) / len(u)
    still = np.ptp(u, axis=0) <= _HELD_JITTER * np.abs(u).max(axis=0)
    return bool((still & (steps >= spread)).all())


def _scattered(part: Part) -> bool:
    """Whether most rows are far from the one before: set-points that were measured once each, and no record.

    Rows that follow each other at exactly one command are one hold.
    """
    if _trembles(part.actuation) or is_set(part.actuation):
        return False
    span = np.ptp(part.actuation, axis=0)
    steps = np.abs(np.diff(part.actuation, axis=0)) / np.where(span > 0, span, np.inf)
    return part.n > 1 and bool(np.median(steps.max(axis=1)) > _APART)


def _is_stream(part: Part) -> bool:
    """Whether rows come by an even clock and are many: then someone logged, and did not measure point by point."""
    step = np.diff(part.time_s)
    step = step[step > 0]
    if part.n < _STREAM_ROWS or len(step) < 0.9 * (part.n - 1):
        return False
    middle = float(np.median(step))
    u = part.actuation
    moves = np.ptp(u, axis=0) > _HELD_JITTER * np.abs(u).max(axis=0)
    return bool(np.median(np.abs(step - middle)) <= _EVEN * middle and moves.any())
