"""Ctrl-C and Ctrl-Break during a run as Python on Windows has them: no SIGHUP, no SIGUSR1, SIGBREAK in their place."""

import enum
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from labrig.campaign import Actuate, Interrupted, Procedure, Record, RigInfo, Settle, Steps, _signals, run


class Signals(enum.IntEnum):
    """The numbers of Windows."""

    SIGINT = 2
    SIGTERM = 15
    SIGBREAK = 21


class Round(Procedure):
    """One capture under pressure."""

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, wait, record."""
        yield Actuate((40.0,) * len(rig.channels))
        yield Settle(3.0)
        yield Record(1.0)


@pytest.fixture
def handlers(monkeypatch: pytest.MonkeyPatch) -> dict[int, Callable[..., None]]:
    """What is installed as handlers, where the signals are those of Windows."""
    installed: dict[int, Callable[..., None]] = {}

    def install(number: int, handler: Any) -> Any:
        before = installed.get(number)
        installed[number] = handler
        return before

    windows = SimpleNamespace(Signals=Signals, signal=install, **Signals.__members__)
    monkeypatch.setattr(_signals, "signal", windows)
    return installed


@pytest.mark.parametrize(("number", "word"), [(Signals.SIGINT, "Ctrl-C"), (Signals.SIGBREAK, "Ctrl-Break")])
def test_a_key_that_ends_a_run_vents(
    make_rig: Any, handlers: dict[int, Callable[..., None]], tmp_path: Path, number: int, word: str
) -> None:
    """Pressed while a capture is under pressure, the run ends vented, and says which key it was."""
    fake = make_rig()

    def press() -> None:
        if np.abs(fake.pressure_kpa).max() > 20 and (handler := handlers.get(number)):
            handler(int(number), None)

    fake.clock.on_sleep = press
    with pytest.raises(Interrupted, match=f"stopped by {word} after "):
        run(Round(), fake.rig, tmp_path / "run", fake.clock)
    assert np.abs(fake.pressure_kpa).max() <= 0.5
    assert set(handlers) == {2, 15, 21}
