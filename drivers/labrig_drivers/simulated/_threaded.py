"""What the twins that serve have in common: a thread of their own, until they are stopped."""

import threading
from collections.abc import Callable
from typing import Any


class Threaded:
    """Works in a thread between `_begin` and `stop`; the thread looks at `_stopping` and ends by itself."""

    def __init__(self) -> None:
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    def _begin(self, name: str, target: Callable[..., Any], *arguments: Any) -> None:
        self._stopping.clear()
        self._thread = threading.Thread(target=target, args=arguments, name=name, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and close what it has open; does nothing when it is not running."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
