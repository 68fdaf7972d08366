"""The benchmark as it is run: resumable, honest about crashes, with baselines and a report."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig.bench import (
    _run,
    plan,
    read_records,
    run_blind,
    summarise,
    write_report,
    write_results,
    write_speed,
)
from labrig.bench._baselines import bic, f_test
from labrig.cli import main


def _record(name: str, seed: int, half: str = "development", *_: object) -> dict:
    """A record as `run_one` makes it, at no cost."""
    truth = {"class": name, "half": half, "seed": seed, "effects": [], "laws": [], "rig": "pads"}
    return {
        "key": f"{half}:{name}:{seed}",
        "truth": {**truth, "base_kind": "exact", "verdict": "nothing_missing", "also": []},
        "answer": {"verdict": "nothing_missing", "effects": [], "probability": 0.9},
        "seconds": 0.1,
        "right": True,
        "near": False,
        "false_alarm": False,
        "wrongly_sure": [],
    }


def test_a_benchmark_goes_on_where_it_was_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that was cut keeps what is done, even behind a torn last line, and adds only what is missing."""
    monkeypatch.setattr(_run, "run_one", _record)
    todo = plan(["null", "null-slow"], 2, 0, ["development", "exam"])
    first = run_blind(todo, tmp_path, jobs=1)
    next(first)
    next(first)
    first.close()
    with (tmp_path / "campaigns.jsonl").open("a", encoding="utf-8") as file:
        file.write('{"key": "null:2", "tru\n')
    with pytest.raises(LabrigError) as error:
        next(run_blind(todo, tmp_path, jobs=1))
    assert str(error.value) == (
        f"{tmp_path / 'campaigns.jsonl'} holds 2 campaigns: add --resume, or take another --out"
    )
    again = [record["key"] for record in run_blind(todo, tmp_path, jobs=1, resume=True)]
    assert again == [
        "development:null-slow:0",
        "development:null-slow:1",
        *(f"exam:{name}:{seed}" for name in ("null", "null-slow") for seed in (0, 1)),
    ]
    assert len(read_records(tmp_path)) == 8


def test_plans_name_what_they_do_not_know() -> None:
    """A class or a half that does not exist is one line that lists the known ones."""
    assert plan(["pair"], None, 7)[:2] == [("development", "pair", 7), ("development", "pair", 8)]
    with pytest.raises(LabrigError, match=r"^bench: there is no class 'unlisted' \(known: null, "):
        plan(["unlisted"], 1, 0)
    with pytest.raises(
        LabrigError,
        match=r"^bench: there is no half 'all' \(known: development, exam, third, fourth, fifth, sixth, "
        r"seventh, eighth, ninth, tenth, eleventh, twelfth\)$",
    ):
        plan(["pair"], 1, 0, ["all"])


