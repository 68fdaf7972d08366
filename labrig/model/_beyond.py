"""Where a run goes farther than a base is known, or than the run that an effect's weights were fitted to."""

from collections.abc import Sequence

from labrig.arrays import Floats
from labrig.effects import Rows
from labrig.model._bases import BaseModel, SimulatorModel, SurrogateModel, TableModel
from labrig.model._file import EffectEntry

_FARTHER = 0.1
"""Share of the way that is known by which a run may go beyond it unsaid: functions of a family are smooth."""


def beyond(entry: EffectEntry, rows: Rows) -> list[str]:
    """A line where a run (F rows) takes a chamber beyond where an entry's weights are known from; none for a formula,
    which says something everywhere.
    """
    on = entry.fitted_on
    if on is None or on.lowest is None or on.highest is None:
        return []
    out = _farther(on.chambers, on.lowest, on.highest, rows)
    if not out:
        return []
    return [
        f"{entry.name}: its weights are known from {', '.join(out)}; beyond that they say little, so fit it again with "
        "runs that go as far"
    ]


def beyond_base(base: BaseModel, rows: Rows) -> list[str]:
    """A line where a run (F rows) takes a chamber beyond where its base is known; none for a base that has no range."""
    if not isinstance(base, SimulatorModel | SurrogateModel | TableModel) or base.known is None:
        return []
    out = _farther(rows.chambers, *base.known, rows)
    if not out:
        return []
    return [
        f"base ({base.kind}): it is known from {', '.join(out)}; beyond that it says little, and what it is off by may "
        "be taken for an effect"
    ]


def _farther(
    chambers: Sequence[str], lowest: Sequence[float] | Floats, highest: Sequence[float] | Floats, rows: Rows
) -> list[str]:
    """Of each chamber that goes farther than is known: its name, what is known, and how far it goes."""
    if not len(rows.actuation):
        return []
    unit = rows.actuation_unit
    out = []
    for chamber, low, high in zip(chambers, lowest, highest, strict=True):
        if chamber not in rows.chambers:
            continue
        own = rows.actuation[:, rows.chambers.index(chamber)]
        slack = _FARTHER * (high - low)
        if own.min() < low - slack or own.max() > high + slack:
            out.append(f"{chamber} {low:.3g} to {high:.3g} {unit} (here {own.min():.3g} to {own.max():.3g})")
    return out
