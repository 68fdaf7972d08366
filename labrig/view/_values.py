"""The fitted values of an effect in words: names, units, which chamber, how fast."""

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from labrig._text import give_or_take, listed, number, percent, with_unit, word
from labrig.arrays import flat
from labrig.effects import EffectError, Fitted
from labrig.view._naming import added
from labrig.view._weight_names import shown_of

if TYPE_CHECKING:
    import xarray as xr

    from labrig.diagnosis import Result

_WEIGHTS = "No formula follows it well enough; these are the largest weights of its family's functions:"
_MINUTE_S = 60.0
_SHOWN = 6  # parameters of one effect
_NAMED = 3  # chambers, markers ... of one parameter, where it has more than _FEW
_FEW = 4
ROTATION = "about "
_TURN = "rad"
_SEVERAL = re.compile(
    r"\([^()]* or [^()]*\)"
)  # the unit of values that belong to observables of different kinds
NO_UNITS: Mapping[str, str] = MappingProxyType({})
_NUMBERED = re.compile(r"^(marker|since)_\d(_s)?$")  # of a second marker: `marker_2`, `since_2_s`
_MOMENTS = {"since_s": "since", "until_s": "until"}
_CLOCK = ((3600.0, "h"), (_MINUTE_S, "min"), (1.0, "s"))


def fitted(result: "Result") -> list[Fitted]:
    """The effects that were added, with their values."""
    if result.improved is None:
        return []
    new, library = set(added(result.summary)), result.improved.library()
    return [
        Fitted(
            entry.name,
            entry.form or "",
            {key: value.model_dump(exclude_none=True) for key, value in entry.parameters.items()},
            float(result.fields.attrs.get("longest_hold_s") or _MINUTE_S),
            dict(zip(on.chambers, zip(on.low, on.high, strict=True), strict=True))
            if (on := entry.fitted_on)
            else {},
            str(result.fields["commanded"].attrs.get("units", "")) if "commanded" in result.fields else "",
            units_of(result.fields),
            library[entry.name].unit_in_names if entry.name in library else "",
        )
        for entry in result.improved.file.effects
        if entry.name in new
    ]


def plain(result: "Result", one: Fitted) -> str:
    """What the values of one of these come to, in a sentence or two; empty where they speak for themselves."""
    assert result.improved is not None
    try:
        said = result.improved.library()[one.effect].in_words(one)
    except EffectError as error:  # of somebody's own effect: the rest of what was found is shown
        said = f"{error}."
    return " ".join(filter(None, [said, _WEIGHTS if "weights" in one.parameters else ""]))


def units_of(fields: "xr.Dataset") -> dict[str, str]:
    """The unit of each observable of a comparison, by name."""
    if "unit" not in fields.coords:
        return {}
    names, units = fields["observable"].values.tolist(), fields["unit"].values.tolist()
    return {str(name): str(unit) for name, unit in zip(names, units, strict=True)}


def value_lines(result: "Result") -> list[str]:
    """One line for each effect that was added: what its values come to, and the values."""
    out = []
    for one in fitted(result):
        form = f" ({one.form})" if one.form else ""
        said = " ".join(filter(None, [plain(result, one), values_words(shown_of(one), one.units)]))
        out.append(f"{word(one.effect)}{form}: {said}")
    return out


def values_words(parameters: Mapping[str, Any], units: Mapping[str, str] = NO_UNITS) -> str:
    """`amplitude 0.210 ± 0.010, tau 12.0 ± 1.5 s`; of one for each chamber the largest by name.

    `units` are those of the observables: what belongs to one of them is said in its own.
    """
    shown = []
    for numbered, entry in list(parameters.items())[:_SHOWN]:
        name = _NUMBERED.sub(r"\1\2", numbered)
        unit = str(entry.get("unit", ""))
        if name in _MOMENTS:
            shown.append(f"{_MOMENTS[name]} {_moment(flat(entry.get('value'))[0])} after the start")
            continue
        if name == "known":  # of creep: what of it the base has
            (share,) = flat(entry.get("value"))
            shown += [f"{percent(share) if share < 1 else 'all'} of it in the base already"] * (share > 0)
            continue
        shown.append(f"{word(name.removesuffix(f'_{unit}'))} {_values(entry, unit, units)}")
    more = f", {len(parameters) - _SHOWN} more" if len(parameters) > _SHOWN else ""
    return ", ".join(shown) + more


def _moment(time_s: float) -> str:
    """When something was, in the unit that a person would say it in."""
    size, unit = next((size, unit) for size, unit in _CLOCK if time_s >= 2 * size or size == 1.0)
    return with_unit(number(time_s / size), unit)


def own_unit(unit: str, label: str, units: Mapping[str, str]) -> str:
    """The unit of one of several values: of a turn, of a shift, or of an observable, whose `units` these are."""
    if (of := label.rpartition(": ")[2]).startswith(ROTATION):  # day1: about x
        return _TURN
    if of in units:
        unit = _SEVERAL.sub(lambda _: units[of], unit)
    return unit.removesuffix(f", {_TURN}") if label else unit


def _span(values: Sequence[float], units: Sequence[str]) -> str:
    """From the least to the largest of several values, of each unit by itself."""
    own = {
        unit: [v for v, u in zip(values, units, strict=True) if u == unit] for unit in dict.fromkeys(units)
    }
    ends = {unit: list(dict.fromkeys([number(min(v)), number(max(v))])) for unit, v in own.items()}
    return listed([with_unit(" to ".join(each), unit) for unit, each in ends.items()])


def _values(entry: Mapping[str, Any], unit: str, units: Mapping[str, str]) -> str:
    values, sds = flat(entry.get("value")), flat(entry.get("sd"))
    if not values:
        return "–"
    if len(values) == 1 and entry.get("per"):  # a number that stands for a chamber
        return str(entry["per"][0])
    if len(values) == 1:
        return with_unit(give_or_take(values[0], sds[0] if sds else None, 2), unit)
    per = [str(name) for name in entry.get("per") or []]
    if len(per) != len(values):
        rows = len(values) // max(len(units), 1)  # several of each observable
        labels = [*units] * rows if rows * len(units) == len(values) else [""] * len(values)
        return f"{_span(values, [own_unit(unit, name, units) for name in labels])} ({len(values)} values)"
    own = [own_unit(unit, name, units) for name in per]
    order = list(range(len(values)))
    rest: list[int] = []
    if len(values) > _FEW and not any(name.startswith(ROTATION) for name in per):  # a frame's six motions
        most = {u: max(abs(v) for v, n in zip(values, own, strict=True) if n == u) for u in own}
        order.sort(key=lambda i: -abs(values[i]) / (most[own[i]] or 1.0))
        order, rest = order[:_NAMED], order[_NAMED:]
    named = ", ".join(
        f"{per[i]} {with_unit(give_or_take(values[i], sds[i] if len(sds) == len(values) else None, 2), own[i])}"
        for i in order
    )
    if not rest:
        return named
    others = _span([values[i] for i in rest], [own[i] for i in rest])
    return f"{named}, {len(rest)} others {others}"
