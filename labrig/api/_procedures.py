"""Finds procedures, and turns their parameters into options of `labrig run`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_origin

from labrig._errors import LabrigError
from labrig._near import meant
from labrig._own_code import load_module
from labrig._yaml import read_yaml

if TYPE_CHECKING:
    from labrig.campaign import Procedure


def shipped() -> dict[str, "type[Procedure]"]:
    """The procedures that labrig brings, by name."""
    import labrig_procedures

    kinds = [getattr(labrig_procedures, name) for name in labrig_procedures.__all__]
    return {kind.procedure_name(): kind for kind in kinds}


def find_procedure(text: str) -> "type[Procedure]":
    """The procedure that a name, `FILE.py` or `FILE.py:CLASS` means; raises `LabrigError` if there is none."""
    file, _, wanted = text.rpartition(":") if ".py:" in text else (text, "", "")
    if not file.endswith(".py"):
        known = shipped()
        if text not in known:
            raise LabrigError(
                f"there is no procedure {text!r}; there are {', '.join(known)}, or name a file (my_procedure.py)"
                + _beside(text, known)
            )
        return known[text]
    return _from_file(Path(file), wanted)


def _beside(text: str, known: "dict[str, type[Procedure]]") -> str:
    """The file that was probably meant, or else the name."""
    for name in (f"{text}.py", f"{text}.yaml"):
        if Path(name).is_file():
            return f"; did you mean {name}?"
    return meant(text, known)


def read_procedure(text: str, arguments: list[str]) -> "Procedure":
    """The procedure that `labrig run TEXT ARGUMENTS` means: by name, FILE.py, or a YAML file with its parameters.

    Raises `LabrigError` for what does not exist or does not fit.
    """
    if not text.endswith((".yaml", ".yml")):
        return parse_parameters(find_procedure(text), arguments)
    path = Path(text)
    content = read_yaml(path, "procedure", begins="procedure: programme")
    if not isinstance(content.get("procedure"), str):
        raise LabrigError(f"{path}: a procedure file begins with its name, such as `procedure: programme`")
    values = {key: value for key, value in content.items() if key != "procedure"}
    return parse_parameters(find_procedure(content["procedure"]), arguments, values, str(path))


def _from_file(path: Path, wanted: str) -> "type[Procedure]":
    from labrig.campaign import Procedure

    module = load_module(path, f"labrig_procedure_{path.stem}")
    kinds = {
        name: kind
        for name, kind in vars(module).items()
        if isinstance(kind, type) and issubclass(kind, Procedure) and kind.__module__ == module.__name__
    }
    if wanted:
        if wanted not in kinds:
            raise LabrigError(f"{path} has no procedure {wanted}; it has {', '.join(kinds) or 'none'}")
        return kinds[wanted]
    if not kinds:
        raise LabrigError(
            f"{path} has no procedure: write a class that derives from labrig.campaign.Procedure"
        )
    if len(kinds) > 1:
        raise LabrigError(
            f"{path} has several procedures; say which: {', '.join(f'{path}:{name}' for name in kinds)}"
        )
    return next(iter(kinds.values()))


def parse_parameters(
    kind: "type[Procedure]", arguments: list[str], values: dict[str, Any] | None = None, file: str = ""
) -> "Procedure":
    """The procedure with the parameters that `--name value` options give; raises `LabrigError` for a bad one.

    `values` are those of a `file`, which options override.
    """
    from pydantic import ValidationError

    from labrig._fields import check_fields, first_fault, validated

    given: dict[str, Any] = {}
    rest = list(arguments)
    while rest:
        name, value = _take(kind, rest)
        given[name] = value
    content = {**(values or {}), **given}
    try:
        return validated(kind, content)
    except ValidationError as error:
        fault, _ = first_fault(error, kind, content)
        if file and not set(fault.place[:1]) & set(given):
            return check_fields(kind, content, file, Path(file))
        option, *inside = fault.names or ("",)
        where = [kind.procedure_name(), *([_option(option)] if option else []), *inside]
        raise LabrigError(": ".join([*where, fault.what])) from None


def _option(field: str) -> str:
    return f"--{field.replace('_', '-')}"


def _take(kind: "type[Procedure]", rest: list[str]) -> tuple[str, Any]:
    """Take one option and its value off the front of the arguments."""
    token = rest.pop(0)
    option, equals, value = token.partition("=")
    name = option.removeprefix("--").replace("-", "_")
    field, negated = kind.model_fields.get(name), kind.model_fields.get(name.removeprefix("no_"))
    off = field is None and negated is not None and negated.annotation is bool
    if off and option.startswith("--") and not equals:
        return name.removeprefix("no_"), False
    if field is None or not option.startswith("--"):
        options = [_option(field) for field in kind.model_fields]
        raise LabrigError(
            f"{kind.procedure_name()} has no option {option}; it has {', '.join(options) or 'none'}"
            + meant(option, options)
        )
    if field.annotation is bool and not equals:
        return name, True
    if not equals:
        if not rest:
            raise LabrigError(f"{kind.procedure_name()}: {option} needs a value")
        value = rest.pop(0)
    if get_origin(field.annotation) in (tuple, list):
        return name, [part.strip() for part in value.split(",") if part.strip()]
    return name, value


def parameters_help(kind: "type[Procedure]") -> str:
    """What `labrig run NAME --help` says of a procedure."""
    lines = [f"{kind.procedure_name()}: {' '.join((kind.__doc__ or '').split())}", "", "Parameters:"]
    rows = []
    for name, field in kind.model_fields.items():
        default = field.get_default(call_default_factory=True)
        shown = default
        if isinstance(default, tuple):
            shown = ",".join(f"{item:g}" for item in default if isinstance(item, int | float))
        value = "required" if field.is_required() else f"[{shown}]" if shown != "" else ""
        rows.append((_option(name), _choices(field.annotation), value, field.description or ""))
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    for row in rows:
        padded = "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=False))
        lines.append(f"  {padded}  {row[3]}".rstrip())
    return "\n".join(lines)


def _choices(annotation: Any) -> str:
    from typing import Literal, get_args

    if get_origin(annotation) is Literal:
        return "|".join(str(choice) for choice in get_args(annotation))
    if get_origin(annotation) in (tuple, list):
        return "A,B,..."
    return {int: "INTEGER", float: "NUMBER", str: "TEXT", bool: ""}.get(annotation, "VALUE")


def source_of(kind: "type[Procedure]") -> str:
    """What `find_procedure` needs to find this procedure again."""
    module = sys.modules.get(kind.__module__)
    if module is None or not kind.__module__.startswith("labrig_procedure_"):
        return kind.procedure_name()
    return f"{Path(str(module.__file__)).resolve()}:{kind.__name__}"
