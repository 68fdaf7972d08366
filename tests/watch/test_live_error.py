"""The processes that hold a model against a run that goes on."""

import io
from pathlib import Path
from typing import Any

import pytest

from labrig.workbench import _live
from labrig.workbench._live import Errors


class Ended:
    """A process that said these lines and ended."""

    def __init__(self, lines: list[str], code: int) -> None:
        self.stdin, self.stdout, self.code = None, io.StringIO("".join(lines)), code

    def poll(self) -> int:
        return self.code

    def wait(self, timeout: float | None = None) -> int:
        return self.code


@pytest.mark.parametrize(
    ("said", "code", "begun"), [([], 0, 3), (['{"error": "the rig has no markers"}'], 1, 1)]
)
def test_a_process_that_could_not_reach_the_run_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: list[str], code: int, begun: int
) -> None:
    """What lost a run that goes on is begun again when it is asked for; what said why it cannot be is not."""
    started: list[Any] = []

    def start(*_: Any, **__: Any) -> Ended:
        started.append(Ended(said, code))
        return started[-1]

    monkeypatch.setattr(_live.subprocess, "Popen", start)
    model = tmp_path / "model.yaml"
    model.write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    errors = Errors()
    for _ in range(3):
        errors.of(tmp_path, model)
    assert len(started) == begun
