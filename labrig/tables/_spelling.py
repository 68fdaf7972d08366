"""The unit that pint knows for what people write beside a name."""

import re
from functools import cache

from labrig._errors import LabrigError
from labrig.tables._units import atmosphere, check, names_of

_SPELT = {
    "sec": "s", "secs": "s", "seconds": "s", "second": "s", "msec": "ms", "millis": "ms", "millisec": "ms",
    "usec": "us", "nsec": "ns", "nanosec": "ns", "minutes": "min", "°": "deg", "degree": "deg", "degrees": "deg",
    "°c": "degC", "grad": "deg", "celsius": "degC", "deg_c": "degC", "c": "degC", "°f": "degF", "degf": "degF",
    "kpa": "kPa", "mpa": "MPa", "pa": "Pa", "hpa": "hPa", "mbar": "mbar", "bar": "bar", "psi": "psi", "torr": "torr",
    "inhg": "inHg", "newton": "N", "newtons": "N", "n": "N", "kn": "kN", "mn": "mN", "grams": "g", "gram": "g",
    "ohm": "ohm", "ohms": "ohm", "kohm": "kohm", "kohms": "kohm", "mohm": "Mohm",
    "volt": "V", "volts": "V", "vdc": "V", "v": "V", "mv": "mV", "amp": "A", "amps": "A", "a": "A", "ma": "mA",
    "nm": "N*m", "mnm": "mN*m", "nmm": "N*mm", "ncm": "N*cm", "degc": "degC", "gauss": "gauss", "ue": "microstrain",
    "%": "percent", "pct": "percent", "-": "1", "a.u.": "1", "hz": "Hz", "k": "K", "mmhg": "mmHg", "meters": "m",
    "metres": "m", "meter": "m", "nl/min": "slpm", "ln/min": "slpm", "nlpm": "slpm", "slpm": "slpm", "slm": "slpm",
    "cmh2o": "cmH2O", "mmh2o": "mmH2O", "inh2o": "inH2O", "lpm": "L/min",
    "millimeter": "mm", "millimeters": "mm", "millimetres": "mm", "centimeters": "cm", "centimetres": "cm",
    "\u03bc\u03b5": "microstrain", "%rh": "percent", "% rh": "percent", "%rf": "percent", "% rf": "percent",
    "% r.h.": "percent", "% r.f.": "percent", "%hr": "percent", "% hr": "percent",
}  # fmt: skip
_LETTER = {"°": "deg", "%": "percent", "C": "degC", "n": "N", "v": "V"}
_SIGNS = str.maketrans(
    {
        "µ": "u",
        "μ": "u",
        "\u03a9": "ohm",
        "\u2126": "ohm",
        "℃": "degC",
        "²": "**2",
        "³": "**3",
        "·": "*",
        "⋅": "*",
    }
)
_KINDS = (
    "meter", "micron", "inch", "foot", "pixel", "gram", "pound", "ounce", "second", "minute", "hour", "day", "hertz",
    "newton", "pascal", "bar", "atmosphere", "torr", "Hg", "H2O", "volt", "ampere", "ohm", "farad", "henry",
    "siemens", "watt", "joule", "tesla", "gauss", "liter", "kelvin", "Celsius", "Fahrenheit", "degree", "radian",
    "turn", "percent", "ppm", "count", "bit", "decibel", "strain",
)  # fmt: skip
"""How pint's names of units end that instruments give; it knows many more, such as the hand and the year (a)."""

