"""Which columns of a foreign table are commands, and which are the sensors of those, by names and by numbers."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._held import is_exact, is_held, is_noisy, last_digit, seen_of
from labrig.tables._names import Name
from labrig.tables._units import like

_NEAR = 0.04
"""Of a command's range: how far a sensor is from it at the ends of holds, after scale and offset."""
_SUPPLY = 0.1
"""Share of its size by which a supply's voltage or current may move."""
_TIMES = 2.0
"""How many times as large numbers without a unit may be as those that they are compared with."""
_ALIKE = 0.8
"""How much of a command its sensor shows, at least, where both are in one unit."""
_ENDS = 5
_IN_ORDER = 0.8
"""Rank correlation of a drive and a pressure at the ends of at least so many holds, from which on it drives it."""
_AS_SET = {"s", "d", "c"} | names.INPUT
"""What says that it was set, desired, commanded, or put in, beside a name that is the same without it."""
A_FEW = 4
"""Steps from which on a column counts."""
_MANY = 60
"""In tables with more columns, commands are not looked for by comparing all of them."""


def is_pressure(n: Name) -> bool:
    """Whether a column is a pressure by its name or its unit."""
    return n.has(names.PRESSURE) or (n.unit is not None and like(n.unit, "Pa") and not n.has(names.OUTPUT))


def answers_to(n: Name, volume: Name) -> bool:
    """Whether a column is the pressure of a volume that was commanded, as by a syringe: an answer, no sensor of it."""
    return is_pressure(n) and is_volume(volume)


def is_volume(n: Name) -> bool:
    """Whether a column is a volume by its unit, as of a syringe."""
    return n.unit is not None and like(n.unit, "ml")


def is_drive(n: Name) -> bool:
    """Whether a column is what drives a valve, by its name or its unit."""
    return n.has(names.INPUT) or n.unit == "percent" or (n.unit is not None and is_electric(n.unit))


def is_electric(unit: str) -> bool:
    """Whether a unit is that of a voltage or a current."""
    return like(unit, "V") or like(unit, "A")


def find_commands(rest: list[Name], values: Mapping[str, Floats]) -> tuple[list[Name], list[str]]:
    """The columns that were commanded, of columns with these `values` (n,); and remarks that say what was assumed.

    Called so; else followed by a sensor; else pressures, those first that stand still in holds; else voltages and the
    like, which come first where they stand still and a pressure follows, or trembles. Columns that are called the same
    but for a number or a letter come along.
    """
    if commanded := [n for n in rest if n.has(names.COMMANDED) and not _is_counted(n, values[n.column])]:
        return with_siblings(commanded, rest, values), []
    duty = [
        n for n in rest if n.has(names.DUTY) and not n.has(names.MEASURED) and is_driven(values[n.column])
    ]
    if led := _led([n for n in rest if not (duty and is_drive(n) and n not in duty)], values):
        said = [
            f"column {b.column!r} follows {a.column!r}: taken for its sensor, and {a.column!r} for what was commanded"
            for a, b in led
        ]
        commands, sensors = [a for a, _ in led], [b for _, b in led]
        rest = [n for n in rest if n not in sensors]
        if not all(_stem(a) for a in commands):
            commands += [n for n in find_held(rest, values) if not _stem(n) and n not in commands]
        return with_siblings(commands, rest, values), said
    pressures = [n for n in rest if is_pressure(n)]
    drives = _drives(rest)
    steps = [n for n in find_held(drives, values) if is_driven(values[n.column])]
    said = []
    if pressures and steps and not find_held(pressures, values):
        driven = any(is_noisy(values[n.column]) or _follows(n, steps, values) for n in pressures)
        said = [_beside_a_drive(pressures[0], steps[0], driven)]
        pressures = [] if driven else pressures
    elif pressures and all(is_noisy(values[n.column]) for n in pressures):
        # what trembles was measured: what drives it does not, or stands still in holds
        quiet = [n for n in drives if is_driven(values[n.column]) and not is_noisy(values[n.column])]
        able = [
            n for n in rest if n in find_held(rest, values) or (is_volume(n) and is_exact(values[n.column]))
        ]
        pumps = [n for n in able if any(_follows(p, [n], values) for p in pressures)]
        pumps = [n for n in pumps if is_volume(n)] or pumps
        if seeds := quiet or pumps:
            return with_siblings(quiet or pumps[:1], rest, values), [_trembles(pressures[0], seeds[0])]
    elif not pressures and drives and all(is_noisy(values[n.column]) for n in drives):
        seeds = [n for n in find_held(rest, values) if _is_set_often(n, values[n.column])]
        if seeds:
            return with_siblings(seeds, rest, values), [_trembles(drives[0], seeds[0])]
    named = [n for n in drives if n.unit != "percent" or n.has(names.INPUT)]
    seeds = [n for n in pressures if not n.has(names.MEASURED)] or pressures or steps or named
    if still := [n for n in seeds if is_held(values[n.column])]:
        seeds = [n for n in seeds if n in still or not is_noisy(values[n.column])]
    if seeds and all(n.has(names.MEASURED) for n in seeds):
        said = [f"no column is called commanded: {seeds[0].column!r}, which was measured, is taken for it"]
    return with_siblings(seeds, rest, values), said


