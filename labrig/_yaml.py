"""YAML files of people's own, read with one-line complaints that name the file and the line."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from labrig._errors import LabrigError


class SaidError(yaml.MarkedYAMLError):
    """What plain YAML would take without a word, and not as it was meant; its `problem` says it for people."""


class _Loader(yaml.SafeLoader):
    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        first: dict[tuple[str, str], yaml.Mark] = {}
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            mark = first.setdefault((key.tag, key.value), key.start_mark)
            if mark is not key.start_mark:
                earlier = "" if mark.line == key.start_mark.line else f" (first in line {mark.line + 1})"
                problem = f"{key.value} is given twice{earlier}; keep one of them"
                raise SaidError(problem=problem, problem_mark=key.start_mark)
        return node

    def construct_number(self, node: yaml.ScalarNode) -> Any:
        kind = node.tag.rpartition(":")[2]
        value = super().construct_yaml_int(node) if kind == "int" else super().construct_yaml_float(node)
        text = node.value.lstrip("+-")
        if ":" in text or (kind == "int" and len(text) > 1 and text[0] == "0" and text[1] in "01234567_"):
            meant = "" if ":" in text else f"write {text.lstrip('0_') or '0'}, or "
            problem = f"{node.value} is {value:g} to YAML: {meant}'{node.value}' in quotes, if it is a name"
            raise SaidError(problem=problem, problem_mark=node.start_mark)
        return value


for _tag in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_tag}", _Loader.construct_number)


def load_yaml(text: str) -> Any:
    """The content of YAML in which no key stands twice; raises `yaml.YAMLError` (`SaidError` for such a key,
    and for a number that YAML reads as another: 060 is 48 to it, 1:30 is 90)."""
    try:
        return yaml.load(text, Loader=_Loader)
    except RecursionError:
        raise yaml.MarkedYAMLError(problem="it is nested too deeply") from None


def read_yaml(path: Path, what: str, hint: str = "", begins: str = "name: ...") -> dict[str, Any]:
    """The content of a YAML file that should hold `what` (a rig, a shell, ...): names and their values.

    Raises `LabrigError` if there is no such file (with the `hint` behind it), or if it is not YAML, or names a key
    twice, or is no mapping (with how such a file `begins`).
    """
    try:
        content = load_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise LabrigError(f"cannot read the {what} {path}: {error.strerror or error}{hint}") from None
    except UnicodeDecodeError:
        raise LabrigError(f"{path} is not a text file; a {what} is YAML") from None
    except yaml.YAMLError as error:
        raise LabrigError(f"{path}{_fault(error)}") from None
    if not isinstance(content, dict):
        raise LabrigError(f"{path} is not a {what}: it should begin with `{begins}`")
    return content


def line_of(path: Path, place: Sequence[str | int]) -> int | None:
    """The line of a YAML file at which a place in it stands, or as much of it as there is; None for the file itself.

    A place is the keys and the numbers of entries that lead there.
    """
    try:
        node = yaml.compose(path.read_text(encoding="utf-8"), Loader=yaml.SafeLoader)
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return None
    line = None
    for part in place:
        if isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
            node = mark = node.value[part]
        elif isinstance(node, yaml.MappingNode):
            found = [(key, value) for key, value in node.value if key.value == str(part)]
            if not found:
                break
            mark, node = found[-1]
        else:
            break
        line = mark.start_mark.line + 1
    return line


def _fault(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    where = f", line {mark.line + 1}" if mark is not None else ""
    problem = str(getattr(error, "problem", None) or getattr(error, "reason", None) or "unreadable")
    if isinstance(error, SaidError):
        return f"{where}: {problem}"
    tab = "; indent with spaces, not with a tab" if "'\\t'" in problem else ""
    return f"{where}: is not YAML ({problem}{tab})"
