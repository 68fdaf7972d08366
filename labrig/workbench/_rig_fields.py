"""What the form of a new rig asks for: every field with its words, its unit and what labrig takes where it is empty.

What is left out of a rig file has its default there as here: both are read off the same classes.
"""

from dataclasses import asdict, dataclass
from typing import Any

from pydantic import BaseModel

from labrig.rig import ChamberConfig, FollowConfig, SafetyConfig
from labrig_drivers import SETTINGS

Choice = tuple[str, str]
"""A value, and what it is called."""


@dataclass(frozen=True)
class Field:
    """One field: `more` are those that few change; `when` names another field, and the value with which this counts.

    `kind` is text, sentence, number, choice, lines, port (a serial port), map (a register map) or body (what is
    simulated). `need` is a field that has to be filled.
    """

    key: str
    label: str
    unit: str = ""
    help: str = ""
    kind: str = "text"
    choices: tuple[Choice, ...] = ()
    default: str = ""
    more: bool = False
    when: tuple[str, str] | None = None
    need: bool = False


@dataclass(frozen=True)
class Kind:
    """A kind of device: what it is called, a line about it, its fields."""

    kind: str
    label: str
    help: str
    fields: tuple[Field, ...] = ()


def shown(value: Any) -> str:
    """A value as it stands in a field."""
    if value is None:
        return ""
    text = str(value)
    return text.removesuffix(".0") if isinstance(value, float) else text


def _defaults(model: type[BaseModel], *fields: Field) -> tuple[Field, ...]:
    """Fields with the defaults that a class of settings has for them."""
    known = {key: field for key, field in model.model_fields.items() if not field.is_required()}
    return tuple(
        Field(**{**vars(f), "default": shown(known[f.key].default)}) if f.key in known else f for f in fields
    )


def _number(key: str, label: str, unit: str = "", help: str = "", **more: Any) -> Field:
    return Field(key, label, unit, help, "number", **more)