def _is_counted(n: Name, values: Floats) -> bool:
    """Whether what is called the number of something that is set, as set_no, counts: 1, 1, 2, 2, 3 and on."""
    return n.unit is None and n.has(names.COUNTER) and counts_up(values)


def counts_up(values: Floats) -> bool:
    """Whether numbers (n,) go up by one, a few times at least, and never else."""
    step = np.diff(values)
    return bool(np.isin(step, (0, 1)).all() and step.sum() >= A_FEW)


def _drives(rest: list[Name]) -> list[Name]:
    """The columns that may drive something: duty cycles, which a program sets, before currents and voltages, which may
    have been measured; and no strain in percent.
    """
    able = [n for n in rest if is_drive(n) and not is_pressure(n)]
    able = [n for n in able if n.has(names.INPUT) or not (n.unit == "percent" and n.has(names.OUTPUT))]
    able = [n for n in able if not n.has(names.MEASURED)] or able
    return [n for n in able if n.has(names.DUTY)] or able


def _is_set_often(n: Name, values: Floats) -> bool:
    """Whether a column that stands still in holds goes up and down between many places, as no label and no day does."""
    step = np.diff(seen_of(values))
    often = min((step > 0).sum(), (step < 0).sum()) > 1 and len(np.unique(seen_of(values))) >= _ENDS
    return bool(often) and not n.has(names.MEASURED | names.OUTPUT)


def _trembles(seen: Name, held: Name) -> str:
    return (
        f"{seen.column!r} trembles and {held.column!r} does not: the second is taken for what was commanded"
    )


def is_driven(values: Floats) -> bool:
    """Whether numbers (n,) move by more than a supply does, as a share of their size."""
    seen = seen_of(values)
    return bool(np.ptp(seen) > _SUPPLY * np.abs(seen).max())


def _follows(pressure: Name, steps: list[Name], values: Mapping[str, Floats]) -> bool:
    """Whether a pressure is in the order of a drive at the ends of its holds."""
    from scipy.stats import rankdata

    for drive in steps:
        u, p = values[drive.column], values[pressure.column]
        ends = np.isfinite(u) & np.isfinite(p) & np.r_[np.diff(u) != 0, True]
        moves = ends.sum() >= _ENDS and np.ptp(u[ends]) and np.ptp(p[ends])
        if moves and np.corrcoef(rankdata(u[ends]), rankdata(p[ends]))[0, 1] > _IN_ORDER:
            return True
    return False


def _beside_a_drive(pressure: Name, drive: Name, driven: bool) -> str:
    """What is said where a pressure goes on moving while a drive stands still in holds."""
    if driven:
        return (
            f"{drive.column!r} stands still in holds and {pressure.column!r} moves on: the first is taken for what was "
            "commanded"
        )
    return (
        f"{pressure.column!r} is taken for what was commanded, though {drive.column!r} stands still in holds: put that "
        "under 'actuation:' if the pressure was measured"
    )


def without_twice(rest: list[Name], values: Mapping[str, Floats], remarks: list[str]) -> list[Name]:
    """Columns without those that are another one in another unit, as a duty cycle and its percents; that is said."""
    kept: list[Name] = []
    for n in rest:
        alike = (u for u in kept if u.words == n.words and u.unit != n.unit)
        same = next((u for u in alike if _is_twice(u, n, values)), None)
        if same is None:
            kept.append(n)
        else:
            remarks.append(f"column {n.column!r} is {same.column!r} in another unit and is left out")
    return kept


def _is_twice(one: Name, other: Name, values: Mapping[str, Floats]) -> bool:
    u, v = values[one.column], values[other.column]
    rows = np.isfinite(u) & np.isfinite(v)
    u, v = u[rows], v[rows]
    if len(u) < 4 or not np.ptp(u) or not np.ptp(v):
        return False
    factor = float(u @ v) / float(u @ u)
    return bool(np.abs(v - factor * u).max() <= 0.005 * np.ptp(v))


