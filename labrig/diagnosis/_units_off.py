"""Whether measurements and model may be in different units: they go the same way, and far from as far."""

import numpy as np

from labrig.effects import Context

_ALIKE = 0.9
_TIMES = 5.0
"""Correlation, and ratio of motions, from which on a person is asked; they decide no verdict."""


def units_off(context: Context) -> list[str]:
    """A line for each unit whose observables follow the model's prediction, but at quite another scale."""
    rows, out = context.rows, []
    kinds = np.array(rows.unit)
    for unit in dict.fromkeys(rows.unit):
        own = kinds == unit
        seen = np.isfinite(rows.values[:, own])
        count = np.maximum(seen.sum(axis=0), 1)
        measured, base = (
            np.where(seen, v[:, own], 0.0) - np.where(seen, v[:, own], 0.0).sum(axis=0) / count
            for v in (rows.values, context.base)
        )
        both, of_base, of_measured = (
            float((a * b)[seen].sum()) for a, b in ((measured, base), (base, base), (measured, measured))
        )
        if both <= _ALIKE * np.sqrt(of_base * of_measured) or both <= 0:
            continue
        times = both / of_base
        if max(times, 1 / times) >= _TIMES:
            out.append(
                f"what is measured in {unit} changes in the way that the model says, but {times:.2g} times as far: "
                "check the units of both, and of the pressures"
            )
    return out
