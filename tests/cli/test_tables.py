"""What `labrig diagnose` prints of a verdict, from a hand-made summary."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from labrig.cli._diagnosis import _to_add
from labrig.cli._tables import print_summary
from labrig.cli._validate import _print as print_validation
from labrig.effects._registry import shipped

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


def test_a_validation_fits_a_narrow_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a scan and its refinement, every column has its whole name in 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")
    found = {"mean": 0.173}
    names = ("hardware", "predicted", "realised", "realised_against_predicted", "markers_against_predicted")
    row = {"target": "body-2.ply", "model": "without the warp", **{f"{name}_mm": found for name in names}}
    print_validation([{**row, "compared": 0.99, "refined": [{"realised_mm": found}]}])
    head = next(line for line in capsys.readouterr().out.splitlines() if "target" in line and "┃" in line)
    assert [word for word in head.replace("┃", " ").split() if word.endswith("…")] == []


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


def test_what_nobody_knows_may_be_an_effect_of_another_law(capsys: pytest.CaptureFixture[str]) -> None:
    """Where something without a name explains most, the effects that are not it are so by the laws that are known."""
    print_summary({**SUMMARY, "verdict": "unknown"}, "diagnosis")
    assert "not it, unless by a law that labrig does not know: rest shape" in capsys.readouterr().out


def test_a_row_for_each_unit(capsys: pytest.CaptureFixture[str]) -> None:
    """Of a run in two units the errors stand in both; what is no figure in one of them is a dash."""
    by_unit = {
        "mm": {"base": 2.1, "model": 0.5, "floor": 0.1},
        "N": {"base": 4.2, "model": 0.7, "floor": 0.2},
    }
    print_summary(
        {**SUMMARY, "error": {**SUMMARY["error"], "ceiling": 0.3}, "error_by_unit": by_unit}, "diagnosis"
    )
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in capsys.readouterr().out.splitlines()]
    assert ["mm", "2.1", "0.5", "0.1", "0.3"] in rows
    assert ["N", "4.2", "0.7", "0.2", "-"] in rows


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "nothing is missing: the model is as good as the measurements"),
        ({"left_out_share": 0.2}, "nothing is missing beside what was left out"),
        ({"effects_considered": [SUMMARY["effects_considered"][1]]}, "nothing is surely missing"),
    ],
)
def test_what_nothing_missing_means(capsys: pytest.CaptureFixture[str], changes: Any, said: str) -> None:
    """It is not called as good as the measurements where much was left out, or something may be missing."""
    quiet = {
        **SUMMARY,
        "verdict": "nothing_missing",
        "effects": [],
        "rivals": [],
        "unnamed": {},
        "ranking": [],
    }
    print_summary({**quiet, "effects_considered": [], **changes}, "diagnosis")
    assert f"verdict: nothing_missing ({said}" in " ".join(capsys.readouterr().out.split())


def test_too_few_data(capsys: pytest.CaptureFixture[str]) -> None:
    """Where nothing could be weighed no effect is said to be not it."""
    rows = [{"effect": "leak", "probability": 0.0, "call": "not it", **NOWHERE}]
    few = {**SUMMARY, "verdict": "underpowered", "effects": [], "rivals": [], "effects_considered": rows}
    print_summary({**few, "unnamed": {}, "ranking": []}, "diagnosis")
    printed = capsys.readouterr().out
    assert "the data are too few or too noisy" in printed
    assert "not it" not in printed


def improved_by(summary: dict[str, Any], sure: list[str], possible: list[str], form: str) -> Any:
    """A diagnosis with a better model, in which each of these effects has this form."""
    effects = [SimpleNamespace(name=name, form=form) for name in (*sure, *possible)]
    improved = SimpleNamespace(file=SimpleNamespace(effects=effects), library=shipped)
    return SimpleNamespace(summary=summary, sure=sure, possible=possible, improved=improved)


@pytest.mark.parametrize(
    ("verdict", "sure", "possible", "added"),
    [
        ("identified", ["creep"], ["leak"], "--add creep"),
        ("confounded", [], ["contact"], "--add contact"),
        ("confounded", [], ["contact", "creep"], None),
        ("unknown", [], ["regulator"], None),
    ],
)
def test_what_is_found_is_one_command_away(
    verdict: str, sure: list[str], possible: list[str], added: str | None
) -> None:
    """What is sure, or the only name that is left, comes with the commands that add and confirm it; no doubt does."""
    rows = [{"effect": name, "call": "sure"} for name in sure]
    rows += [{"effect": name, "call": "possible"} for name in possible]
    summary = {"verdict": verdict, "effects_considered": rows, "error": {"base": 2.0, "model": 0.3}}
    found = improved_by(summary, sure, possible, "a formula")
    lines = _to_add(found, [Path("run")], Path("model.yaml"))
    if added is None:
        assert lines == []
        return
    assert lines[0] == f"to add it: labrig improve run --model model.yaml {added} -o improved.yaml"
    assert lines[1:] == [
        "to confirm it, on a run with other set-points: labrig compare NEW_RUN --model improved.yaml"
    ]


def test_weights_that_follow_any_law_confirm_no_name() -> None:
    """Where a family's own weights go in, a smaller error on a new run is no proof of the name: what is, is said."""
    rows = [{"effect": "contact", "call": "sure"}]
    summary = {"verdict": "identified", "effects_considered": rows, "error": {"base": 2.0, "model": 0.3}}
    found = improved_by(summary, ["contact"], [], "family, limit 0.5")
    assert _to_add(found, [Path("run")], Path("model.yaml"))[1:] == [
        "to see whether it predicts better, on a run with other set-points: labrig compare NEW_RUN --model "
        "improved.yaml",
        "to confirm that it is contact, whose weights follow other laws as well: take away whatever the body could "
        "touch, and measure again (labrig next)",
    ]


def test_what_happened_in_a_run_is_confirmed_by_no_other() -> None:
    """A marker that slipped at a moment of this run is looked at; to predict another run would say nothing of it."""
    rows = [{"effect": "marker_slip", "call": "sure"}]
    summary = {"verdict": "identified", "effects_considered": rows, "error": {"base": 2.0, "model": 0.3}}
    found = improved_by(summary, ["marker_slip"], [], "step")
    assert _to_add(found, [Path("run")], Path("model.yaml")) == [
        "to add it: labrig improve run --model model.yaml --add marker_slip -o improved.yaml",
        "to confirm marker slip: look at the marker; repeat one early capture",
    ]


@pytest.mark.parametrize(("parts", "end"), [(4, "part 4 (8.2 min)"), (7, "part 4; and 3 more (8.2 min)")])
def test_of_a_long_experiment_the_first_parts_are_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, parts: int, end: str
) -> None:
    """Sixteen names in a row are read by nobody: four are printed, and how many more there are."""
    monkeypatch.setenv("COLUMNS", "200")
    programme = [{"probe": f"part {i + 1}"} for i in range(parts)]
    print_summary({**SUMMARY, "next_experiment": {"programme": programme, "minutes": 8.2}}, "diagnosis")
    line = next(one for one in capsys.readouterr().out.splitlines() if one.startswith("next: "))
    assert line == f"next: part 1; part 2; part 3; {end}; labrig next writes it"