def find_held(rest: list[Name], values: Mapping[str, Floats]) -> list[Name]:
    """The columns that stand still in holds and jump between them."""
    return [n for n in rest if is_held(values[n.column]) and np.ptp(seen_of(values[n.column])) > 0]


def with_siblings(seeds: list[Name], rest: list[Name], values: Mapping[str, Floats]) -> list[Name]:
    """Columns, and those of `rest` that differ from one of them by a number or a letter only, in the order of `rest`.

    A sibling has the same unit, and is noisy only where the column itself is.
    """
    kinds = {(_stem(n), n.unit, is_noisy(values[n.column])) for n in seeds if _stem(n)}
    return [n for n in rest if n in seeds or (_stem(n), n.unit, is_noisy(values[n.column])) in kinds]


def find_sensors(
    left: list[Name], inputs: list[Name], values: Mapping[str, Floats]
) -> list[tuple[Name, Name]]:
    """Which columns of `left` read which of the `inputs`: pairs of both, by name, else by their numbers."""
    found = [
        (n, own)
        for n in left
        if (is_pressure(n) or n.has(names.MEASURED)) and (own := _same(n, inputs, left))
    ]
    taken = {n.column for pair in found for n in pair}
    near = [
        (_apart(u, n, values), u, n)
        for u in inputs
        for n in left
        if not taken & {u.column, n.column}
        and (is_pressure(n) or n.has(names.MEASURED) or may_be_compared(n, u, values))
    ]
    return [*found, *((n, u) for u, n in _paired(near))]


def find_more_sensors(
    left: list[Name], sensors: list[tuple[Name, Name]], values: Mapping[str, Floats]
) -> list[tuple[Name, Name]]:
    """Further sensors of the same inputs, where one chamber has several: they are called like the one that was found,
    but for a number, by the input's number or a pressure, and are as near to the input.
    """
    found = {n.column for n, _ in sensors}
    return [
        (n, u)
        for own, u in sensors
        for n in with_siblings([own], left, values)
        if n.column not in found and _may_be_of(n, u) and _apart(u, n, values) <= _NEAR
    ]


def _may_be_of(sensor: Name, command: Name) -> bool:
    """Whether a column reads a command, by its name alone."""
    own = set(_number(command))
    numbered = bool(own) and own <= set(_number(sensor))
    return not sensor.has(names.OUTPUT) and (is_pressure(sensor) or sensor.has(names.MEASURED) or numbered)


def _paired(found: list[tuple[float, Name, Name]]) -> list[tuple[Name, Name]]:
    """Each command with one sensor that is near, of commands and sensors so far apart: those of one number first, then
    the nearest.
    """
    pairs: list[tuple[Name, Name]] = []
    near = [f for f in found if f[0] <= _NEAR]
    for _, a, b in sorted(near, key=lambda f: (set(_number(f[1])) != set(_number(f[2])), f[0])):
        if not any(a is c or b is d for c, d in pairs):
            pairs.append((a, b))
    return pairs


def may_be_compared(sensor: Name, command: Name, values: Mapping[str, Floats]) -> bool:
    """Whether a sensor's numbers can be in the unit of its command: a pressure is not in the volts of a valve."""
    said = {sensor.unit, command.unit}
    if len(said - {None, "1"}) == 2:
        return like(str(sensor.unit), str(command.unit))
    if len(said) == 1 and None not in said:
        return True
    u, y = (np.abs(values[n.column][np.isfinite(values[n.column])]) for n in (command, sensor))
    high = [float(np.percentile(v, 95)) if len(v) else 0.0 for v in (u, y)]
    return min(high) >= max(high) / _TIMES


def unit_by_sensors(
    command: Name, sensors: Sequence[tuple[Name, Name]], values: Mapping[str, Floats]
) -> tuple[str, Name] | None:
    """The unit of a command that says none: that of its own sensor, with which it is, where their sizes agree."""
    if command.unit is not None or command.written:
        return None
    for sensor, own in sensors:
        if own.column != command.column or sensor.unit in {None, "1"}:
            continue
        u, y = values[command.column], values[sensor.column]
        rows = np.isfinite(u) & np.isfinite(y)
        slope = np.polyfit(u[rows], y[rows], 1)[0] if rows.sum() > 1 and np.ptp(u[rows]) else 0.0
        if _ALIKE <= slope <= 1 / _ALIKE:
            return str(sensor.unit), sensor
    return None


