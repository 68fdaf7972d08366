"""What the name of a column says of it: a unit, an axis, and what it is likely to be."""

import re
from dataclasses import dataclass, replace

from labrig.tables._spelling import is_absolute, ungauged, unit_of
from labrig.tables._spelling import is_unit as is_unit
from labrig.tables._units import like

_BRACKETS = re.compile(r"[\[({<]((?:[^\[\](){}<>]|\([^()]*\)|\[[^\[\]]*\])*)[\])}>]")
_IN_FRONT = re.compile(r"(?!min|px|pixel|[mun]?s)([A-Za-z]{2,})(?:[\W_]*(?:\d+|[A-F]))?")
"""A unit is all of a name, but for a number, as in kPa_1."""
_COMMENT = re.compile(r"^(?:#|//)\s+(?!of\b)(?=\S)")
"""What a program writes before the first name of a line of names, as before any line that is no row."""
_INDEX = re.compile(r"\[\d+$")
"""A place in an array, points[1], without its end."""
_PLACE = re.compile(r"(.*[^\W\d_])((?:\.\d+)+)")
_LETTER = r"[^\W\d_]"
_SPLIT = re.compile(
    rf"(?:[^\w°%]|_)+|(?<=[a-z])(?=[A-Z])|(?<={_LETTER})(?=\d)|(?<=\d)(?={_LETTER})|(?<=[\d])(?=[°%])"
)
_AS_SUFFIX = {
    "s", "ms", "us", "ns", "min", "sec", "secs", "seconds", "msec", "usec", "nsec", "nanosec", "kpa", "mpa", "pa",
    "bar", "mbar", "psi", "inhg", "mmhg", "mm", "cm", "m", "um", "n", "kn", "mn", "nm", "mnm", "nmm", "deg", "rad",
    "degc", "v", "mv", "ma", "kg", "g", "px", "pixel", "pixels", "hpa", "volts", "newton", "pct", "percent", "hz",
    "ohm", "ohms", "kohm", "mohm", "lbf", "kgf", "°c", "°", "%", "ml", "ul",
}  # fmt: skip
_BY_CAPITALS = {
    "fF", "pF", "nF", "uF", "uV", "kV", "MV", "fA", "pA", "nA", "uA", "kA", "pC", "nC", "nH", "uH", "mH", "uW", "mW",
    "kW", "nT", "uT", "mT", "mJ", "kJ",
}  # fmt: skip
"""Units at the end of a name that are told by their capitals only: u_ff feeds forward."""
_OF_WATER = re.compile(r"(?<=[^\W_])[\W_]+((?:[cm]m|in)H2O)$", re.I)
"""A pressure as a column of water at the end of a name, with a digit in it."""
_IN_A_UNIT = re.compile(r"(?<=[^\W_])\s+(?:in|en)\s+$", re.I)
"""What stands before a unit in a sentence: Druck in mbar. In p_in_bar it says which pressure."""
_FLOWS = {"l", "ml", "ul", "nl", "mm", "cm", "m", "deg", "rad"}
"""What is said for each second or minute, as in flow_l_min."""
_CURVED = {"kappa", "curv", "curvature", "krümmung", "kruemmung", "courbure", "curvatura"}
"""What is said for each length, so that p_1/kPa is the first pressure, and kappa_1/m a curvature."""
TIME = {
    "t", "ts", "epoch", "time", "timestamp", "stamp", "clock", "elapsed", "datetime", "date", "zeit", "uhrzeit",
    "datum", "temps", "heure", "tiempo", "hora", "fecha", "tempo", "ora",
}  # fmt: skip
PRESSURE = {
    "p", "pressure", "press", "pres", "druck", "solldruck", "istdruck", "pressures", "pression", "vacuum", "vakuum",
}  # fmt: skip
DUTY = {"pwm", "duty"}
ABSOLUTE = {"abs", "absolute", "absolut", "pabs"}
"""What says of a pressure that it is no gauge pressure."""
INPUT = DUTY | {"u", "input", "in", "voltage", "current", "drive", "actuation", "valve"}
COMMANDED = {
    "set", "setpoint", "sp", "sv", "cmd", "command", "commanded", "ref", "reference", "desired", "des", "target",
    "goal", "req", "request", "requested", "soll", "sollwert", "solldruck", "consigne",
}  # fmt: skip
MEASURED = {
    "meas", "measured", "measurement", "act", "actual", "present", "sens", "sensor", "read", "reading", "fb",
    "feedback", "pv", "ist", "istwert", "istdruck", "mes", "mesure", "mesur\u00e9",
}  # fmt: skip
CONVERTER = {"adc"}
"""Who reads a sensor: no input, whatever else a column is called."""
COMPUTED = {"predicted", "prediction", "pred", "fitted", "residual", "residuals", "simulated"}
"""What a model gave, and no sensor."""
COUNTER = {
    "index", "row", "frame", "id", "no", "nr", "num", "number", "count", "counter", "unnamed", "seq", "nummer", "zeile",
    "numéro", "número", "numero", "ligne", "fila", "riga",
}  # fmt: skip
LABEL = {"marker", "tag", "body", "object", "point", "track", "sensor", "target"}
CAPTURE = {
    "capture", "hold", "step", "trial", "segment", "pose", "sample", "phase", "stage", "cycle", "schritt", "stufe",
    "zyklus", "étape", "etape", "palier", "paso", "ciclo", "passo", "shot", "scan",
}  # fmt: skip
SEEN = {"sample", "shot"}
"""What is numbered one by one: several of one number are a capture, each with a number of its own is none."""
DAY = {"day", "tag", "jour", "día", "dia", "giorno"}
SESSION = DAY | {
    "session", "run", "experiment", "exp", "test", "specimen", "sitzung", "lauf", "versuch", "prüfling", "séance",
    "seance", "essai", "éprouvette", "eprouvette", "sesión", "sesion", "ensayo", "prueba", "probeta", "sessione",
    "prova", "provino",
}  # fmt: skip
REPEAT = {
    "repeat", "repetition", "rep", "wiederholung", "wdh", "répétition", "repetición", "repeticion", "ripetizione",
}  # fmt: skip
AMBIENT = {
    "temp", "temperature", "room", "ambient", "humidity", "payload", "tilt", "temperatur", "température", "temperatura",
    "amb", "ambiant", "ambiante", "ambiente", "tamb", "tair", "troom", "tlab", "traum", "airtemp", "roomtemp",
    "raumtemp", "raumtemperatur", "lufttemperatur", "umgebungstemperatur", "hallentemperatur", "labortemperatur",
    "zimmertemperatur",
}  # fmt: skip
AROUND = {
    "air", "lab", "env", "environment", "luft", "raum", "umgebung", "labor", "halle", "aria", "aire", "salle",
}  # fmt: skip
"""What is around the measurement if t stands before it: T_air, but not air_gap."""
HUMIDITY = {
    "rh", "feuchte", "luftfeuchte", "feuchtigkeit", "luftfeuchtigkeit", "humidité", "humedad", "umidità", "hum",
    "humid", "hygro", "hygrometer",
}  # fmt: skip
"""What is around the measurement if it is a share: RH may be a right hand, too."""
HUMIDITY_SHORT = {"rh", "rf", "hr", "relh", "hrel", "%rh", "%rf", "%hr", "rh%", "rf%"}
"""The same, as letters that are all of a name: r.F. of a German, HR of a French one if its unit is percent."""
MARKERS = {"marker", "markers"}
ERROR = {"error", "err", "rms", "rmse"}
TRACKED = {"visible", "seen", "tracked", "used", "valid", "missing", "count"}
QUALITY = {"reprojection", "quality"}
"""What says how good a measurement was, as an error of markers and their number do."""
LOAD = {
    "load", "last", "zusatzlast", "gewicht", "zusatzgewicht", "masse", "zusatzmasse", "charge", "poids", "carga",
    "peso", "carico",
}  # fmt: skip
"""What is beside the measurement where it stands still: else it was measured."""
TURNED = {"tilt", "inclination", "pitch", "roll", "orientation"}
"""How a rig was put up, if it is an angle that stands still and does not follow the inputs."""
SIDE = {
    "barometer", "baro", "barometric", "atmospheric", "pump", "compressor", "battery", "vbat", "batterie", "akku",
    "cpu", "solenoid", "likelihood", "confidence", "score",
}  # fmt: skip
SUPPLY = {"supply", "line", "tank", "source", "reservoir", "main", "regulator"}
"""What is beside the measurement if it is a pressure, too, or electric and hardly moves."""
ATMOSPHERE = {
    "atm", "patm", "patmo", "pamb", "air", "luftdruck", "umgebungsdruck", "atmosphere", "atmosphérique",
    "atmospherique", "atmosférica", "atmosferica",
}  # fmt: skip
"""What is beside the measurement if it is a pressure that hardly moves: Luftdruck may be what a valve gave."""
STATE = {"valve", "relay", "state", "status", "alarm", "enable", "enabled", "ok", "valid"}
"""What is beside the measurement if it is never but 0 or 1."""
OUTPUT = {
    "y", "out", "output", "force", "displacement", "disp", "position", "pos", "angle", "stroke", "length", "strain",
    "stress", "torque", "load", "deflection", "extension", "bend", "bending", "level", "theta",
}  # fmt: skip
FORCE = {"force", "load", "stress", "torque"}
STRETCH = {"extension", "elongation", "strain"}
TRAVEL = STRETCH | {"stroke", "crosshead", "travel", "displacement", "disp", "position", "pos", "deflection"}
NO_POSITION = {
    "acc", "accel", "acceleration", "gyro", "mag", "magnetometer", "torque", "moment", "force", "wrench", "vel",
    "velocity", "rot", "rotation", "rpy", "quat", "quaternion", "orientation", "euler", "omega", "angular", "rate",
    "std", "q", "error",
}  # fmt: skip
"""What has an x, a y and a z, too, and is no place in space."""
_OF_CAPITAL = {
    "A": {"current"},
    "C": {"temp", "temperature", "room", "ambient", "amb"},
    "K": {"temp", "temperature"},
}
_ONE_SAID = COMMANDED | MEASURED


