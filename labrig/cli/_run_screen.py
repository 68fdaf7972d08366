"""What a person sees of a run in the terminal, and the keys that pause it."""

import sys
import threading
import time
from types import TracebackType
from typing import Any, Self

from labrig.campaign import Control, Observer, Progress

_KEYS_S = 0.2
_LINE_S = 60.0
_TOLD = ("paused", "going on", "resumed", "diagnosis")


class Screen(Observer):
    """A progress bar on standard error, or plain lines where that is no terminal; warnings as they come."""

    def __init__(self, control: Control) -> None:
        from rich.progress import BarColumn, SpinnerColumn, TextColumn
        from rich.progress import Progress as Bar

        from labrig.cli._console import new_console

        self.console = new_console(stderr=True, highlight=False)
        self.control = control
        self._bar = Bar(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(30),
            TextColumn("{task.fields[text]}"),
            console=self.console,
            transient=True,
        )
        self._task = self._bar.add_task("run", total=None, text="")
        self._keys = _Keys(control)
        self._last_line = time.monotonic()

    def __enter__(self) -> Self:
        if self.console.is_terminal:
            self._bar.start()
            self._keys.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._keys.stop()
        if self.console.is_terminal:
            self._bar.stop()

    def progress(self, progress: Progress) -> None:
        """Redraw the bar."""
        of = f"/{progress.captures}" if progress.captures is not None else ""
        remaining = "" if progress.remaining_s is None else f", {duration_text(progress.remaining_s)} left"
        state = "paused (vented; p goes on)" if progress.paused else progress.step
        text = f"{progress.captures_done}{of} captures, {state}{remaining}"
        if not self.console.is_terminal:
            self._line(text)
        self._bar.update(self._task, total=progress.steps, completed=progress.steps_done, text=text)

    def _line(self, text: str) -> None:
        """Where nobody watches a bar, a line a minute."""
        if time.monotonic() - self._last_line >= _LINE_S:
            self._last_line = time.monotonic()
            self.console.print(f"labrig: {text}", markup=False)

    def event(self, time_s: float, text: str, level: str) -> None:
        """Warnings and errors stay on the screen."""
        if level in ("WARNING", "FATAL") or text.startswith(_TOLD):
            self.console.print(f"labrig: {text}", markup=False)


def duration_text(duration_s: float) -> str:
    """A duration as a person says it: 45 s, 12 min 05 s, 3 h 20 min."""
    seconds = round(max(0.0, duration_s))
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60:02d} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60:02d} min"


class _Keys:
    """Reads single keys while a run goes on: p pauses and goes on."""

    def __init__(self, control: Control) -> None:
        self._control = control
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin to listen, if there is a keyboard."""
        if not sys.stdin.isatty():
            return
        work = self._windows if sys.platform == "win32" else self._posix
        self._thread = threading.Thread(target=work, name="labrig keys", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop listening and give the terminal back as it was."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(1.0)

    def _press(self, key: str) -> None:
        if key in ("p", "P", " "):
            self._control.toggle()

    def _posix(self) -> None:  # POSIX only; `_windows` is its equivalent
        import select
        import termios
        import tty

        number = sys.stdin.fileno()
        before = termios.tcgetattr(number)
        try:
            tty.setcbreak(number)  # Ctrl-C stays a signal
            while not self._stop.is_set():
                if select.select([number], [], [], _KEYS_S)[0]:
                    self._press(sys.stdin.read(1))
        finally:
            termios.tcsetattr(number, termios.TCSADRAIN, before)

    def _windows(self) -> None:
        import importlib

        msvcrt: Any = importlib.import_module("msvcrt")
        while not self._stop.wait(_KEYS_S):
            while msvcrt.kbhit():
                self._press(msvcrt.getwch())
