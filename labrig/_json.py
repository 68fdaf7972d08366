"""JSON that is whole or not there, of values that JSON knows."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from labrig._durable import write_whole

_DIGITS = 6
EXACT = 17
"""Digits that give back every number as it was, such as a moment of today in seconds."""


def write_json(content: Any, path: Path, digits: int = _DIGITS) -> None:
    """Write what `plain` gives as JSON, in one piece or not at all."""
    write_whole(path, json.dumps(plain(content, digits), indent=1, allow_nan=False) + "\n")


def plain(value: Any, digits: int = _DIGITS) -> Any:
    """The same content in what JSON knows: numbers with so many significant digits, NaN and infinities as None."""
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, dict):
        return {str(k): plain(v, digits) for k, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(v, digits) for v in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(f"{value:.{digits}g}") if np.isfinite(value) else None
    return value
