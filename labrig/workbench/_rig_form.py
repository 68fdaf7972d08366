"""A form that was filled, as the content of a rig file, and back; what the form has no field for is never lost.

A form holds what was typed, as texts: `{name, chambers: [{name, ...}], markers, pressure: {kind, ...}, ...}`, with the
names that a rig file has. What is typed is not judged here: `_rig_check` does that, with the rules of `load_rig`.
"""

from typing import Any

import yaml

from labrig._errors import LabrigError
from labrig.rig import RigConfig
from labrig.workbench._rig_fields import ALONE, CHAMBER, DEVICES, SECTIONS, Field, kind_of, shown
from labrig_drivers import SETTINGS

Form = dict[str, Any]
MOST_CHAMBERS = 64
MOST_MARKERS = 1000
_LONGEST = 100_000
_LONGEST_NUMBER = 40
_LONGEST_WORDS = 100
HEAD = "# Set up in labrig's workbench. What each setting means: docs/how-to/connect-your-rig.md\n"
_KNOWN = ("name", "chambers", "markers", "rest_mm", *DEVICES, *SECTIONS)


def fresh_form() -> Form:
    """The form of a rig of four chambers, as it is before anything was typed."""
    chambers = [{f.key: f"c{n}" if f.key == "name" else f.default for f in CHAMBER} for n in range(1, 5)]
    return {
        **{f.key: f.default for f in ALONE},
        "chambers": chambers,
        "markers": "",
        **{role: {"kind": kinds[0].kind, **_empty(kinds[0].fields)} for role, kinds in DEVICES.items()},
        **{name: _empty(fields) for name, fields in SECTIONS.items()},
    }


def _empty(fields: tuple[Field, ...]) -> dict[str, str]:
    return {field.key: field.default for field in fields}


def content_of(form: Form) -> dict[str, Any]:
    """The content of the rig file that a form stands for; what is as labrig has it anyway is left out.

    Raises `LabrigError` for what is no such form, or too much for one.
    """
    chambers = form.get("chambers")
    if not isinstance(chambers, list) or len(chambers) > MOST_CHAMBERS:
        raise LabrigError(f"chambers: there is room for {MOST_CHAMBERS}; write the rig file by hand")
    content: dict[str, Any] = _values(ALONE, form, "")
    content["chambers"] = [_chamber(row, k) for k, row in enumerate(chambers)]
    devices = {role: _device(role, form.get(role)) for role in DEVICES}
    if devices["mocap"] is not None:
        content |= _markers(_text(form.get("markers"), "markers", lines=True))
    content |= {role: device for role, device in devices.items() if device is not None}
    has_channels = devices["pressure"] is not None and devices["pressure"]["kind"] != "simulated"
    if has_channels and (outputs := _outputs(chambers)):
        content["pressure"]["outputs"] = outputs
    sections = {name: _values(fields, form.get(name), name) for name, fields in SECTIONS.items()}
    simulated = _simulated(sections.pop("simulated"))
    if any(device is not None and device["kind"] == "simulated" for device in devices.values()):
        content["simulated"] = simulated
    return content | {name: section for name, section in sections.items() if section}


def text_of(content: dict[str, Any]) -> str:
    """The rig file."""
    return HEAD + yaml.safe_dump(
        content, sort_keys=False, default_flow_style=None, allow_unicode=True, width=110
    )


def form_of(content: dict[str, Any]) -> Form:
    """The form that stands for the content of a rig file.

    Raises `LabrigError` that names what the form has no field for. Whether nothing else would be lost, only a
    comparison of what both stand for can tell: see `same`.
    """
    for name in content:
        if name not in _KNOWN:
            raise _no_field(str(name))
    chambers = content.get("chambers")
    if not isinstance(chambers, list) or len(chambers) > MOST_CHAMBERS:
        raise _no_field(f"more than {MOST_CHAMBERS} chambers" if chambers else "no chambers")
    form = fresh_form() | _texts(ALONE, {"name": content.get("name")}, "")
    form["chambers"] = [
        _texts(CHAMBER, _mapping(row, f"chambers.{k}"), f"chambers.{k}") for k, row in enumerate(chambers)
    ]
    form["markers"] = _lines(content.get("markers") or [], _mapping(content.get("rest_mm"), "rest_mm"))
    for role in DEVICES:
        settings = _mapping(content.get(role), role)
        form[role] = _device_texts(role, settings, form["chambers"])
    for name, fields in SECTIONS.items():
        section = _mapping(content.get(name), name)
        form[name] = _texts(fields, _body(section) if name == "simulated" else section, name)
    return form


