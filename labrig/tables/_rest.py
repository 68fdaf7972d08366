"""Where markers are at rest, for a guess: the mean position while every input is zero."""

import numpy as np

from labrig.tables._roles import Roles
from labrig.tables._units import factor, is_length
from labrig.tables._unseen import unseen

_ZERO = 0.01
"""Of an input's largest value: what counts as zero."""

_APART = 0.1
"""Columns whose markers lie closer together at rest than this share of the largest motion are displacements."""


def rest_of(roles: Roles, units: dict[str, str], remarks: list[str]) -> dict[str, dict[str, list[float]]]:
    """`markers:` of a mapping, rest positions in mm; empty where they are not known.

    `units` are those of the markers' coordinates, by NAME.axis. That rows at zero are taken for rest, or that there
    are none, is said.
    """
    whole = {
        name: axes
        for name, axes in roles.markers.items()
        if set(axes) == set("xyz") and all(is_length(units[f"{name}.{a}"]) for a in "xyz")
    }
    if len(whole) < 2 or not roles.actuation:
        return {}
    inputs = np.abs(np.stack([roles.values[n.column] for n in roles.actuation], axis=1))
    vented = (inputs <= _ZERO * np.nan_to_num(inputs).max(axis=0)).all(axis=1)
    place = np.stack(
        [
            np.stack(
                [roles.values[axes[a].column] * factor(units[f"{name}.{a}"], "mm", name) for a in "xyz"],
                axis=1,
            )
            for name, axes in whole.items()
        ],
        axis=1,
    )
    seen, _ = unseen(
        place.reshape(len(place), -1),
        [f"{name}.{a}" for name in whole for a in "xyz"],
        np.full(3 * len(whole), -1),  # at rest a marker may well be at 0, 0, 0
    )
    place = seen.reshape(place.shape)
    none = "no row has every input at 0"
    if vented.any():
        none = "in no row with every input at 0 was every marker seen"
    vented &= np.isfinite(place).all(axis=(1, 2))
    if not vented.any():
        remarks.append(
            f"{none}, so where the markers are at rest is not known and no surface is drawn: "
            f"say it, such as markers: {{{next(iter(whole))}: {{rest: [x, y, z]}}}}, in mm"
        )
        return {}
    rest = place[vented].mean(axis=0)
    if np.ptp(rest, axis=0).max() <= _APART * np.nanmax(np.abs(place - rest)):
        return {}
    remarks.append(
        f"where the markers are at rest is their mean over {vented.sum()} rows with every input at 0"
    )
    return {
        name: {"rest": [round(float(x), 3) + 0.0 for x in at]} for name, at in zip(whole, rest, strict=True)
    }
