"""Links that lead out of the workbench's folder, and makers of one model at once."""

import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_a_run_behind_a_link_out_says_so_in_its_row(ask: Any, bench: Any, make_run: Any) -> None:
    """It is listed, and its row says why it cannot be opened, and what can be done; nothing else of it is shown."""
    folder = bench.desk.folder
    inside = make_run("inside", captures=10)
    shutil.copytree(folder / inside, folder.parent / "elsewhere" / "away")
    (folder / "linked").symlink_to(folder.parent / "elsewhere" / "away")
    (folder / "beside").symlink_to(folder / inside)
    said = ask("/api/runs")[1]
    rows = {row[0]: dict(zip(said["columns"], row, strict=True)) for row in said["rows"]}
    assert rows["linked"]["state"].startswith("unreadable: a link that leads out of this folder")
    assert rows["linked"]["captures"] is None
    assert rows["beside"]["captures"] == rows["inside"]["captures"] == 10
    assert ask("/api/run?run=linked")[0] == 400


def test_of_two_that_make_one_model_one_does(ask: Any, bench: Any) -> None:
    """Whoever comes second, even at the same moment, is told that the name is taken."""
    with ThreadPoolExecutor(8) as several:
        made = [
            each[0]
            for each in several.map(
                lambda _: ask("/api/model", {"base": "straight", "name": "m.yaml"}), range(8)
            )
        ]
    assert sorted(made) == [200] + [400] * 7
    assert ask("/api/model", {"base": "parabola", "name": "m.yaml"})[1]["error"] == (
        "m.yaml: exists already; choose another name"
    )