@dataclass(frozen=True)
class Name:
    """A column's name taken apart: its words in lower case, its unit and axis where it says them.

    `called` is the name without its unit; `written` is what stands where a unit stands, and is none that is known.
    `absolute`: it is a pressure that is counted from vacuum, not from the air's.
    """

    column: str
    words: tuple[str, ...]
    unit: str | None
    axis: str | None
    owner: str
    called: str = ""
    written: str = ""
    absolute: bool = False

    def has(self, kind: set[str]) -> bool:
        """Whether one of its words is of a kind."""
        return any(word in kind for word in self.words)


def take_apart(column: str | int, unit: str | None = None) -> Name:
    """A column's name in its parts; `unit` is what a row below the header says.

    A column of an array, p_kPa.0, has the unit of the array.
    """
    if unit is None and (place := _PLACE.fullmatch(str(column).strip())):
        array = take_apart(place[1])
        if array.unit is not None:
            words, called, owner = (*array.words, *place[2].split(".")[1:]), array.called, array.owner
            return replace(
                array, column=str(column), words=words, called=called + place[2], owner=owner + place[2]
            )
    text, said, written = _bracketed(ungauged(str(column).strip()))
    if said is None and not written:
        text, said = _behind_slash(text)
    if said is None:
        text, said = _suffix(text, written)
    parts = _parts(text[: text.rindex(written) - 1] if re.search(r"[\d=^]", written) else text)
    words = [word for part in parts for word in _words_of(part)]
    if said is None and (first := _IN_FRONT.fullmatch(text)) and first[1].lower() in _AS_SUFFIX:
        said = unit_of(first[1])
    axis = words[-1] if words[-1:] and words[-1] in {"x", "y", "z"} else None
    owner = text
    if axis is not None:
        owner = re.sub(r"[\W_]*[xyzXYZ]?$", "", text[: text.rfind(parts[-1])] + parts[-1]) or "marker"
        owner += "]" * bool(_INDEX.search(owner))
    elif words[:1] and words[0] in {"x", "y", "z"} and len(words) <= 2:
        axis, owner = words[0], f"marker{''.join(words[1:])}"
    called = _COMMENT.sub("", text.strip()) or str(column).strip()
    written = "" if unit else written
    absolute = _is_absolute(str(column), set(words), unit or said)
    return Name(str(column), tuple(words), unit or said, axis, owner, called, written, absolute)