def same(one: RigConfig, other: RigConfig) -> bool:
    """Whether two rig files stand for the same rig, every default written out."""
    return _plain(one) == _plain(other)


def _plain(config: RigConfig) -> dict[str, Any]:
    content = config.to_dict()
    for role, device in config.devices.items():
        if device is not None and device.kind in SETTINGS:
            content[role] = SETTINGS[device.kind].model_validate(device.options).model_dump()
            content[role] |= {"kind": device.kind}
            outputs = content[role].get("outputs")
            if outputs is not None and list(outputs) == list(range(len(config.chambers))):
                content[role]["outputs"] = None
    return content


def _values(fields: tuple[Field, ...], typed: Any, where: str) -> dict[str, Any]:
    """What was typed into fields, by their names; without what is empty, or a default that need not be said."""
    out: dict[str, Any] = {}
    typed = typed if isinstance(typed, dict) else {}
    for field in fields:
        if field.when is not None and typed.get(field.when[0], "") != field.when[1]:
            continue
        text = _text(typed.get(field.key), f"{where}.{field.key}".strip("."))
        value = _number(text) if field.kind == "number" else text
        default = _number(field.default) if field.kind == "number" else field.default
        if text and (field.need or value != default):
            out[field.key] = value
    return out


def _text(typed: Any, where: str, lines: bool = False) -> str:
    """What was typed, without spaces around it; raises `LabrigError` for what no field of a page holds."""
    text = "" if typed is None else typed
    if not isinstance(text, str) or len(text) > _LONGEST:
        raise LabrigError(f"{where}: a text is needed, of at most {_LONGEST} signs")
    text = text.strip()
    if not ("".join(text.split()) if lines else text).isprintable():
        raise LabrigError(
            f"{where}: {text[:_LONGEST_NUMBER]!r} holds a sign that cannot be printed; type it again"
        )
    return text


def _number(text: str) -> Any:
    """The number that was typed, also with a comma; what is none stays as it is, and is refused with the rig."""
    if len(text) <= _LONGEST_NUMBER:
        for kind in (int, float):
            try:
                return kind(text.replace(",", "."))
            except ValueError:
                continue
    return text


def _chamber(row: Any, k: int) -> dict[str, Any]:
    if not isinstance(row, dict):
        raise LabrigError(f"chambers.{k}: a row of the table is needed")
    typed = {f.key: _text(row.get(f.key), f"chambers.{k}.{f.key}") for f in CHAMBER if f.key != "output"}
    kinds = {f.key: f.kind for f in CHAMBER}
    return {key: _number(text) if kinds[key] == "number" else text for key, text in typed.items() if text}


def _outputs(chambers: list[Any]) -> list[Any]:
    """The board's channel of each chamber; where all are in order, it need not be said."""
    typed = [_text(row.get("output"), f"chambers.{k}.output") for k, row in enumerate(chambers)]
    outputs = [_number(text) if text else k for k, text in enumerate(typed)]
    return [] if outputs == list(range(len(outputs))) else outputs


def _device(role: str, typed: Any) -> dict[str, Any] | None:
    typed = typed if isinstance(typed, dict) else {}
    name = _text(typed.get("kind"), f"{role}.kind")
    kind = kind_of(role, name)
    if kind is None:
        raise LabrigError(f"{role}: the form has no kind {name!r}; write the rig file by hand")
    if not kind.kind:
        return None
    values = _values(kind.fields, typed, role)
    values.pop("by", None)
    return {"kind": kind.kind, **values}


