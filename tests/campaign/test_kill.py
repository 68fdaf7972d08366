"""The short version of benchmarks/kill.py: runs that are killed leave no pressure and lose nothing."""

import importlib.util
import random
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytestmark = [
    pytest.mark.skipif(
        sys.platform == "win32", reason="sends the signals of POSIX; test_guard.py covers Windows"
    ),
    pytest.mark.slow,
]
PATH = Path(__file__).parents[2] / "benchmarks" / "kill.py"


@pytest.fixture(scope="module")
def kill() -> Any:
    """The benchmark as a module."""
    spec = importlib.util.spec_from_file_location("kill", PATH)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["kill"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def bench(kill: Any, tmp_path: Path) -> Iterator[Any]:
    """A simulated board that holds its pressure for ever."""
    bench = kill.Bench(tmp_path)
    yield bench
    bench.close()


@pytest.mark.parametrize("how", ["SIGKILL", "SIGSTOP", "SIGTERM", "SIGHUP"])
def test_a_killed_run_is_vented_and_keeps_its_captures(
    kill: Any, bench: Any, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    """Over the wire protocol, from outside: ambient within the stated time, every reported capture in the log."""
    monkeypatch.setattr(kill, "SIGNALS", {how: 1.0})
    chance = random.Random(sum(map(ord, how)))
    outcome = bench.kill_one(0, chance)
    assert outcome.signal == how
    assert outcome.vented_s is not None
    assert outcome.kept >= outcome.reported