_RATIO = re.compile(r"([munk]?m|inch|in|[kM]?Pa|k?N)/\1")
_PRESSURE = r"(?P<unit>[hkm]?pa|m?bar|psi)"
_LETTER_ON = r"(?<!^pa)(?<![^hkm]pa)(?P<letter>[gadü])"
_AGAINST = r"(?:gauge|abs(?:olute?)?|rel(?:ative)?|diff)\b\.?"
_GAUGE = re.compile(
    rf"(?:(?P<before>{_AGAINST})[\s_,]*)?{_PRESSURE}(?:{_LETTER_ON}|[\s_,(-]+(?P<behind>[gad]|{_AGAINST})\)?)?",
    re.I,
)
_SINCE = re.compile(r"(?<=\w)\s+(?:since|after|from)\s.*$", re.I)
"""What a time is counted from: ms since midnight."""
_AT_END = re.compile(
    rf"(?<![^\W\d_]){_PRESSURE}(?:{_LETTER_ON}|\s*\((?P<before>[gad])\)|[\s_](?P<behind>g|{_AGAINST}))$", re.I
)


@cache
def is_unit(text: str) -> bool:
    """Whether a text, as people write it, is a unit."""
    return bool(text.strip()) and unit_of(text) is not None


def ungauged(name: str) -> str:
    """A column's name without what says, behind a unit at its end, against what a pressure is measured: kPa_g."""
    return _AT_END.sub(r"\g<unit>", name)


def is_absolute(text: str) -> bool:
    """Whether a text is a unit of pressure that is said to be absolute, as psia or kPa abs, or ends with one."""
    found = _GAUGE.fullmatch(text.strip()) or _AT_END.search(text.strip())
    return found is not None and any(
        (found[how] or "")[:1] in {"a", "A"} for how in ("before", "letter", "behind")
    )


@cache
def unit_of(text: str) -> str | None:
    """The unit that pint knows for what people write, or None; gauge and absolute pressures are in the same unit."""
    plain = text.strip()
    if re.fullmatch(r"[\[({<].*[\])}>]", plain):
        plain = plain[1:-1].strip()
    plain = _SINCE.sub("", plain.replace("\u00b5", "\u03bc"))
    if pressure := _GAUGE.fullmatch(plain):
        plain = pressure["unit"]
    if len(plain) != 1:
        plain = _SPELT.get(plain.lower(), plain)
    if plain in {"", "1", "-"} or _RATIO.fullmatch(plain):
        return "1" if plain else None
    plain = _as_pint_writes(_LETTER.get(plain, plain))
    if not re.fullmatch(r"(1/)?[A-Za-z°%][A-Za-z°%*/^0-9_ -]*", plain):
        return None
    try:
        check(plain, "unit")
    except LabrigError:
        return None
    return plain if all(name.endswith(_KINDS) for name in names_of(plain)) else None


def check_spelt(unit: str, where: str, *, gauge: float | None = None) -> None:
    """Raise `LabrigError` if there is no such unit, with the way it is written where a person means one.

    So it is for an absolute pressure; where 0 is the air's, what is to be written adds to the offset `gauge`, in it.
    """
    if is_absolute(unit) and (known := unit_of(unit)):
        write = f"write 'unit: {known}'"
        if gauge is not None:
            less = f"offset: {gauge - atmosphere(known):.6g}"
            write = f"write 'unit: {known}, {less}' (less one standard atmosphere; the air's own pressure is better)"
        raise LabrigError(f"{where}: unit {unit!r} is an absolute pressure; {write}")
    try:
        check(unit, where)
    except LabrigError as error:
        if known := unit_of(unit):
            raise LabrigError(f"{where}: there is no unit {unit!r}; write {known}") from error
        raise


def _as_pint_writes(plain: str) -> str:
    """Signs as letters, N.m and Nm as a product, m/s2 as a power, kg/cm2 as the pressure that it is."""
    plain = plain.translate(_SIGNS)
    plain = re.sub(r"(?<=[A-Za-z])\.(?=[A-Za-z])", "*", plain)
    plain = re.sub(r"\b([kmc]?N)([mc]?m)\b", r"\1*\2", plain)
    plain = re.sub(r"(?<=[A-Za-z])(-?[1234])(?![A-Za-z0-9])", r"**\1", plain)
    return re.sub(r"^kg(?=/[cm]m(\*\*|\^)2$)", "kgf", plain)