def _markers(text: str) -> dict[str, Any]:
    """Markers, one a line or between commas, and the resting places of those that have one."""
    names: list[str] = []
    rest_mm: dict[str, list[Any]] = {}
    for line in text.splitlines():
        parts = [part.strip() for part in line.split(",") if part.strip()]
        place = [_number(part) for part in parts[1:]]
        numbers = [isinstance(value, int | float) for value in place]
        if any(numbers) and isinstance(_number(parts[0]), str) and not (all(numbers) and len(place) == 3):
            raise LabrigError(
                f"markers: {line.strip()}: a resting place has three numbers, x, y and z in mm, "
                "such as m01, 10, 20.5, 3"
            )
        if len(place) == 3 and all(isinstance(value, int | float) for value in place):
            rest_mm[parts[0]] = place
            parts = parts[:1]
        names += parts
    if len(names) > MOST_MARKERS:
        raise LabrigError(f"markers: there is room for {MOST_MARKERS}; write the rig file by hand")
    return ({"markers": names} if names else {}) | ({"rest_mm": rest_mm} if rest_mm else {})


def _simulated(typed: dict[str, Any]) -> dict[str, Any]:
    """The section, in which what is simulated is a surface or a shell; `body` says both."""
    kind, _, name = str(typed.pop("body", "")).partition(":")
    return {kind: name, **typed} if name else typed


def _no_field(what: str) -> LabrigError:
    return LabrigError(f"the form has no field for {' '.join(what.split())[:_LONGEST_WORDS]}")


def _mapping(value: Any, where: str) -> dict[str, Any]:
    if value is None:
        return {}
    if not isinstance(value, dict):
        raise _no_field(where)
    return value


def _texts(fields: tuple[Field, ...], content: dict[str, Any], where: str) -> dict[str, str]:
    """What stands in fields for a part of a rig file."""
    out = _empty(fields)
    for key, value in content.items():
        name = f"{where}.{key}".strip(".")
        if key not in out:
            raise _no_field(name)
        if value is not None:
            out[key] = _one_line(value, name)
    return out


def _one_line(value: Any, name: str) -> str:
    """A value as it stands in a field, which gives it back as it was."""
    if not isinstance(value, str | int | float) or isinstance(value, bool):
        raise _no_field(f"what {name} is")
    text = shown(value)
    if text != text.strip() or not text.isprintable() or len(text) > _LONGEST:
        raise _no_field(f"{name} of several lines, or with spaces around it")
    return text


def _device_texts(role: str, settings: dict[str, Any], chambers: list[dict[str, str]]) -> dict[str, str]:
    """The fields of a device; the channels of its chambers go into their rows."""
    kind = settings.get("kind", "")
    if not isinstance(kind, str) or (found := kind_of(role, kind)) is None:
        raise _no_field(f"{role} of kind {kind!r}" if isinstance(kind, str) else f"what {role}.kind is")
    settings = {key: value for key, value in settings.items() if key != "kind"}
    outputs = settings.pop("outputs", None) if role == "pressure" else None
    if outputs is not None:
        if not isinstance(outputs, list) or len(outputs) != len(chambers):
            raise _no_field("pressure.outputs other than one a chamber")
        for row, output in zip(chambers, outputs, strict=True):
            row["output"] = _one_line(output, "pressure.outputs")
    if found.kind == "modbus":
        settings["by"] = "serial" if settings.get("serial") is not None else "host"
    return {"kind": found.kind, **_texts(found.fields, settings, role)}


def _body(section: dict[str, Any]) -> dict[str, Any]:
    """The section `simulated` with one field for its surface or its shell."""
    named = [key for key in ("surface", "shell") if section.get(key) is not None]
    if len(named) > 1 or any(not isinstance(section[key], str) for key in named):
        raise _no_field("simulated.shell with content of its own")
    rest = {key: value for key, value in section.items() if key not in ("surface", "shell")}
    return {**rest, "body": f"{named[0]}:{section[named[0]]}" if named else ""}


def _lines(markers: Any, rest_mm: dict[str, Any]) -> str:
    """The markers of a rig file, one a line, with the resting places that it gives."""
    if not isinstance(markers, list) or not all(isinstance(name, str) for name in markers):
        raise _no_field("markers other than a list of names")
    if unknown := [name for name in rest_mm if name not in markers]:
        raise _no_field(f"a resting place of {unknown[0]}, which is not among the markers")
    return "\n".join(_line(name, rest_mm.get(name)) for name in markers)


def _line(marker: Any, place: Any) -> str:
    if place is not None and not (isinstance(place, list) and len(place) == 3):
        raise _no_field(f"what rest_mm.{marker} is")
    return ", ".join(_one_line(value, f"the marker {marker}") for value in [marker, *(place or [])])
