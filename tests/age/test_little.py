"""Runs that say little of a rig's age: failures are left out, and nothing is claimed of what was never repeated."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from labrig.age import ALPHA, Reading, RunReadings, Series, _age, changes
from labrig.catalogue import Row
from labrig.cli._history_steps import print_check
from labrig.view import history_headline, history_notes
from labrig.view._history_report import _FEWEST_ALIKE


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


def test_the_room_is_shown_and_is_no_change_of_the_rig() -> None:
    """A temperature that steps is in the history and is no change; the same step of a zero is one."""
    runs = [
        RunReadings(
            str(day), 86400.0 * day, "check", (Reading(group, "c1", (20.0 + 9.0 * (day > 15),), 0.1, ""),)
        )
        for group in ("ambient", "zero")
        for day in range(30)
    ]
    model: Any = SimpleNamespace(file=SimpleNamespace(fitted_until=None), path=None)
    warm, off = (_age.summary_of("gripper", model, runs[begin : begin + 30]) for begin in (0, 30))
    assert (len(warm["quantities"]), warm["changes"]) == (1, [])
    assert len(off["changes"]) == 1


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (
            "a",
            "1 run of gripper: nothing can be told yet, a change shows from the seventh run of a programme on.",
        ),
        (
            "aaaaaa",
            "6 runs of gripper: nothing can be told yet, a change shows from the seventh run of a programme on.",
        ),
        (
            "aabbccddaabbccdd",
            "16 runs of gripper, at most 4 of them of the same programme: nothing can be told yet, "
            "a change shows from the seventh run of a programme on.",
        ),
        ("aaabaaaa", "Nothing on gripper has changed by more than chance in 8 runs."),
    ],
)
def test_nothing_is_claimed_of_what_was_not_repeated(kinds: str, said: str) -> None:
    """That nothing has changed is said only where runs of the same programme can be compared."""
    assert history_headline(content(*kinds)) == said


@pytest.mark.parametrize(("runs", "found"), [(_FEWEST_ALIKE - 1, False), (_FEWEST_ALIKE, True)])
@pytest.mark.parametrize("begins", [1, 3, 4])
def test_a_huge_step_shows_from_the_run_that_is_named(runs: int, found: bool, begins: int) -> None:
    """From as many runs on as the headline asks for, and from no fewer, a change can show among 500 quantities."""
    value = 0.01 * np.random.default_rng(0).normal(size=(runs, 1))
    value[begins:] += 1e4
    series = Series(np.arange(runs, dtype=float), value, np.full(runs, 0.01), np.array(["a"] * runs))
    assert bool(changes(series, ALPHA / 500).changes) == found


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
