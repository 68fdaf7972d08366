"""What may be the seed of all that is random."""

from numbers import Integral
from typing import Any

from labrig._errors import LabrigError


def whole_seed(seed: Any) -> int:
    """A seed as a plain number; raises `LabrigError` for what is none."""
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise LabrigError(f"seed {seed!r}: a whole number, 0 or more")
    return int(seed)
