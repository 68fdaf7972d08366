"""What is said where a package is missing that labrig needs for one task only."""

from importlib.util import find_spec

from labrig._errors import LabrigError


def missing(task: str, extra: str) -> LabrigError:
    """The error of a task whose packages the `extra` of pyproject.toml brings."""
    return LabrigError(
        f"{task} needs packages that are not installed: go to the folder of labrig's pyproject.toml "
        f"and type: pip install '.[{extra}]'"
    )


def lacking(package: str, task: str, extra: str) -> LabrigError | None:
    """The error of a task where a `package` of the `extra` is not installed; None where it is."""
    return missing(task, extra) if find_spec(package) is None else None
