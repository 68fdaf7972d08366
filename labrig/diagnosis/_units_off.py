"""Whether measurements and model may be in different units, or the rig did not move at all."""

import numpy as np

from labrig.effects import Context

_ALIKE = 0.9
_TIMES = 5.0
"""Correlation, and ratio of motions, from which on a person is asked; they decide no verdict."""


def units_off(context: Context) -> list[str]:
    """A line for each unit whose observables hardly move, or follow the model's prediction many times as far."""
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
        if of_base <= 0 or not seen.any():
            continue
        times = np.sqrt(of_measured / of_base)
        if times <= 1 / _TIMES or (times >= _TIMES and both >= _ALIKE * times * of_base):
            out.append(
                f"what is measured in {unit} changes {times:.2g} times as far as the model says: check the units of "
                "both and of the pressures, and whether these arrive"
            )
    return out
