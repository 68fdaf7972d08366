"""Where the chambers are on a surface: the lines within which each alone moves it by half of its most or more."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats
from labrig.view._fields import Skin

HALF = 0.5


@dataclass(frozen=True)
class Outline:
    """One chamber's line on a skin, for any positions of the M markers: `ends` (S, 2, M) makes the ends of its S pieces
    of them, `middle` (M,) the place for its name.
    """

    name: str
    ends: Floats
    middle: Floats


def chamber_outlines(skin: Skin, chambers: Sequence[str], reach: Floats) -> list[Outline]:
    """Lines at half of the farthest that each chamber alone moves the surface; `reach` (M, C) of the markers."""
    out = []
    for name, own in zip(chambers, reach.T, strict=True):
        if not (np.isfinite(own).all() and own.max(initial=0.0) > 0):
            continue
        value = skin.vertices(own / own.max())
        top = int(np.argmax(value))
        out.append(Outline(name, _pieces(skin, value - HALF * value[top]), skin.weight[top]))
    return out


def _pieces(skin: Skin, value: Floats) -> Floats:
    """Where `value` (V,) goes through zero: one piece across each triangle that it does so in, (S, 2, M)."""
    corner = value[skin.triangles]
    ends = []
    for k in range(3):
        a, b = skin.triangles[:, k], skin.triangles[:, (k + 1) % 3]
        va, vb = corner[:, k], corner[:, (k + 1) % 3]
        across = np.not_equal(va > 0, vb > 0)
        share = np.where(across, va / np.where(across, va - vb, 1.0), np.nan)[:, None]
        ends.append(np.where(across[:, None], (1 - share) * skin.weight[a] + share * skin.weight[b], np.nan))
    sides: Floats = np.stack(ends, axis=1)
    cut = np.isfinite(sides[:, :, 0])
    crossed = cut.sum(axis=1) == 2
    return sides[crossed][cut[crossed]].reshape(-1, 2, skin.weight.shape[1])
