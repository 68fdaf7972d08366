"""YAML files of people's own, read with one-line complaints."""

from pathlib import Path
from typing import Any

import yaml

from labrig._errors import LabrigError


def read_yaml(path: Path, what: str, hint: str = "", begins: str = "name: ...") -> dict[str, Any]:
    """The content of a YAML file that should hold `what` (a rig, a shell, ...): names and their values.

    Raises `LabrigError` if there is no such file (with the `hint` behind it), or if it is not YAML, or no mapping (with
    how such a file `begins`).
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise LabrigError(f"cannot read the {what} {path}: {error.strerror or error}{hint}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise LabrigError(f"{path} is not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(content, dict):
        raise LabrigError(f"{path} is not a {what}: it should begin with `{begins}`")
    return content
