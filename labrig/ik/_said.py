"""What a solved target leaves open, in words: pressures that it says nothing of, a unit that is off, a hollow."""

from collections.abc import Sequence

import numpy as np

from labrig._text import listed
from labrig.arrays import Floats

_HALF = 0.5
_NORMAL_95 = 1.96
_SAME_SIZE = 1.5
"""Two surfaces whose sizes differ by less than this factor are taken for about equally large."""
INSIDE_OUT = (
    "the target lies on the surface inside out: its triangles face inwards, which is allowed for, or it is a hollow "
    "where the surface bulges, which the surface cannot be; turn its triangles to know"
)


def not_fixed(names: Sequence[str], sd_kpa: Floats, low_kpa: Floats, high_kpa: Floats) -> tuple[str, ...]:
    """The pressures (C,) whose 95 % span half of their range or more: the target hardly says anything of them."""
    span = 2.0 * _NORMAL_95 * np.nan_to_num(sd_kpa, nan=np.inf)
    free = high_kpa > low_kpa
    found = [
        name for name, wide in zip(names, free & (span >= _HALF * (high_kpa - low_kpa)), strict=True) if wide
    ]
    if not found:
        return ()
    one = len(found) == 1
    return (
        f"the target does not fix the pressure{'' if one else 's'} of {listed(found)}: other values fit it as well, "
        f"and what is given for {'it' if one else 'them'} is a guess",
    )


def sizes_apart(target_mm: float, surface_mm: float) -> tuple[str, ...]:
    """Whether a target's size is as if its unit had been mistaken: as many times off as two units are."""
    from labrig_drivers._artec_files import MM_PER_UNIT

    ratio = target_mm / max(surface_mm, 1e-12)
    sizes = f"the target is {_mm(target_mm)} across, the surface {_mm(surface_mm)}"
    for unit, mm in MM_PER_UNIT.items():
        if mm == 1.0:
            continue
        if 1.0 / _SAME_SIZE < ratio * mm < _SAME_SIZE:
            return (f"{sizes}; read as {unit} (--unit {unit}) it would be about as large",)
        if 1.0 / _SAME_SIZE < ratio / mm < _SAME_SIZE:
            return (f"{sizes}: was something in mm read as {unit}?",)
    return ()


def _mm(size: float) -> str:
    return f"{size:.3g} mm" if size < 1000.0 else f"{size:.0f} mm"
