"""Fields of people's own files checked by pydantic, and what is wrong with the first of them, in words."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import InitErrorDetails

from labrig._errors import LabrigError

Checked = TypeVar("Checked", bound=BaseModel)
_UNPARSED = ", unable to parse"
_BEYOND = ("less_than", "less_than_equal")
_PLAIN = {
    "should be a valid tuple": "should be a list",
    "should be a valid list": "should be a list",
    "should be a valid dictionary": "should hold fields (name: value)",
    "should be a valid dictionary or object to extract fields from": "should hold fields (name: value)",
}


@dataclass(frozen=True)
class Fault:
    """What is wrong with one field: the keys and numbers that lead there, the same in words, and what it is.

    `error` is pydantic's own.
    """

    place: tuple[str | int, ...]
    names: tuple[str, ...]
    what: str
    error: Any

    @property
    def kind(self) -> str:
        """Pydantic's name for such a fault."""
        return self.error["type"]

    def __str__(self) -> str:
        return ": ".join([*self.names, self.what])


class FieldError(LabrigError):
    """A field of a file is wrong: `place` are the keys and numbers that lead there, `what` is wrong with it."""

    def __init__(self, message: str, place: tuple[str | int, ...] = (), what: str = "") -> None:
        super().__init__(message)
        self.place, self.what = place, what


def check_fields(
    kind: type[Checked], content: Mapping[str, Any], where: str, path: Path | None = None, section: str = ""
) -> Checked:
    """The content as `kind` has it; raises `FieldError` that names the file, the line of a YAML `path`, the field.

    `section` is where in the file the content stands, if it is not all of it.
    """
    try:
        return validated(kind, content)
    except ValidationError as error:
        fault, more = first_fault(error, kind, content)
    from labrig._yaml import line_of

    place = (section, *fault.place) if section else fault.place
    line = None if path is None else line_of(path, place)
    others = f" (and {more} more)" if more else ""
    inside = f"{section}: " if section else ""
    said = f"{where}{f', line {line}' if line else ''}: {inside}{fault}{others}"
    raise FieldError(said, place, fault.what) from None


def validated(kind: type[Checked], content: Mapping[str, Any]) -> Checked:
    """The content as `kind` has it; raises pydantic's `ValidationError`, also for true or false as a number."""
    checked = kind.model_validate(content)
    if places := [*_truths(content, checked)]:
        faults = [InitErrorDetails(type="float_type", loc=place, input=given) for place, given in places]
        raise ValidationError.from_exception_data(kind.__name__, faults)
    return checked


def _truths(content: Any, checked: Any) -> Iterator[tuple[tuple[str | int, ...], bool]]:
    """Where true or false stands in the content, and a number was made of it."""
    pairs: Iterator[tuple[Any, Any, Any]] = iter(())
    if isinstance(content, bool):
        if isinstance(checked, int | float) and not isinstance(checked, bool):
            yield (), content
    elif isinstance(content, Mapping):
        inside = vars(checked) if isinstance(checked, BaseModel) else checked
        if isinstance(inside, Mapping):
            pairs = ((key, value, inside.get(key)) for key, value in content.items())
    elif isinstance(content, list | tuple) and isinstance(checked, list | tuple):
        pairs = ((k, one, other) for k, (one, other) in enumerate(zip(content, checked, strict=False)))
    for key, one, other in pairs:
        for place, given in _truths(one, other):
            yield (key, *place), given


