"""The processes that hold a model against a run that goes on."""

import io
import sys
from contextlib import closing
from functools import partialmethod
from pathlib import Path
from typing import Any

import pytest

from labrig._running import Note, Reception, notes
from labrig.workbench import _live
from labrig.workbench._live import Errors
from labrig.workbench._live_error import Watched, main


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


def test_a_run_that_is_too_busy_to_answer_may_be_asked_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A computer that was busy for a while is no reason to say for good that nothing is known of a run's error."""
    model = tmp_path / "model.yaml"
    model.write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["", str(tmp_path / "run"), str(model)])
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    monkeypatch.setattr(Note, "ask", partialmethod(Note.ask, timeout_s=0.0))
    with closing(Reception("run", {"folder": str((tmp_path / "run").resolve())}, lambda _: {})):
        main()  # it ends without an error of its own: with 0
    assert capsys.readouterr().out == ""


def test_a_run_that_opens_its_devices_is_waited_for(tmp_path: Any) -> None:
    """A run knows its chambers before its markers: whoever asks in between waits, and is not told that it has none."""
    told = [{"markers": ["m1"]}, {}, {}]
    facts: Any = {"folder": str(tmp_path / "run")}

    def answer(request: Any) -> Any:
        assert request["do"] == "status"
        return {**facts, "chambers": ["c1"], **told.pop()}

    with closing(Reception("run", facts, answer)):
        [note] = [note for note in notes("run") if note.facts.get("folder") == facts["folder"]]
        assert Watched(note).about.get("markers") == ["m1"]
    assert not told
