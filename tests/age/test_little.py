"""Runs that say little of a rig's age: failures are left out, and nothing is claimed of what was never repeated."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from labrig.age import _age
from labrig.catalogue import Row
from labrig.cli._history_steps import print_check
from labrig.view import history_headline, history_notes


def content(*kinds: str, leak: float = 3.65e-14) -> Any:
    """What is known of a rig after runs of these kinds."""
    n = len(kinds)
    return {
        "rig": "gripper",
        "runs": [{"run": str(i), "date": "", "procedure": k, "kind": k} for i, k in enumerate(kinds)],
        "quantities": [
            {
                "group": "leak",
                "name": "c1",
                "unit": "%/min",
                "runs": list(range(n)),
                "value": [[leak]] * n,
                "sd": [3.1e-15] * n,
            }
        ],
        "changes": [],
        "unconfirmed": [],
        "left_out": [],
    }


def test_a_run_that_failed_at_once_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure with one capture is no part of the history, and it is said why; one that got far is."""
    monkeypatch.setattr(_age, "prepared", lambda *_: (None, ""))
    monkeypatch.setattr(_age, "read_run", lambda _folder, name, *_: SimpleNamespace(time_s=0.0, run=name))
    rows = [
        Row("good", "1", "capture", captures=20, state="completed"),
        Row("bad", "2", "capture", captures=1, state="step 3: nothing was moved"),
        Row("far", "3", "capture", captures=9, state="the connection was closed"),
        Row("short", "4", "hold", captures=1, state="completed"),
    ]
    read, left_out = _age.read_rows(Path(), rows, None)  # type: ignore[arg-type]
    assert sorted(each.run for each in read) == ["far", "good", "short"]
    assert left_out == [{"run": "bad", "why": "it ended early, after 1 capture"}]


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (["a"], "1 run of gripper: a change shows from the fourth on."),
        (["a"] * 3, "3 runs of gripper: a change shows from the fourth on."),
        (
            ["a", "b", "c", "d"],
            "4 runs of gripper, none of which repeats a programme: a change shows from the fourth on.",
        ),
        (
            ["a", "a", "b", "c"],
            "4 runs of gripper, 2 of which repeat a programme: a change shows from the fourth on.",
        ),
        (["a"] * 4, "Nothing on gripper has changed by more than chance in 4 runs."),
    ],
)
def test_nothing_is_claimed_of_what_was_not_repeated(kinds: list[str], said: str) -> None:
    """That nothing has changed is said only where runs of the same programme can be compared."""
    assert history_headline(content(*kinds)) == said


def test_the_first_run_of_a_programme_is_compared_with_none(capsys: pytest.CaptureFixture[str]) -> None:
    """Its own values are not shown as those of first runs, a note says so, and a leak of rounding is 0."""
    summary = content("capture", "capture", "check")
    notes = history_notes(summary)
    print_check(SimpleNamespace(summary=summary, headline=lambda: "", warnings=notes))  # type: ignore[arg-type]
    row = next(line for line in capsys.readouterr().out.splitlines() if "c1" in line)
    assert [cell.strip() for cell in row.strip("│").split("│")] == ["leak rates", "c1", "", "0 ± 0 %/min", ""]
    assert notes == [
        "the last run is the first of its programme (check): there is none before it that it could be compared with"
    ]
