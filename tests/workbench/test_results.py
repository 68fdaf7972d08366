"""Which results are shown of a run: those of all that was measured, by the model as it is."""

import json
import os
import shutil
import time
from typing import Any

import pytest

from labrig._running import Reception
from labrig.log import run_id
from labrig.workbench._run import Pair, pair_of


def _pair(bench: Any, run: str) -> Pair:
    return pair_of(bench.desk, {"run": run, "model": "model.yaml"})


def _compared(bench: Any, run: str) -> None:
    place = bench.desk.folder / run / "model"
    place.mkdir(exist_ok=True)
    about = {"runs": [{"run": run, "id": run_id(bench.desk.folder / run)}], "model": "model.yaml"}
    (place / "compare.json").write_text(json.dumps(about), encoding="utf-8")


def test_a_run_that_was_gone_on_with_is_looked_at_anew(bench: Any, make_run: Any) -> None:
    """What was found of its first captures is not taken for what all of them say; while it goes on, it is shown."""
    run = make_run()
    _compared(bench, run)
    assert _pair(bench, run).has("compare.json")
    log = bench.desk.folder / run / "log.000.mcap"
    after_ns = log.with_name("model").joinpath("compare.json").stat().st_mtime_ns + 10**9
    os.utime(log, ns=(after_ns, after_ns))
    assert not _pair(bench, run).has("compare.json")
    going = Reception("run", {"folder": str(log.parent)}, lambda asked: None)
    try:
        assert _pair(bench, run).has("compare.json")
    finally:
        going.close()


def test_a_run_that_is_measured_now_is_not_called_killed(bench: Any, make_run: Any, ask: Any) -> None:
    """While a process measures a run, it goes on: in the list, and above what is shown of it."""
    run = make_run()

    def told() -> tuple[str, list[str]]:
        rows = ask("/api/runs")[1]
        return rows["rows"][0][rows["columns"].index("state")], ask(f"/api/run?run={run}")[1]["facts"]

    before, facts = told()
    assert before != "goes on"
    assert "goes on" not in facts
    going = Reception("run", {"folder": str(bench.desk.folder / run)}, lambda asked: None)
    try:
        state, facts = told()
        assert state == "goes on"
        assert "goes on" in facts
    finally:
        going.close()


def test_what_is_not_diagnosed_yet_says_where_it_is(ask: Any, make_run: Any) -> None:
    """A link to Add before a diagnosis names no file, but what to do first."""
    status, said = ask(f"/api/add/effects?run={make_run()}&model=model.yaml")
    assert (status, said["error"]) == (
        400,
        "run is not diagnosed with model.yaml yet: find the missing effect in Which first",
    )


def test_a_function_of_ones_own_that_was_edited_is_another_model(bench: Any, make_run: Any) -> None:
    """What was found with the function of before is not what is found with it now, though model.yaml is the same."""
    run, folder = make_run(), bench.desk.folder
    own = folder / "own.py"
    own.write_text("def predict(u):\n    return u\n", encoding="utf-8")
    (folder / "model.yaml").write_text(
        "base: {kind: python, file: own.py, function: predict}\n", encoding="utf-8"
    )
    _compared(bench, run)
    assert _pair(bench, run).has("compare.json")
    after_ns = own.stat().st_mtime_ns + 10**10
    os.utime(own, ns=(after_ns, after_ns))
    assert not _pair(bench, run).has("compare.json")


@pytest.mark.parametrize("place", [".", "models"])
def test_an_effect_of_ones_own_that_was_edited_is_another_effect(
    bench: Any, make_run: Any, place: str
) -> None:
    """What was found with the file of before, beside the model or in the desk's folder, is not what is found now."""
    run, folder = make_run(), bench.desk.folder
    (folder / place).mkdir(exist_ok=True)
    (folder / "model.yaml").rename(folder / place / "model.yaml")
    pair = pair_of(bench.desk, {"run": run, "model": f"{place}/model.yaml"})
    written_ns = time.time_ns() + 10**9
    assert pair.is_older_than(written_ns)
    for where in {".", place}:
        own = folder / where / "effects" / "mine.py"
        own.parent.mkdir()
        own.write_text("", encoding="utf-8")
        assert pair.is_older_than(written_ns)
        os.utime(own, ns=(written_ns + 1, written_ns + 1))
        assert not pair.is_older_than(written_ns)
        own.unlink()


def test_a_proposal_for_a_model_that_was_edited_is_none(ask: Any, bench: Any, make_run: Any) -> None:
    """A programme that would settle what the model of before left open is not offered for the one of now."""
    run = make_run()
    found = bench.desk.folder / run / "model" / "next" / "next.json"
    found.parent.mkdir(parents=True)
    found.write_text(json.dumps({"minutes": 3.0}), encoding="utf-8")
    query = f"/api/next?run={run}&model=model.yaml"
    assert ask(query)[1]["found"] == {"minutes": 3.0}
    after_ns = found.stat().st_mtime_ns + 10**9
    os.utime(bench.desk.folder / "model.yaml", ns=(after_ns, after_ns))
    assert ask(query)[1]["found"] is None


def test_what_cannot_be_kept_is_shown_all_the_same(ask: Any, bench: Any, make_run: Any) -> None:
    """A folder that is only read, or a disk that is full, keeps no view: it is made for whoever asks."""
    run = make_run()
    _compared(bench, run)
    own = bench.desk.folder / ".workbench"
    own.mkdir(exist_ok=True)
    (own / "views").write_text("a file where the folder would be", encoding="utf-8")
    status, said = ask(f"/api/compare?run={run}&model=model.yaml")
    assert (status, said["compared"]) == (200, True)


def test_of_many_captures_it_is_said_how_many_are_not_shown(
    bench: Any, make_run: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A list of some would pass for one of all."""
    from labrig.workbench import _shapes
    from labrig.workbench._compare import view

    run = make_run(captures=70)
    monkeypatch.setattr(_shapes, "MOST", 60)
    captures = json.loads(view(_pair(bench, run).key))["captures"]
    assert captures["of"] == 70
    assert len(captures["names"]) <= 60


def test_a_run_that_lies_deep_says_its_rig_and_date(bench: Any, make_run: Any, ask: Any) -> None:
    """Below an investigation in a folder of its own it is deeper than the list goes: its page knows it all the same."""
    run = make_run(captures=4)
    shutil.copytree(bench.desk.folder / run, bench.desk.folder / "some/where/deep")
    near, deep = (ask(f"/api/run?run={name}")[1]["facts"] for name in (run, "some/where/deep"))
    assert near == deep != []
