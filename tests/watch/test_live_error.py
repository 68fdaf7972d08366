"""The process that holds a model against a run while it goes on."""

from contextlib import closing
from typing import Any

from labrig._running import Reception, notes
from labrig.workbench._live_error import Watched


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