def _is_absolute(column: str, words: set[str], unit: str | None) -> bool:
    """Whether a column's name says that its pressure is absolute: beside its unit, or in one of its words."""
    if unit is not None and words & ABSOLUTE:
        return like(unit, "kPa")
    parts = (column, column.rpartition("/")[2], *(found[1] for found in _BRACKETS.finditer(column)))
    return any(map(is_absolute, parts))


def _bracketed(text: str) -> tuple[str, str | None, str]:
    """A name without the unit in its brackets, and that unit; or as it is, and what its last brackets say instead."""
    for found in reversed(list(_BRACKETS.finditer(text))):
        before, after = text[: found.start()].rstrip(), text[found.end() :].strip()
        attached = found.start() and text[found.start() - 1] != " "  # points[1].x, but strain [1]
        number = found[1].strip().isdigit() and (found[0].startswith("(") or attached)
        if before and not number and (said := unit_of(found[1])) is not None:
            return f"{before} {after}".rstrip(), said, ""
    last = re.search(_BRACKETS.pattern + r"\s*$", text)
    inside = last[1].strip() if last and text[: last.start()].strip() else ""
    alone = {word for part in _parts(inside) for word in _words_of(part)}
    known = all(_counts(word) or word in _ONE_SAID | {"x", "y", "z"} for word in alone)
    return text, None, "" if known else inside


