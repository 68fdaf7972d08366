"""Columns that are places though they do not say so: tx, ty, tz of a tracker, u and v of a camera, points called P."""

import re
from collections.abc import Mapping
from dataclasses import replace

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._held import is_held
from labrig.tables._inputs import find_commands, find_sensors, is_drive, is_pressure
from labrig.tables._names import Name
from labrig.tables._units import is_length, is_screen

_TRIPLES = (("tx", "ty", "tz"), ("px", "py", "pz"), ("mx", "my", "mz"))
_IN_IMAGE = re.compile(r"(.*[^\W_])[\W_]+([uvw])", re.I)
_ELECTRIC = {
    "valve",
    "voltage",
    "current",
    "pwm",
    "duty",
    "drive",
    "motor",
    "phase",
    "pump",
    "solenoid",
    "coil",
}
"""What has a voltage u or v, or phases u, v and w."""


def may_be_place(n: Name) -> bool:
    """Whether a column with an axis may be a place, by what it is called and its unit, if it has one."""
    if n.has(names.COMMANDED | names.AMBIENT | names.NO_POSITION):
        return False
    if n.unit is not None and is_length(n.unit):  # P1.X in mm is a point
        return not n.has(names.PRESSURE - {"p"})
    return not n.has(names.PRESSURE) and (n.unit is None or is_screen(n.unit))


def points_called_p(rest: list[Name], values: Mapping[str, Floats], remarks: list[str]) -> list[str]:
    """The columns P01.X, P01.Y and P01.Z, or two of them, of several points that say no unit. It is said.

    They may be pressures as well: so there are others that were set, and none of these was, and most of these are no
    sensors of those.
    """
    own: dict[str, dict[str, Name]] = {}
    for n in rest:
        bare = replace(n, words=tuple(word for word in n.words if word != "p"))
        if n.axis is not None and n.unit is None and "p" in n.words and bare.words[1:] and may_be_place(bare):
            own.setdefault(n.owner, {}).setdefault(n.axis, n)
    points = {owner: axes for owner, axes in own.items() if len(axes) >= 2}
    found = [n for axes in points.values() for n in axes.values()]
    if len(points) < 2 or len({*map(frozenset, points.values())}) > 1:
        return []
    others = [n for n in rest if n not in found]
    if not any(n.has(names.COMMANDED) or is_pressure(n) or is_drive(n) for n in others):
        return []
    inputs, _ = find_commands(others, values)
    sensors = find_sensors(found, inputs, values) if inputs else []
    if not inputs or 2 * len(sensors) > len(found) or any(is_held(values[n.column]) for n in found):
        return []
    remarks.append(
        f"{found[0].column!r} (and {len(found) - 1} more) look like coordinates of markers: taken for places of "
        f"{len(points)} points, and for no pressures"
    )
    return [n.column for n in found]


def with_triples(rest: list[Name]) -> list[Name]:
    """Columns tx, ty, tz or px, py, pz as x, y, z, where nothing says that they are torques or anything but places."""
    forces = any(n.words[-1:] in {("fx",), ("fy",), ("fz",)} or n.has({"force", "torque"}) for n in rest)
    new: dict[str, Name] = {}
    for triple in _TRIPLES:
        own: dict[str, dict[str, Name]] = {}
        for n in rest:
            if n.words[-1:] and n.words[-1] in triple and may_be_place(n):
                if triple[0] == "mx" and not (n.unit and is_length(n.unit)):
                    continue  # moments, or what a magnetometer sees
                own.setdefault(n.called[:-2].rstrip("_. /:"), {})[n.words[-1]] = n
        if triple[0] == "tx" and forces:
            continue
        for owner, axes in own.items():
            if len(axes) == 3:
                new |= {
                    n.column: replace(n, axis=word[-1], owner=owner or "marker") for word, n in axes.items()
                }
    return [new.get(n.column, n) for n in rest]


def with_images(rest: list[Name], remarks: list[str]) -> list[Name]:
    """Columns m_u and m_v of one owner as its x and y in an image, in pixels: v by itself is volts. It is said."""
    own: dict[str, dict[str, Name]] = {}
    for n in rest:
        found = _IN_IMAGE.fullmatch(n.column.strip())
        if found and not n.has(names.PRESSURE | names.COMMANDED | names.NO_POSITION | _ELECTRIC):
            own.setdefault(found[1], {})[found[2].lower()] = n
    new = {
        n.column: replace(n, axis=axis, owner=owner, unit="px", called=f"{owner}_{axis}")
        for owner, both in own.items()
        if both.keys() == {"u", "v"} and both["u"].unit is None
        for axis, n in (("x", both["u"]), ("y", both["v"]))
    }
    if new:
        first, second = list(new)[:2]
        more = f" (and {len(new) - 2} more)" if len(new) > 2 else ""
        remarks.append(f"columns {first!r} and {second!r}{more} are taken for places in an image, in px")
    return [new.get(n.column, n) for n in rest]
