"""What `labrig run` says of parameters that cannot be, of a rig that is too slow, and of a run without a capture."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

import labrig as lab_rig

RIG: dict[str, Any] = {
    "name": "small",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "pressure": {"kind": "simulated"},
    "simulated": {"surface": "membrane", "seed": 0},
}
SKIP = {"follow": {"on_miss": "skip", "repeats": 0, "tolerance_kpa": 1e-6, "tolerance_share": 0.0}}
MINE = """
from labrig.campaign import Procedure, Settle


class Mine(Procedure):
    wait_s: float = 1.0

    def steps(self, rig):
        yield Settle(self.wait_s)
"""

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a simulated rig and a procedure, as the current one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG))
    (tmp_path / "mine.py").write_text(MINE)
    return tmp_path


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("hold", "--durations-s", "-3"), "hold: --durations-s: entry 1: should be greater than 0, not '-3'"),
        (
            ("hold", "--durations-s", "3,nan"),
            "hold: --durations-s: entry 2: should be a finite number, not 'nan'",
        ),
        (("hold", "--durations-s", ","), "hold: --durations-s: should hold 1 or more entries, not 0"),
        (("hold", "--shares", "3"), "hold: --shares: entry 1: should be less than or equal to 1, not '3'"),
        (
            ("mine.py", "--wait-s", "-3"),
            "procedure mine, step 0: Settle(duration_s=-3.0): give a time in s that ends, 0 or more",
        ),
        (
            ("mine.py", "--wait-s", "1e300"),
            "mine: it would take 1.16e+295 days, and a run may take a year at most; give shorter times, "
            "which are in seconds",
        ),
    ],
)
def test_a_time_that_cannot_be_names_where_it_was_given(
    lab: Path, labrig: Run, words: tuple[str, ...], message: str
) -> None:
    """The option where labrig knows it, else the procedure and its step; no run is made."""
    assert labrig("run", *words, "--rig", "rig.yaml") == (2, "", f"labrig: {message}\n")
    assert not (lab / "runs").exists()


def test_a_programme_without_points_says_what_is_needed(lab: Path, labrig: Run) -> None:
    """The file, the line and the field, and that it should hold something."""
    (lab / "next.yaml").write_text("procedure: programme\npoints: []\n")
    message = "labrig: next.yaml, line 2: points: should hold 1 or more entries, not 0\n"
    assert labrig("run", "next.yaml", "--rig", "rig.yaml") == (2, "", message)


def test_a_number_is_a_name_for_a_repeat(lab: Path, labrig: Run) -> None:
    """What stands without quotes in a file is a name all the same: `repeat: 1`."""
    (lab / "next.yaml").write_text("procedure: programme\npoints:\n- {hold_s: 4, repeat: 1, label: 2.5}\n")
    code, out, _ = labrig("run", "next.yaml", "--rig", "rig.yaml", "--dry-run")
    assert code == 0
    assert "repeat 1, label 2.5" in out


def test_a_run_without_a_capture_that_counts_is_noticed_by_a_script(lab: Path, labrig: Run) -> None:
    """Its pressures never followed: the code is that of a device's fault, the lines say how many captures and why."""
    (lab / "rig.yaml").write_text(yaml.safe_dump({**RIG, **SKIP}))
    words = ("--captures", "2", "--repeated", "0", "--out", "one")
    code, out, err = labrig("run", "capture", "--rig", "rig.yaml", *words)
    assert code == 3
    assert out.startswith("one: 0 captures in ")
    last = err.splitlines()[-1]
    assert last.startswith(
        "labrig: one: no capture counts; 2 of 2 captures were left out, since the pressures did not"
    )
    assert "c1 in 2" in last
    assert labrig("runs", ".")[1].splitlines()[1].rstrip().endswith("completed")
    assert "none of its captures counts" in labrig("run", "--resume", "one")[2]


def test_a_run_that_was_begun_from_python_goes_on_there(lab: Path, labrig: Run) -> None:
    """Its run.yaml does not say which file its procedure is in: the line says what goes on with it."""

    def enough(progress: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lab_rig.run("capture", "rig.yaml", out="one", captures=20, progress=enough)
    message = "labrig: one was begun from Python: labrig.run(..., out='one', resume=True) goes on with it\n"
    assert labrig("run", "--resume", "one", "--rig", "rig.yaml") == (2, "", message)