def _behind_slash(text: str) -> tuple[str, str | None]:
    """A name before a slash and the unit behind it, as in F/N or t/s; or before a whole unit, as in flow l/min, or
    strain_um/m, or kappa_1/m.
    """
    if "/" not in text or text.startswith("/"):
        return text, None
    before, _, last = text.rpartition(" ")
    if before and "/" in last and not last.startswith("/") and (said := unit_of(last)) is not None:
        return before.rstrip(" ,:-"), said
    before, _, last = text.rpartition("_")
    above, _, below = last.partition("/")
    bent = above == "1" and bool(_CURVED & {word.lower() for word in _parts(before)})
    if (
        before
        and below
        and (bent or above.lower() in _AS_SUFFIX | _FLOWS)
        and (said := unit_of(last)) is not None
    ):
        return before, said
    name, _, unit = text.rpartition("/")
    said = unit_of(unit)
    of_time = any(word.lower() in TIME for word in _parts(name))
    return (
        (name.rstrip(), said)
        if said is not None and (of_time or said not in {"s", "min", "h"})
        else (text, None)
    )


def _suffix(text: str, written: str) -> tuple[str, str | None]:
    """A name without the unit at its end, and that unit; where brackets say something else, before those."""
    if not written and (water := _OF_WATER.search(text)) and (said := unit_of(water[1])) is not None:
        return _IN_A_UNIT.sub("", text[: water.start(1)]).rstrip(" _-./,:"), said
    bare, behind = text, ""
    if written:
        at = text.rindex(written) - 1
        bare, behind = text[:at].rstrip(), text[at:]
    parts = _parts(bare)
    words = tuple(part.lower() for part in parts)
    if len(words) < 2:
        return text, None
    name = Name("", words[:-1], None, None, "")
    tail, said = parts[-1], None
    if words[-1] in {"s", "min"} and len(words) > 2 and words[-2] in _FLOWS:
        tail = bare[bare.rindex(parts[-2], 0, bare.rindex(parts[-1])) :]
        said = unit_of(f"{parts[-2]}/{parts[-1]}")
    elif words[-1] in {"m", "mm"} and len(words) > 2 and parts[-2] in {"N", "mN"}:
        tail = bare[bare.rindex(parts[-2], 0, bare.rindex(parts[-1])) :]
        said = unit_of(f"{parts[-2]}*{parts[-1]}")
    elif words[-1] in _AS_SUFFIX and not _contradicts(name, words[-1]):
        said = unit_of(parts[-1] if parts[-1] in {"N", "V", "K"} else words[-1])
    elif parts[-1] in _BY_CAPITALS or name.has(_OF_CAPITAL.get(parts[-1], set())):
        said = unit_of(parts[-1])
    if said is None:
        return text, None
    left = _IN_A_UNIT.sub("", bare[: bare.rindex(tail)]).rstrip(" _-./,:") or bare
    return f"{left} {behind}".rstrip(), said


def _contradicts(name: Name, unit: str) -> bool:
    """Whether what looks like a unit at the end of a name can't be that of what it is called: p1_m, force_min."""
    if unit == "min":
        return not name.has(TIME | CAPTURE)
    if unit == "s" and name.has(OUTPUT):
        return True
    return len(unit) == 1 and unit != "v" and name.has(PRESSURE)


def _counts(word: str) -> bool:
    return word.isdigit() or (len(word) == 1 and word in "abcdef")


def _words_of(part: str) -> tuple[str, ...]:
    """A part of a name in lower case; Pset, Vfb, measP and PWMe in two words."""
    word = part.lower()
    if len(word) > 2 and word not in _ONE_SAID:
        if word[0] in "pvui" and word[1:] in _ONE_SAID:
            return word[0], word[1:]
        if word[-1] in "pv" and word[:-1] in _ONE_SAID:
            return word[:-1], word[-1]
        if word[:-1] == "pwm":
            return word[:-1], word[-1]
    return (word,)


def _parts(text: str) -> list[str]:
    """A name at its separators, digits and capitals, but for those inside a unit: kPa, kN, mBar, degC."""
    parts = [part for part in _SPLIT.split(text) if part]
    last = "".join(parts[-2:])
    if len(parts) > 1 and (last.lower() in _AS_SUFFIX or last in _BY_CAPITALS) and text.endswith(last):
        parts[-2:] = [last]
    return parts
