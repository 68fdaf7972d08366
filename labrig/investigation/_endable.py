"""Lets other processes on this computer end an investigation, whatever it is at, also between two of its runs."""

import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from labrig._errors import LabrigError
from labrig._running import Reception
from labrig.campaign import Control, Interrupted
from labrig.rig import RigConfig, link_of
from labrig.run_contents import Asking, Facts


class Endable:
    """An investigation that can be ended: its run vents and ends, and no other begins. A context manager.

    A request names what to `do`: `status`, which says whether a run goes on, or `end` (with `why`). A vent of the rig
    from outside asks for the end as well: chambers that somebody has just vented are not filled by the next run.
    """

    def __init__(self, config: RigConfig, folder: Path) -> None:
        self._facts: Facts = {
            "folder": str(folder.resolve()),
            "rig": config.name,
            "rig_folder": str(config.folder.resolve()),
            "link": link_of(config),
        }
        self._lock = threading.Lock()
        self._why: str | None = None
        self._control: Control | None = None
        self._reception: Reception | None = None

    def __enter__(self) -> Self:
        with contextlib.suppress(OSError):  # nobody can ask then; Ctrl-C still ends it
            self._reception = Reception("investigation", self._facts, self._answer)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._reception is not None:
            self._reception.close()

    @contextlib.contextmanager
    def measuring(self, control: Control) -> Iterator[None]:
        """A run goes on with this control; raises `Interrupted`, before it begins, where the end was asked for."""
        with self._lock:
            self.check()
            self._control = control
        try:
            yield
        finally:
            with self._lock:
                self._control = None

    def check(self) -> None:
        """Raise `Interrupted` where somebody asked for the end, between two runs."""
        if self._why is not None:
            raise Interrupted(f"stopped by {self._why}, between two runs; the chambers are vented")

    def _answer(self, request: Asking) -> Any:
        do = request.get("do")
        with self._lock:
            if do == "end":
                self._why = self._why or str(request.get("why") or "another process on this computer")
                if self._control is not None:
                    self._control.end(self._why)
            elif do != "status":
                raise LabrigError(f"an investigation is not asked to {do!r}; there are status, end")
            return {"measuring": self._control is not None, "ended": self._why}
