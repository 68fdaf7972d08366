"""Where a run goes farther than the one that an effect's weights were fitted to."""

from labrig.effects import Rows
from labrig.model._file import EffectEntry

_FARTHER = 0.1
"""Share of the way that was fitted by which a run may go beyond it unsaid: functions of a family are smooth."""


def beyond(entry: EffectEntry, rows: Rows) -> list[str]:
    """A line where a run (F rows) takes a chamber beyond where an entry's weights are known from; none for a formula,
    which says something everywhere.
    """
    on = entry.fitted_on
    if on is None or on.lowest is None or on.highest is None or not len(rows.actuation):
        return []
    unit = rows.actuation_unit
    out = []
    for chamber, low, high in zip(on.chambers, on.lowest, on.highest, strict=True):
        if chamber not in rows.chambers:
            continue
        own = rows.actuation[:, rows.chambers.index(chamber)]
        slack = _FARTHER * (high - low)
        if own.min() < low - slack or own.max() > high + slack:
            out.append(f"{chamber} {low:.3g} to {high:.3g} {unit} (here {own.min():.3g} to {own.max():.3g})")
    if not out:
        return []
    return [
        f"{entry.name}: its weights are known from {', '.join(out)}; beyond that they say little, so fit it again with "
        "runs that go as far"
    ]
