"""Which results are shown of a run: those of all that was measured, by the model as it is."""

import json
import os
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
