"""Which results are shown of a run: those of all that was measured, by the model as it is."""

import json
import os
from typing import Any

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
