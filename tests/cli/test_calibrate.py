"""labrig bench calibrate, as a person types it."""

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from labrig.bench._calibrate import UNLEARNT, Said

Run = Callable[..., tuple[int, str, str]]


def test_it_writes_what_was_learnt_and_says_how_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, labrig: Run
) -> None:
    """The file says by which command; the line how much less of a surprise calibrated names are, portions left out."""
    monkeypatch.chdir(tmp_path)

    def drawn(todo: list[tuple[str, int, str]], names: Path, jobs: int, resume: bool) -> Iterator[list[Said]]:
        assert (names, jobs, resume) == (Path("c.names.jsonl"), 1, True)
        assert len(todo) == 20 * len(UNLEARNT)
        for _, seed, half in todo:
            yield [
                Said(half, "creep", 0.999, 0.9, seed % 4 > 0),
                Said(half, "frame", 0.999, 0.9, seed % 4 == 0),
            ]

    monkeypatch.setattr("labrig.bench.run_calibrate", drawn)
    code, out, err = labrig(
        "bench", "calibrate", "-o", "c.json", "--n", 20, "--seed", 7, "--jobs", 1, "--resume"
    )
    assert (code, err) == (0, "")
    many = 20 * len(UNLEARNT)
    said = f"{2 * many} names of {many} campaigns; minus log likelihood of what was there "
    assert said in " ".join(out.split())
    by_evidence, left_out = map(
        float, re.findall(r"there (\d+) by evidence alone, (\d+) with", " ".join(out.split()))[0]
    )
    assert by_evidence == pytest.approx(many * np.log(1000), rel=0.01)  # of each two, one is wrong
    assert left_out < by_evidence / 4
    written = json.loads(Path("c.json").read_text(encoding="utf-8"))
    assert written["how"] == "labrig bench calibrate --n 20 --seed 7"
    assert written["effects"]["creep"] > 0 > written["effects"]["frame"]
