"""The fitted values of an effect in words: names, units, which chamber, how fast."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from labrig.view._naming import added
from labrig.view._text import give_or_take, listed, number, percent, with_unit, word

if TYPE_CHECKING:
    import xarray as xr

    from labrig.diagnosis import Result

_BY_PRESSURE = {"pressure", "per chamber", "one chamber"}
"""Forms of contact whose limit is a share of a chamber's range."""
_SHOWN = 6  # parameters of one effect
_NAMED = 3  # chambers, markers ... of one parameter, where it has more than _FEW
_FEW = 4
ROTATION = "about "
_TURN = "rad"
_SEVERAL = re.compile(
    r"\([^()]* or [^()]*\)"
)  # the unit of values that belong to observables of different kinds
NO_UNITS: Mapping[str, str] = MappingProxyType({})
_CLEAR = 2.0  # standard deviations from nothing
_MINUTE_S = 60.0
_NUMBERED = re.compile(r"^(marker|since)_\d(_s)?$")  # of a second marker: `marker_2`, `since_2_s`
_MOMENTS = {"since_s": "since", "until_s": "until"}
_CLOCK = ((3600.0, "h"), (_MINUTE_S, "min"), (1.0, "s"))
_LOST = 0.005  # of the full pressure: less is not spoken of


@dataclass(frozen=True)
class Fitted:
    """An effect as the improved model has it: its form, and its parameters (value, sd, unit, per).

    `longest_s` is how long the longest hold was that it was fitted to: nothing is said of longer ones. `ranges` of the
    chambers are those that fractions are of, in `unit`. `units` are those of the observables.
    """

    effect: str
    form: str
    parameters: dict[str, Any]
    longest_s: float
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    unit: str = ""
    units: dict[str, str] = field(default_factory=dict)

    @property
    def plain(self) -> str:
        """What the values come to, in a sentence; empty where they speak for themselves."""
        if self.effect == "contact" and self.form in _BY_PRESSURE and self.ranges:
            return _limit_words(self.parameters, self.ranges, self.unit)
        return plain_words(self.effect, self.parameters, self.longest_s)


def fitted(result: "Result") -> list[Fitted]:
    """The effects that were added, with their values."""
    if result.improved is None:
        return []
    new = set(added(result.summary))
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
        )
        for entry in result.improved.file.effects
        if entry.name in new
    ]


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
        said = " ".join(filter(None, [one.plain, values_words(one.parameters, one.units)]))
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


def plain_words(effect: str, parameters: Mapping[str, Any], longest_s: float = _MINUTE_S) -> str:
    """What the values come to, in a sentence, over holds of `longest_s`; empty where they speak for themselves."""
    if "weights" in parameters:
        lost = _lost_words(parameters["weights"], min(longest_s, _MINUTE_S)) if effect == "leak" else ""
        follows = (
            "No formula follows it well enough; these are the largest weights of its family's functions:"
        )
        return f"{lost} {follows}".strip()
    return leak_words(parameters) if effect == "leak" else ""


def _limit_words(parameters: Mapping[str, Any], ranges: Mapping[str, tuple[float, float]], unit: str) -> str:
    """From which pressure on something is met, of each chamber that is stopped."""
    (limit,) = flat(parameters["limit"].get("value"))
    # from the limit that is nearer to a vented chamber, as `labrig.effects.ends` has it
    ordered = {n: (high, low) if abs(high) < abs(low) else (low, high) for n, (low, high) in ranges.items()}
    at = {name: begin + limit * (end - begin) for name, (begin, end) in ordered.items()}
    if only := flat(parameters.get("chamber", {}).get("value")):
        name = list(at)[int(only[0])]
        return f"{name} is stopped from {with_unit(number(at[name]), unit)} on."
    alike = len({number(value) for value in at.values()}) == 1
    each = [
        f"{with_unit(number(value), unit)}" + ("" if alike else f" ({name})") for name, value in at.items()
    ]
    return f"Something is met from {each[0] if alike else listed(each)} on."


def _lost_words(weights: Mapping[str, Any], hold_s: float) -> str:
    """Which chambers lose most of their full pressure in a hold, by the weights of a leak's family."""
    loss: dict[str, float] = {}
    for label, value in zip(weights.get("per") or [], flat(weights.get("value")), strict=False):
        name, _, chamber = str(label).partition(" of ")
        kind, tau, *_ = (*name.split(), "")
        if kind == "lost":
            loss[chamber] = loss.get(chamber, 0.0) - value * math.expm1(-hold_s / float(tau))
    if not loss:  # its functions are those of the surface
        return "The surface sinks as a whole: no chamber stands out."
    common = loss.pop("", 0.0)
    each = {chamber: common + own for chamber, own in loss.items()} or {"Every chamber": common}
    most = sorted(each, key=lambda chamber: -each[chamber])[:_NAMED]
    said = [f"{name} loses {percent(each[name])}" for name in most if each[name] > _LOST]
    if not said:
        return "No single chamber leaks clearly."
    how_long = "a minute" if hold_s == _MINUTE_S else f"{hold_s:.2g} s"
    return f"{listed(said)} of its full pressure in {how_long}."


def leak_words(parameters: Mapping[str, Any]) -> str:
    """Which chamber loses how much of its pressure, and how fast; empty where the values do not say."""
    if "sensor" in parameters and "loss" not in parameters:
        share = flat(parameters["sensor"].get("value"))
        reaches = f": {percent(share[0])} of it reaches the surface" if share and share[0] <= 1.0 else ""
        return f"Pressure is lost as the sensors measured it{reaches}."
    loss, tau = (parameters.get(key, {}) for key in ("loss", "tau_s"))
    losses, sds, taus = flat(loss.get("value")), flat(loss.get("sd")), flat(tau.get("value"))
    if not taus:
        return ""
    only = parameters.get("chamber", {}).get("per")
    chambers = [str(name) for name in only or loss.get("per") or tau.get("per") or []]
    count = max(len(losses), len(taus))
    if len(chambers) != count:
        chambers = ["Every chamber"] if count == 1 else [f"chamber {i + 1}" for i in range(count)]
    losses = losses if len(losses) == count else (losses or [1.0]) * count
    taus = taus if len(taus) == count else taus[:1] * count
    clear = [i for i in range(count) if len(sds) != count or losses[i] > _CLEAR * sds[i]]
    clear.sort(key=lambda i: -losses[i] / taus[i])
    if not clear:
        return "No single chamber leaks clearly."
    said = [
        f"{chambers[i]} loses {_rate(losses[i] / taus[i])} of its pressure at first "
        f"(time constant {with_unit(number(taus[i]), 's')})"
        for i in clear
    ]
    tight = count - len(clear)
    others = "the other holds its own" if tight == 1 else f"the other {tight} hold theirs"
    rest = f"; {others}, as far as these data tell" if tight else ""
    return f"{'; '.join(said)}{rest}."


def _rate(per_s: float) -> str:
    for seconds, unit in ((1, "second"), (60, "minute"), (3600, "hour")):
        if per_s * seconds >= 0.001 or unit == "hour":
            return f"{100 * per_s * seconds:.2g} % a {unit}"
    raise AssertionError


def flat(values: Any) -> list[float]:
    if isinstance(values, list | tuple):
        return [number for value in values for number in flat(value)]
    return [] if values is None else [float(values)]
