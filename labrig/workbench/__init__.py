"""The workbench: compare, see where a model fails, learn which effect, add it, watch the error fall, in a browser.

A small server on this computer. What its pages know lies in files, and what they do is a labrig command.
"""

from typing import TYPE_CHECKING

from labrig._lazy import lazy

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

__getattr__ = lazy(__name__, _LAZY)
