"""Files of lines, to which long runs add."""

import json
from pathlib import Path

import numpy as np

from labrig.bench._lines import adding_lines, read_lines


def test_what_is_added_is_read_again(tmp_path: Path) -> None:
    """Each record is in the file as soon as it is added, in a folder that is made, behind those of an earlier run."""
    path = tmp_path / "new" / "records.jsonl"
    assert read_lines(path) == []
    for k in range(2):
        with adding_lines(path) as add:
            add({"k": k, "size": np.float64(0.5), "none": float("nan")})
            assert read_lines(path)[-1] == {"k": k, "size": 0.5, "none": None}
    assert [one["k"] for one in read_lines(path)] == [0, 1]


def test_a_line_that_was_cut_off_takes_no_other_with_it(tmp_path: Path) -> None:
    """What is added behind it is whole, and what stood before it is read."""
    path = tmp_path / "records.jsonl"
    path.write_text(json.dumps([1]) + '\n[2, "cut', encoding="utf-8")
    with adding_lines(path) as add:
        add([3])
    assert read_lines(path) == [[1], [3]]