def test_figures_say_how_they_came_about(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A class that was taken further with --resume is named beside the command that is written to the results."""
    monkeypatch.setattr(_run, "run_one", _record)
    results = tmp_path / "RESULTS.md"
    words = ["bench", "blind", "-o", str(tmp_path / "out"), "--jobs", "1", "--half", "both"]
    for more in (
        ["--classes", "null,null-slow", "--n", "2"],
        ["--classes", "null-slow", "--n", "3", "--resume"],
    ):
        with pytest.raises(SystemExit) as end:
            main([*words, "--results", str(results), *more])
        assert not end.value.code
    text = results.read_text(encoding="utf-8")
    how = "`labrig bench blind --half both --classes null-slow --n 3 --seed 0`, and more of null with `--resume`"
    assert how in text.splitlines()
    assert "**Exam: 5 campaigns**" in text
    assert "| all | 100.0 % | 57-100 | 100.0 % | 57-100 | +0.0 |" in text


def test_a_diagnosis_that_crashes_is_a_wrong_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """The record says what happened, and the benchmark goes on."""

    def crash(*_: object, **__: object) -> None:
        raise ZeroDivisionError("no noise")

    monkeypatch.setattr("labrig.diagnosis.diagnose", crash)
    record = _run.run_one("single", 0, baselines=False)
    assert record["answer"]["error_text"] == "ZeroDivisionError: no noise"
    assert record["right"] is False
    assert summarise([record])["halves"]["development"]["failures"] == 1


def test_no_effect_has_to_take_away_what_is_wrong_in_the_form_of_the_base(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A fresh programme's best is the noise and the base's own error there; a right model goes all the way to it."""
    from labrig.bench import draw, make_base, own_error
    from labrig.effects import rows_of

    campaign = next(
        c
        for c in (draw("structural", s) for s in range(40))
        if c.truth["amplitudes"].get("regulator", 0) > 3.0
    )
    rows = rows_of(campaign.fresh)
    gain = 1.0 + 0.1 * campaign.truth["strengths"]["regulator"]
    exact = make_base({**campaign.truth["base"], "kind": "exact"})
    wrong = make_base(campaign.base or {})(rows.actuation) - exact(rows.actuation)
    found = SimpleNamespace(context=lambda of: SimpleNamespace(base=exact(gain * of.actuation) + wrong))
    summary = {"verdict": "identified", "effects": ["regulator"], "probability": 1.0, "error": {}}
    considered = [{"effect": "regulator", "probability": 0.99, "size": 0.4, "size_sd": 0.1, "more": 1}]
    answer = SimpleNamespace(summary={**summary, "effects_considered": considered}, improved=found)
    monkeypatch.setattr("labrig.diagnosis.diagnose", lambda *_, **__: answer)
    record = _run.run_one("structural", campaign.truth["seed"], baselines=False)
    assert record["right"] is True
    kept = {"effect": "regulator", "probability": 0.99, "size": 0.4, "size_sd": 0.1}
    assert record["answer"]["effects_considered"] == [kept]
    assert own_error(campaign.truth["base"], rows.actuation) > 0.5 * campaign.truth["floor"]
    assert record["fresh"]["model"] > 1.2 * record["fresh"]["floor"]
    assert record["fresh"]["drop"] == pytest.approx(1.0, abs=0.2)


def test_one_campaign_is_drawn_diagnosed_and_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    """A record holds truth, answer, baselines and figures, and is plain JSON."""
    from labrig.bench import draw

    def smaller(name: str, seed: int, half: str, without: tuple[str, ...]) -> object:
        return draw(name, seed, half, without, captures=20)

    monkeypatch.setattr(_run, "draw", smaller)
    record = _run.run_one("single", 1, "exam")
    assert json.loads(json.dumps(record)) == record
    assert record["key"] == "exam:single:1"
    assert {"half", "laws", "rig", "base_kind", "effects"} <= set(record["truth"])
    assert record["answer"]["verdict"] != "error"
    assert {"bic", "f-test"} <= set(record["baselines"])
    assert all("wrongly_sure" in judged for judged in record["baselines"].values())


def test_information_criteria_find_what_is_there_and_nothing_in_white_noise() -> None:
    """On independent noise the textbook baselines work; what breaks them is what real campaigns have."""
    random = np.random.default_rng(3)
    forms = {name: [random.normal(size=(400, 2))] for name in "abcd"}
    noise = random.normal(size=400)
    signal = forms["b"][0] @ [0.5, -0.4] + noise
    assert bic(signal, forms) == f_test(signal, forms) == ["b"]
    assert bic(noise, forms) == f_test(noise, forms) == []


def test_a_report_leaves_the_rest_of_the_file_alone(tmp_path: Path) -> None:
    """Only the section of the blind benchmark is written, once, however often it is written."""
    summary = summarise([_record("null", k) for k in range(3)])
    write_report(summary, tmp_path)
    assert (tmp_path / "confusion.png").read_bytes().startswith(b"\x89PNG")
    written = json.loads((tmp_path / "summary.json").read_text())["halves"]["development"]
    assert written["classes"]["null"]["right"]["value"] == 1.0
    results = tmp_path / "RESULTS.md"
    results.write_text("# Results\n\n## Other\n\nkept\n\n## Blind benchmark\n\nold\n\n## Last\n\nkept too\n")
    write_results(summary, results, "how")
    write_results(summary, results, "how")
    text = results.read_text()
    assert text.count("## Blind benchmark") == 1
    assert "old" not in text
    assert text.index("kept") < text.index("how") < text.index("## Last") < text.index("kept too")
    assert "| null | 3 | 100.0 % |" in text


def test_the_exam_has_no_picture_of_its_own(tmp_path: Path) -> None:
    """What was taken for what is drawn of the exam only when it is revealed."""
    records = [_record("null", k, "exam") for k in range(3)]
    write_report(summarise(records), tmp_path)
    assert not list(tmp_path.glob("*.png"))
    write_report(summarise(records, reveal=True), tmp_path)
    assert [path.name for path in tmp_path.glob("*.png")] == ["exam-confusion.png"]


def test_times_have_a_section_of_their_own(tmp_path: Path) -> None:
    """The times of diagnoses and the figures of the blind benchmark share one file without touching each other."""
    results = tmp_path / "RESULTS.md"
    write_results(summarise([_record("null", 0)]), results, "how")
    write_speed([(100, 40800, 3.0, 4.5), (300, 122400, 9.0, 12.0)], results)
    text = results.read_text()
    assert "| 300 | 122400 | 9.0 | 12.0 | 40 |" in text
    assert "## Blind benchmark" in text


def test_a_crash_counts_among_what_was_to_be_named() -> None:
    """A campaign whose diagnosis crashed is one in which what is hidden was neither sure nor possible."""
    right = _record("single", 0)
    right["truth"] |= {"effects": ["creep"], "laws": ["a"], "verdict": "identified"}
    right["answer"] = {
        "verdict": "identified",
        "effects": ["creep"],
        "probability": 1.0,
        "effects_considered": [{"effect": "creep", "probability": 1.0}],
    }
    crashed = right | {
        "key": "development:single:1",
        "answer": {"verdict": "error", "effects": [], "error_text": "x"},
        "right": False,
    }
    half = summarise([right, crashed])["halves"]["development"]  # type: ignore[list-item]
    for figure in ("right", "true_sure", "true_possible"):
        assert half["totals"][figure]["value"] == 0.5
        assert half["effects"][0][figure]["value"] == 0.5
    assert half["totals"]["effect_ece"] is not None
    assert half["totals"]["effect_ece"]["value"] == 0.5
    assert half["failures"] == 1


def test_baselines_that_crash_cost_no_record(monkeypatch: pytest.MonkeyPatch) -> None:
    """What they failed of stands in the record, and the diagnosis counts as ever."""

    def crash(*_: object) -> None:
        raise ZeroDivisionError("no baseline")

    monkeypatch.setattr("labrig.bench._baselines.run_baselines", crash)
    monkeypatch.setattr(_run, "_ask", lambda *_: {"answer": {"verdict": "nothing_missing", "effects": []}})
    record = _run.run_one("null", 0)
    assert record["baselines_failed"] == "ZeroDivisionError: no baseline"
    assert (record["baselines"], record["right"]) == ({}, True)


def test_that_baselines_crashed_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """How often, and where to read of what, stands before the figures."""
    monkeypatch.setattr(
        _run, "run_one", lambda *given: _record(*given) | {"baselines_failed": "ValueError: x"}
    )
    monkeypatch.setenv("COLUMNS", "300")
    with pytest.raises(SystemExit):
        main(["bench", "blind", "-o", str(tmp_path), "--jobs", "1", "--classes", "null", "--n", "2"])
    said = f"the baselines failed in 2 campaigns: see baselines_failed in {tmp_path / 'campaigns.jsonl'}"
    assert said in capsys.readouterr().out


def test_it_goes_on_with_the_library_that_it_began_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Effects that are left out are known ones, and the same each time; each campaign counts once."""
    monkeypatch.setattr(_run, "run_one", _record)
    todo = plan(["null"], 2, 0)
    with pytest.raises(LabrigError) as error:
        next(run_blind(todo, tmp_path, jobs=1, without=("crep",)))
    assert str(error.value) == "bench: there is no effect 'crep' to leave out; did you mean creep?"
    assert not list(tmp_path.iterdir())
    assert len(list(run_blind(todo, tmp_path, jobs=1))) == 2
    with pytest.raises(LabrigError) as error:
        next(run_blind(todo, tmp_path, jobs=1, resume=True, without=("creep",)))
    assert str(error.value) == (
        f"{tmp_path} was begun with the whole library: go on with the same, or take another --out"
    )
    path = tmp_path / "campaigns.jsonl"
    path.write_text(path.read_text(encoding="utf-8") * 2, encoding="utf-8")
    assert len(read_records(tmp_path)) == 2


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--classes", ","], "labrig: bench: --classes ,: names no class"),
        (["--seed", "-1"], "labrig: Invalid value for '--seed': Input should be greater than or equal to 0"),
    ],
)
def test_what_asks_for_no_campaign_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], said: str
) -> None:
    """Without a class, or with a seed below nothing, there is one line and no report."""
    with pytest.raises(SystemExit) as end:
        main(["bench", "blind", "-o", str(tmp_path / "out"), *more])
    assert end.value.code == 2
    assert said in capsys.readouterr().err
    assert not list((tmp_path / "out").glob("*"))
