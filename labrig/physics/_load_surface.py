"""The base simulator of a rig, whichever kind it is."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig.physics._rig_file import has_shell
from labrig.physics._surface import Surface, reduced_surface

if TYPE_CHECKING:
    from labrig.physics._shell_surface import ShellSurface


def load_surface(
    rig: dict[str, Any], folder: Path | None = None, parameters: Mapping[str, float] | None = None
) -> "Surface | ShellSurface":
    """The base simulator of a rig, from the content of its rig.yaml, which lies in `folder`.

    That is the shell as the model knows it (see `rig_shell`), unless `simulated: {surface: ...}` names a reduced model
    (see `reduced_surface`). A shell is taken at other `parameters` where they are given; its surface is made once: what
    it has solved is there for the next who asks. Raises `LabrigError` as they do.
    """
    if not has_shell(rig):
        if parameters:
            raise LabrigError(
                f"rig: a reduced surface has no parameters: {', '.join(parameters)} cannot be set"
            )
        return reduced_surface(rig)
    from labrig.physics._shell_rig import rig_shell  # these wait for a compiler
    from labrig.physics._shell_surface import surface_of

    content = json.dumps(rig_shell(rig, folder).changed(None, **(parameters or {})).content())
    return surface_of(content, tuple(str(marker) for marker in rig.get("markers") or []))
