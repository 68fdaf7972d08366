"""Where commands print: as it stands, with no emoji for what stands between colons (`sixth:confounded:1` is a key)."""

from typing import Any

from rich.console import Console


def new_console(**settings: Any) -> Console:
    """A console with rich's settings, but for emoji."""
    return Console(emoji=False, **settings)
