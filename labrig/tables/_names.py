"""What the name of a column says of it: a unit, an axis, and what it is likely to be."""

import re
from dataclasses import dataclass
from functools import cache

from labrig._errors import LabrigError
from labrig.tables._units import check

_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[({<](?P<unit>[^\])}>]*)[\])}>]\s*$")
_SPLIT = re.compile(r"[^A-Za-z0-9µμ°%]+|(?<=[a-z])(?=[A-Z])|(?<=[A-Za-z])(?=\d)|(?<=\d)(?=[A-Za-z])")
_SPELT = {
    "sec": "s", "secs": "s", "seconds": "s", "second": "s", "msec": "ms", "millis": "ms", "usec": "us",
    "nsec": "ns", "nanosec": "ns", "minutes": "min", "µs": "us", "μs": "us", "µm": "um", "μm": "um",
    "°": "deg", "degree": "deg", "degrees": "deg", "°c": "degC", "celsius": "degC", "deg_c": "degC", "c": "degC",
    "kpa": "kPa", "mpa": "MPa", "pa": "Pa", "hpa": "hPa", "mbar": "mbar", "bar": "bar", "psi": "psi", "psig": "psi",
    "barg": "bar", "newton": "N", "newtons": "N", "n": "N", "kn": "kN", "mn": "mN", "grams": "g", "gram": "g",
    "volt": "V", "volts": "V", "v": "V", "mv": "mV", "amp": "A", "amps": "A", "a": "A", "ma": "mA", "nm": "N*m",
    "degc": "degC",
    "%": "percent", "-": "1", "hz": "Hz", "k": "K", "mmhg": "mmHg", "meters": "m", "metres": "m", "meter": "m",
}  # fmt: skip
_AS_SUFFIX = {
    "s", "ms", "us", "ns", "min", "sec", "secs", "seconds", "msec", "usec", "nsec", "nanosec", "kpa", "mpa", "pa",
    "bar", "mbar", "psi", "mm", "cm", "m", "um", "n", "kn", "mn", "deg", "rad", "degc", "v", "mv", "ma", "kg", "g",
    "px", "pixel", "pixels", "hpa", "volts", "newton",
}  # fmt: skip
TIME = {"t", "time", "timestamp", "stamp", "clock", "elapsed", "zeit", "tempo", "temps", "datetime", "date"}
PRESSURE = {"p", "pressure", "press", "pres", "druck", "pressures"}
INPUT = {"u", "input", "in", "voltage", "current", "pwm", "duty", "drive", "actuation", "valve", "q"}
COMMANDED = {
    "set",
    "setpoint",
    "cmd",
    "command",
    "commanded",
    "ref",
    "reference",
    "desired",
    "des",
    "target",
    "soll",
}
MEASURED = {
    "meas",
    "measured",
    "measurement",
    "act",
    "actual",
    "sensor",
    "read",
    "reading",
    "fb",
    "feedback",
    "ist",
}
COUNTER = {"index", "row", "frame", "id", "no", "nr", "num", "number", "count", "counter", "unnamed"}
CAPTURE = {"capture", "hold", "step", "trial", "segment", "pose", "sample", "phase", "stage"}
SESSION = {"session", "day", "run", "experiment", "exp", "test", "specimen"}
REPEAT = {"repeat", "repetition", "rep"}
AMBIENT = {"temp", "temperature", "room", "ambient", "humidity", "payload", "load", "tilt"}
OUTPUT = {
    "y", "out", "output", "force", "displacement", "disp", "position", "pos", "angle", "stroke", "length", "strain",
    "stress", "torque", "deflection", "extension", "bend", "bending", "level", "theta",
}  # fmt: skip


@dataclass(frozen=True)
class Name:
    """A column's name taken apart: its words in lower case, its unit and axis where it says them."""

    column: str
    words: tuple[str, ...]
    unit: str | None
    axis: str | None
    owner: str
    called: str = ""

    def has(self, kind: set[str]) -> bool:
        """Whether one of its words is of a kind."""
        return any(word in kind for word in self.words)


@cache
def is_unit(text: str) -> bool:
    """Whether a text, as people write it, is a unit."""
    return bool(text.strip()) and unit_of(text) is not None


@cache
def unit_of(text: str) -> str | None:
    """The unit that pint knows for what people write, or None."""
    plain = text.strip().strip("[](){}").strip()
    plain = _SPELT.get(plain.lower(), plain) if plain.lower() in _SPELT and len(plain) != 1 else plain
    if plain in {"", "1", "-"}:
        return "1" if plain else None
    if len(plain) == 1:
        plain = {"°": "deg", "%": "percent", "C": "degC", "n": "N", "v": "V"}.get(plain, plain)
    plain = plain.replace("²", "**2").replace("³", "**3").replace("·", "*")
    if not re.fullmatch(r"[A-Za-zµμ°%*/^0-9_ ]+", plain) or plain[0].isdigit():
        return None
    try:
        check(plain, "unit")
    except LabrigError:
        return None
    return plain


def take_apart(column: str | int, unit: str | None = None) -> Name:
    """A column's name in its parts; `unit` is what a row below the header says."""
    text = str(column).strip()
    bracket = _BRACKETS.match(text)
    if bracket and bracket["name"].strip():
        said = unit_of(bracket["unit"])
        unit = unit or said
        if said is not None:
            text = bracket["name"]
    elif "/" in text and (said := unit_of(text.rpartition("/")[2])) and not text.startswith("/"):
        unit, text = unit or said, text.rpartition("/")[0]
    parts = _parts(text)
    words = [part.lower() for part in parts]
    if len(words) > 1 and words[-1] in _AS_SUFFIX:
        unit = unit or unit_of(
            parts[-1] if parts[-1] in {"N", "V", "K"} else _SPELT.get(words[-1], words[-1])
        )
        text = _before(text, parts[-1])[: -len(parts[-1])].rstrip(" _-./") or text
        parts, words = parts[:-1], words[:-1]
    axis = words[-1] if words[-1:] and words[-1] in {"x", "y", "z"} else None
    owner = text
    if axis is not None:
        owner = re.sub(r"[^A-Za-z0-9]*[xyzXYZ]?$", "", _before(text, parts[-1])) or "marker"
    elif words[:1] and words[0] in {"x", "y", "z"} and len(words) <= 2:
        axis, owner = words[0], f"marker{''.join(words[1:])}"
    return Name(str(column), tuple(words), unit, axis, owner, text.strip() or str(column).strip())


def _parts(text: str) -> list[str]:
    """A name at its separators, digits and capitals, but for those inside a unit: kPa, kN, mBar, degC."""
    parts = [part for part in _SPLIT.split(text) if part]
    last = "".join(parts[-2:])
    if len(parts) > 1 and last.lower() in _AS_SUFFIX and text.endswith(last):
        parts[-2:] = [last]
    return parts


def _before(text: str, part: str) -> str:
    return text[: text.rfind(part)] + part
