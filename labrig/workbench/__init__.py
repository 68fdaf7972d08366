"""The workbench: compare, see where a model fails, learn which effect, add it, watch the error fall, in a browser.

A small server on this computer. What its pages know lies in files, and what they do is a labrig command.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from labrig.workbench._desk import Desk, open_desk
    from labrig.workbench._server import Running, application, start

_LAZY = {
    "Desk": "_desk",
    "Running": "_server",
    "application": "_server",
    "open_desk": "_desk",
    "start": "_server",
}

__all__ = ["Desk", "Running", "application", "open_desk", "start"]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(f"labrig.workbench.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'labrig.workbench' has no attribute {name!r}")
