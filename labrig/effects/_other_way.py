"""Whether a residual is an effect the other way round, which it cannot be: a delay that is ahead, a leak that fills."""

from collections.abc import Iterable

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._rows import capture_means


def is_turned_round(
    context: Context, changes: Iterable[tuple[Floats, bool]], *, within_holds: bool = False
) -> bool:
    """Whether of all these changes of the pressures (F, C) the one that has most of the residual, more than the rest,
    has it the other way round; each with whether it is as the effect makes it, or already the other way.

    `within_holds`: of what changes within each capture alone, as a base that was fitted takes up the rest.
    """
    seen = np.isfinite(context.residual)

    def seen_of(values: Floats) -> Floats:
        values = np.where(seen, values, np.nan)
        return np.nan_to_num(_within(context, values) if within_holds else values)

    left = seen_of(context.residual)
    size = np.sqrt((left**2).mean(axis=0))
    own = size > 0  # sensors of all units count alike, and one without any error not at all
    left, size, explained, other = left[:, own] / size[own], size[own], 0.0, False
    for change, as_made in changes:
        moved = seen_of(np.einsum("fkc,fc->fk", context.jacobian, change))[:, own] / size
        along, square = float((left * moved).sum()), float((moved**2).sum())
        if square > 0 and along**2 / square > explained:
            explained, other = along**2 / square, (along > 0) != as_made
    return other and explained > float((left**2).sum()) - explained


def _within(context: Context, values: Floats) -> Floats:
    means, captures = capture_means(values, context.rows.capture)
    return values - means[np.searchsorted(captures, context.rows.capture)]