def first_fault(error: ValidationError, kind: type[BaseModel], content: Any) -> tuple[Fault, int]:
    """The first thing that is wrong, and how many more there are; a misspelt name stands for what is missing by it."""
    faults: dict[tuple[str | int, ...], Fault] = {}
    for each in error.errors(include_url=False):
        fault = _fault(each, content)
        faults.setdefault(fault.place, fault)
    # A value that may be of several kinds is wrong as each of them: what looked deepest into it knows most.
    deepest = [f for f in faults.values() if not any(_within(other, f.place) for other in faults)]
    misspelt = [f for f in deepest if f.kind == "extra_forbidden"]
    for fault in misspelt:
        *parent, name = fault.place
        lacking = [str(f.place[-1]) for f in deepest if f.kind == "missing" and [*f.place[:-1]] == parent]
        if near := get_close_matches(str(name), lacking, 1):
            said = f"there is no such field; did you mean {near[0]}, which is missing?"
            return Fault(fault.place, fault.names, said, fault.error), len(deepest) - 2
    for fault in misspelt:
        known = list(_known(kind, fault.error["loc"][:-1]))
        near = get_close_matches(str(fault.place[-1]), known, 1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
        return Fault(fault.place, fault.names, f"there is no such field; {hint}", fault.error), len(
            deepest
        ) - 1
    return deepest[0], len(deepest) - 1


def _within(place: tuple[str | int, ...], outer: tuple[str | int, ...]) -> bool:
    return len(place) > len(outer) and place[: len(outer)] == outer


def _fault(error: Any, content: Any) -> Fault:
    """A fault at its place in the content, without what pydantic calls the kinds that a value may be of."""
    place: list[str | int] = []
    names: list[str] = []
    node, last = content, len(error["loc"]) - 1
    for number, part in enumerate(error["loc"]):
        if isinstance(node, list | tuple) and isinstance(part, int):
            node = node[part] if part < len(node) else None
            name = node.get("name") if isinstance(node, dict) else None
            names.append(name if isinstance(name, str) and name else f"entry {part + 1}")
        elif isinstance(node, dict) and (part in node or (number == last and error["type"] == "missing")):
            node = node.get(part)
            names.append(str(part))
        else:
            continue
        place.append(part)
    if error["type"].startswith("union_tag"):
        tag = error["ctx"]["discriminator"].strip("'")
        place, names = [*place, tag], [*names, tag]
    in_s = "; it is in seconds" if names and names[-1].endswith("_s") and error["type"] in _BEYOND else ""
    return Fault(tuple(place), tuple(names), _words(error) + in_s, error)


def _words(error: Any) -> str:
    kind, given = error["type"], error["input"]
    if kind in ("missing", "union_tag_not_found"):
        return "is missing"
    if kind == "union_tag_invalid":
        return f"there is no {error['ctx']['tag']!r}; there are {error['ctx']['expected_tags']}"
    if kind == "too_short":
        return f"should hold {error['ctx']['min_length']} or more entries, not {len(given)}"
    if kind == "model_type":
        return f"should hold fields (name: value), not {_short(given)}"
    said = error["msg"].removeprefix("Value error, ")
    if not said.startswith("Input should"):
        return said
    said = said.removeprefix("Input ").partition(_UNPARSED)[0]
    said = _PLAIN.get(said, said)
    return f"{said}, not {_short(given)}"


def _short(given: Any) -> str:
    if given is None:
        return "nothing"
    kinds = {dict: "fields", list: "a list", tuple: "a list"}
    return next((word for kind, word in kinds.items() if isinstance(given, kind)), None) or repr(given)


def _known(kind: type[BaseModel], place: tuple[str | int, ...]) -> Iterator[str]:
    """The names of the fields that there may be at a place, as pydantic says where it is."""
    kinds = [kind]
    for part in place:
        inside = [k.model_fields[part].annotation for k in kinds if part in k.model_fields]
        if inside:
            kinds = [found for annotation in inside for found in _models(annotation)]
        else:  # an entry's number, or which of several kinds it was taken for
            kinds = [k for k in kinds if _is_called(k, part)] or kinds
    names = {name: None for k in kinds for name, field in k.model_fields.items() if not field.exclude}
    return iter(names)


def _is_called(kind: type[BaseModel], tag: str | int) -> bool:
    return kind.__name__ == tag or any(tag in get_args(f.annotation) for f in kind.model_fields.values())


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models(part)
