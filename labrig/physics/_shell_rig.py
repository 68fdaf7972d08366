"""The shell of a rig: as the model knows it, and as the plant of the simulated rig is."""

from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._yaml import read_yaml
from labrig.physics._rig_file import has_shell, of_rig_file, places_of, read_rig_file
from labrig.physics._shell import Shell, load_shell
from labrig.physics._shell_file import shipped_shells

DEFAULT = "mannequin"
"""The shell of a rig that names neither a shell nor a reduced surface."""


def rig_shell(rig: dict[str, Any], folder: Path | None = None) -> Shell:
    """The shell that `simulated.shell` of a rig's content names (the mannequin), with the rig's chambers and pressures.

    Chambers are the shell's by name where all names are the same, in whatever order; else one after the other. A path
    is relative to `folder`, where the rig's file lies. Raises `LabrigError` for a shell that cannot be read, or whose
    number of chambers is not the rig's.
    """
    source = (rig.get("simulated") or {}).get("shell", DEFAULT)
    if isinstance(source, str) and source not in shipped_shells():
        source = (folder or Path()) / source
    if not isinstance(source, (str, Path, dict)):
        raise LabrigError(
            "rig: simulated.shell: the name of a shell, a file, or the content of one is needed"
        )
    shell = load_shell(source)
    listed = rig.get("chambers")
    if not listed:
        return shell
    if len(listed) != len(shell.chamber_names):
        section = rig.get("simulated") or {}
        other = (
            ""
            if "shell" in section
            else "; name a shell with as many chambers: simulated: {shell: FILE.yaml}"
        )
        raise LabrigError(
            f"rig: chambers: shell '{shell.name}' has {len(shell.chamber_names)}, the rig names {len(listed)}{other}"
        )
    content = shell.content()
    names = [str(wanted["name"] if isinstance(wanted, dict) else wanted) for wanted in listed]
    own = [content["chambers"][k] for k in places_of(names, shell.chamber_names)]
    for chamber, name, wanted in zip(own, names, listed, strict=True):
        chamber["name"] = name
        if isinstance(wanted, dict):
            chamber["max"] = float(wanted.get("max_kpa", 60.0))
    return load_shell({**content, "chambers": own})


def load_model_shell(source: str | Path) -> Shell:
    """The shell of a rig's file, of a shell's file, or of a shipped name.

    Raises `LabrigError` as `load_shell` does, and for a rig with a reduced surface.
    """
    path = Path(source)
    if str(source) in shipped_shells() or not path.is_file():
        return load_shell(source)
    content = read_yaml(path, "rig or shell")
    if not {"pressure", "simulated"} & set(content):
        return load_shell(path)
    if not has_shell(read_rig_file(path)):
        raise LabrigError(
            f"{path}: a rig with a reduced `simulated: {{surface: ...}}`: there is no shell to simulate"
        )
    with of_rig_file(path):
        return rig_shell(read_rig_file(path), path.parent)
