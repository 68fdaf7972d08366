"""labrig: run a soft-robotics rig, log its campaigns, and find the physics its model is missing.

The public names are imported when they are first used, so that ``labrig --help`` stays quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError

if TYPE_CHECKING:
    from labrig.log import open_run

__version__ = "0.1.0"
__all__ = ["LabrigError", "__version__", "open_run"]

_LAZY = {"open_run": "labrig.log"}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'labrig' has no attribute {name!r}")
