"""What `labrig diagnose` prints of a verdict, from a hand-made summary."""

import pytest

from labrig.cli._tables import print_summary

ROW = {"size": 2.0, "size_sd": 0.1, "size_floors": 20.0, "size_sd_floors": 1.0}
NOWHERE = {"size": 0.0, "size_sd": 0.0, "size_floors": 0.0, "size_sd_floors": 0.0}
SUMMARY = {
    "verdict": "confounded",
    "effects": ["hysteresis"],
    "probability": 0.1,
    "rivals": ["regulator"],
    "effects_considered": [
        {"effect": "hysteresis", "probability": 0.97, "call": "sure", **ROW},
        {"effect": "regulator", "probability": 0.34, "call": "possible", **ROW},
        {"effect": "rest_shape", "probability": 0.0, "call": "not it", **NOWHERE},
    ],
    "unnamed": {"history": 0.4},
    "units": "mm",
    "error": {"base": 2.1, "model": 0.5, "floor": 0.1, "ceiling": None},
    "where": [],
    "ranking": [{"effect": "hysteresis", "form": "play", "heldout_error": 0.4, "drop": 0.9}],
    "warnings": [],
}


def test_sure_possible_and_not_it(capsys: pytest.CaptureFixture[str]) -> None:
    """Each effect is printed with its own probability and size, and what has no name in plain words."""
    print_summary(SUMMARY, "diagnosis")
    printed = capsys.readouterr().out.replace("\u00a0", " ")
    assert "hysteresis, sure (97 %, 2.0 ± 0.1 mm); possible beside it: regulator (34 %)" in printed
    assert "Unexplained by any effect: 0.4 mm depends on earlier pressures (history-dependent)." in printed
    row = next(line for line in printed.splitlines() if line.startswith("│ regulator"))
    assert [cell.strip() for cell in row.split("│")[1:-1]] == [
        "regulator",
        "possible",
        "34 %",
        "2.0 ± 0.1",
        "20 ± 1",
    ]
    assert "not it: rest shape" in printed
    assert "10 %" not in printed


def test_too_few_data(capsys: pytest.CaptureFixture[str]) -> None:
    """Where nothing could be weighed no effect is said to be not it."""
    rows = [{"effect": "leak", "probability": 0.0, "call": "not it", **NOWHERE}]
    few = {**SUMMARY, "verdict": "underpowered", "effects": [], "rivals": [], "effects_considered": rows}
    print_summary({**few, "unnamed": {}, "ranking": []}, "diagnosis")
    printed = capsys.readouterr().out
    assert "the data are too few or too noisy" in printed
    assert "not it" not in printed