_PARITIES = (("N", "none"), ("E", "even"), ("O", "odd"))
_WATCHED = (
    _number(
        "stale_after_s",
        "Stale after",
        "s",
        "After this time without a reading the device is stopped; left out, as Safety says.",
        more=True,
    ),
    _number(
        "over_kpa",
        "Trips beyond",
        "kPa",
        "Three readings in a row farther than this outside a chamber's limits stop the device.",
        more=True,
    ),
    _number(
        "vent_below_kpa",
        "Vented below",
        "kPa",
        "A vent is confirmed when every chamber reads less than this, three times; left out, as Safety says.",
        more=True,
    ),
    _number("timeout_s", "Answers within", "s", more=True),
)
_OPENPNEU = _defaults(
    SETTINGS["openpneu"],
    Field("port", "Port", help="COM3, /dev/ttyUSB0, or socket://HOST:PORT.", kind="port", need=True),
    Field(
        "dialect",
        "Dialect",
        help="auto asks the board with AT.",
        kind="choice",
        choices=(
            ("auto", "auto"),
            ("published", "published: the firmware on the project's site"),
            ("table", "table: its web page's instructions"),
        ),
    ),
    Field(
        "build",
        "Build",
        help="Say full only if your firmware does that. published: channels 0 and 1, 2 and 3, ... get one set-point.",
        kind="choice",
        choices=(("published", "published: channels in pairs"), ("full", "full: each channel on its own")),
    ),
    _number("baudrate", "Baud rate", "baud", more=True),
    _number("boot_s", "Boots for", "s", "The board resets when its port is opened.", more=True),
    *_WATCHED,
)
_MODBUS = (
    Field(
        "by",
        "Reached by",
        kind="choice",
        choices=(("host", "network (Modbus TCP)"), ("serial", "serial port (RTU)")),
        default="host",
    ),
    *_defaults(
        SETTINGS["modbus"],
        Field("host", "Host", help="The regulator's address: 192.168.1.20.", when=("by", "host"), need=True),
        _number("port", "TCP port", "", "Empty: that of the register map.", when=("by", "host"), more=True),
        Field("serial", "Port", help="COM5, /dev/ttyUSB0.", kind="port", when=("by", "serial"), need=True),
        _number("baudrate", "Baud rate", "baud", when=("by", "serial")),
        Field("parity", "Parity", kind="choice", choices=_PARITIES, when=("by", "serial")),
        Field(
            "map",
            "Register map",
            help="One that labrig brings, or a file of this folder. Another regulator needs its own map.",
            kind="map",
            need=True,
        ),
        _number("unit_id", "Unit", "", "Empty: that of the register map.", more=True),
        _number("poll_hz", "Read", "times a second", more=True),
        *_WATCHED,
    ),
)
_VICON = _defaults(
    SETTINGS["vicon"],
    Field("host", "Host", help="Where Tracker, Nexus or Shogun runs; its DataStream must be switched on."),
    _number("port", "Port"),
    Field("subject", "Subject", help="The subject that has the markers. Empty: any."),
    Field(
        "up",
        "Up",
        help="The axis that points up in labrig's positions.",
        kind="choice",
        choices=(("z", "z"), ("y", "y")),
    ),
    Field(
        "unit",
        "Its unit",
        help="m only for a server that is not Vicon's.",
        kind="choice",
        choices=(("mm", "mm"), ("m", "m")),
        more=True,
    ),
    Field(
        "mode",
        "Frames",
        kind="choice",
        choices=(("push", "push"), ("pull", "pull"), ("prefetch", "prefetch")),
        more=True,
    ),
    _number("stale_after_s", "Stale after", "s", "A marker without new data for this time.", more=True),
    _number("lost_after_s", "Lost after", "s", "No connection for this time is an error.", more=True),
    _number("timeout_s", "Answers within", "s", more=True),
)
_ARTEC = _defaults(
    SETTINGS["artec"],
    Field(
        "folder",
        "Folder",
        help="Artec Studio exports into it. A relative path starts from the rig file.",
        need=True,
    ),
    Field(
        "unit",
        "Its unit",
        help="As it is set in Artec Studio.",
        kind="choice",
        choices=tuple((unit, unit) for unit in ("mm", "cm", "m", "inch")),
        default="mm",
        need=True,
    ),
    _number("settle_s", "Complete after", "s", "Nothing has been written for this time.", more=True),
    _number("stall_s", "Given up after", "s", more=True),
)
_HERE = "It is computed here: for trying things out, without a device."
DEVICES: dict[str, tuple[Kind, ...]] = {
    "pressure": (
        Kind("openpneu", "OpenPneu", "Opening the connection later sets every target of it to 0.", _OPENPNEU),
        Kind("modbus", "Modbus regulator", "", _MODBUS),
        Kind("simulated", "simulated", _HERE),
    ),
    "mocap": (
        Kind("", "none", ""),
        Kind("vicon", "Vicon", "", _VICON),
        Kind("simulated", "simulated", _HERE),
    ),
    "scanner": (
        Kind("", "none", ""),
        Kind("artec", "Artec", "", _ARTEC),
        Kind("simulated", "simulated", _HERE),
    ),
}
TITLES = {"pressure": "Pressure controller", "mocap": "Motion capture", "scanner": "Scanner"}
ALONE = (
    Field("name", "Name of the rig", help="Its runs carry it, and its history is found by it.", need=True),
)
MARKERS = Field(
    "markers",
    "Markers",
    help="One a line, as the motion capture names them. Empty: all of the subject. A line may have a resting place, "
    "mm: m01, 10, 20.5, 3",
    kind="lines",
)
CHAMBER = (
    *_defaults(
        ChamberConfig,
        Field("name", "name", need=True),
        _number("min_kpa", "least", "kPa (min_kpa)"),
        Field("max_kpa", "most", "kPa (max_kpa)", kind="number", default="60", need=True),
        _number("slew_kpa_s", "slew", "kPa/s"),
    ),
    _number("output", "board channel", "", "Empty: 0, 1, 2, ... in the order of the chambers."),
)
SIMULATED = (
    Field("body", "What is simulated", kind="body", default="surface:membrane", need=True),
    _number("seed", "Seed", "", "Of noise and of what is hidden from the cameras. Empty: 0."),
    _number("noise_mm", "Noise of a frame", "mm", "Empty: 0.1 mm."),
    _number("occlusion", "Share of markers hidden", "0 to 1", "Empty: 0.03."),
)
SAFETY = _defaults(
    SafetyConfig,
    Field(
        "vents_alone",
        "What vents when this computer is gone",
        kind="sentence",
        help="In words: normally-open valves behind a relay on this computer's USB power. Empty: nothing does, and a "
        "run is not left unattended unless the device has a watchdog.",
    ),
    _number("over_pressure_kpa", "A chamber reads too much", "kPa outside its limits: the run ends, vented"),
    _number("stale_pressure_s", "No pressure is measured", "s: the run ends, vented"),
    _number("lost_mocap_s", "Motion capture is lost", "s: the run ends, vented"),
    _number("vented_kpa", "A chamber is vented", "kPa from ambient at most"),
    _number("vent_timeout_s", "One attempt to vent takes", "s at most"),
    _number("vent_patience_s", "Attempts are repeated for", "s"),
    _number("heartbeat_s", "A runner that hangs is given", "s before the guard vents"),
    _number("guard_patience_s", "The guard goes on to vent for", "s"),
    _number("think_s", "A procedure may compute for", "s between two steps"),
)
FOLLOW = _defaults(
    FollowConfig,
    _number("tolerance_kpa", "A chamber may be off by", "kPa"),
    _number("tolerance_share", "and by this share of its set-point", "0 to 1"),
    _number("repeats", "A capture that misses is repeated", "times"),
    Field(
        "on_miss",
        "Then",
        kind="choice",
        choices=(
            ("pause", "vent, and wait for a person"),
            ("skip", "go on, without this capture"),
            ("abort", "end the run"),
        ),
    ),
)
SECTIONS = {"simulated": SIMULATED, "safety": SAFETY, "follow": FOLLOW}


def kind_of(role: str, kind: str) -> Kind | None:
    """A kind of device that the form knows; None for others."""
    return next((each for each in DEVICES[role] if each.kind == kind), None)


def described() -> dict[str, Any]:
    """The form as the page draws it."""
    return {
        "alone": [asdict(field) for field in ALONE],
        "markers": asdict(MARKERS),
        "chamber": [asdict(field) for field in CHAMBER],
        "devices": [
            {"role": role, "title": TITLES[role], "kinds": [asdict(kind) for kind in kinds]}
            for role, kinds in DEVICES.items()
        ],
        "sections": {name: [asdict(field) for field in fields] for name, fields in SECTIONS.items()},
    }