def _same(measured: Name, inputs: list[Name], left: list[Name]) -> Name | None:
    """The input that a sensor reads: what is left of both names without their roles, or their numbers, are alike."""
    roles = names.COMMANDED | names.MEASURED
    key = [w for w in measured.words if w not in roles]
    alike = [n for n in inputs if [w for w in n.words if w not in roles] == key]
    if alike:
        return alike[0]
    pressures = [n for n in left if n.has(names.PRESSURE)]
    if not measured.has(names.PRESSURE):
        return None
    if len(inputs) == 1 and len(pressures) == 1:
        return inputs[0]
    numbered = [n for n in inputs if _number(n) == _number(measured) != ()]
    alone = [n for n in pressures if _number(n) == _number(measured)] == [measured]
    return numbered[0] if alone and len(numbered) == 1 else None


def _number(n: Name) -> tuple[str, ...]:
    return tuple(w for w in n.words if w.isdigit())


def _stem(n: Name) -> tuple[str, ...]:
    """The words of a name without its numbers and letters; empty where a program gave the name, as in column.3."""
    words = tuple(w for w in n.words if not w.isdigit())
    words = tuple(w for w in words if len(w) > 1 or w not in "abcdef") or words
    return () if words in {("column",), ("arr",), ("ans",), ("ch",), ("channel",)} else words


def _led(rest: list[Name], values: Mapping[str, Floats]) -> list[tuple[Name, Name]]:
    """Pairs of a command and the sensor that follows it: nearly the same numbers, one of them noisy, one not; or both
    scattered, as where each row is a capture, and called alike. Columns that differ by a number only have one role, as
    trials of one measurement do.
    """
    quiet = [n for n in rest if not n.has(names.MEASURED | names.OUTPUT) and not is_noisy(values[n.column])]
    noisy = [n for n in rest if is_noisy(values[n.column])]
    if len(rest) > _MANY:
        return []
    found = [
        (_apart(a, b, values), a, b)
        for a in quiet
        for b in noisy
        if not _stem(a) or (_stem(a), a.unit) != (_stem(b), b.unit)
    ]
    found += [(_apart(a, b, values), a, b) for a in noisy for b in noisy if _is_read_by(a, b, values)]
    return sorted(_paired(found), key=lambda pair: rest.index(pair[0]))


def _is_read_by(a: Name, b: Name, values: Mapping[str, Floats]) -> bool:
    """Whether of two columns that are called alike, as p1 and p1m or u2 and p2, the second is the first's sensor.

    The sensor has more decimals. Where both have as many, its name is longer by a word (p1m, p1_real), or the other's
    is by what says that it was set (p1d).
    """
    if a is b or _number(a) != _number(b) or a.has(names.MEASURED | names.OUTPUT):
        return False
    more, less = (set((Counter(n.words) - Counter(m.words)).elements()) for n, m in ((b, a), (a, b)))
    alike = len(more) <= 1 and len(less) <= 1 and (is_pressure(b) or len(b.words) > len(more))
    if not alike or not more | less:
        return False
    coarse, fine = (last_digit(seen_of(values[n.column])) for n in (a, b))
    if coarse != fine:
        return coarse > fine
    return less <= _AS_SET and bool(less or not more <= _AS_SET)


def _apart(command: Name, sensor: Name, values: Mapping[str, Floats]) -> float:
    """How far a sensor is from a command at the ends of holds, as a share of its range; inf for another kind."""
    free = _scale_is_free(command, sensor)
    if free is None:
        return np.inf
    u, y = values[command.column], values[sensor.column]
    rows = np.isfinite(u) & np.isfinite(y)
    ends = rows & np.r_[np.diff(u) != 0, True]
    if is_held(u) and ends.sum() >= 4:
        rows = ends
    u, y = u[rows], y[rows]
    if len(u) < 4 or np.ptp(u) == 0 or np.ptp(y) == 0:
        return np.inf
    slope, offset = np.polyfit(u, y, 1)
    if slope <= 0 or not (free or _ALIKE <= slope <= 1 / _ALIKE):
        return np.inf
    return float(np.median(np.abs(y - offset - slope * u)) / (slope * np.ptp(u)))


def _scale_is_free(command: Name, sensor: Name) -> bool | None:
    """Whether the numbers of a command and its sensor may differ by a factor; None if they are of two kinds."""
    if sensor.has(names.OUTPUT - {"y", "out", "output"}) and not command.has(names.OUTPUT):
        return None
    if command.unit == sensor.unit:
        return False
    if is_pressure(sensor) and (is_drive(command) or is_pressure(command)):
        return command.unit is not None and sensor.unit is not None
    one = command.unit is None or sensor.unit is None
    return False if one and (sensor.has(names.MEASURED) or is_pressure(command)) else None
