"""The benchmark as it is run: resumable, honest about crashes, with baselines and a report."""

import json
from pathlib import Path

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


def _record(name: str, seed: int, *_: object) -> dict:
    """A record as `run_one` makes it, at no cost."""
    return {
        "key": f"{name}:{seed}",
        "truth": {"class": name, "seed": seed, "effects": [], "verdict": "nothing_missing"},
        "answer": {"verdict": "nothing_missing", "effects": [], "probability": 0.9},
        "seconds": 0.1,
        "right": True,
        "near": False,
        "false_alarm": False,
    }


def test_a_benchmark_goes_on_where_it_was_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that was cut keeps what is done, even behind a torn last line, and adds only what is missing."""
    monkeypatch.setattr(_run, "run_one", _record)
    todo = plan(["null", "null-slow"], 3, 0)
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
    assert again == ["null:2", "null-slow:0", "null-slow:1", "null-slow:2"]
    assert len(read_records(tmp_path)) == 6


def test_figures_say_how_they_came_about(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A class that was taken further with --resume is named beside the command that is written to the results."""
    monkeypatch.setattr(_run, "run_one", _record)
    results = tmp_path / "RESULTS.md"
    words = ["bench", "blind", "-o", str(tmp_path / "out"), "--jobs", "1", "--results", str(results)]
    for more in (["--classes", "null,force", "--n", "2"], ["--classes", "force", "--n", "3", "--resume"]):
        with pytest.raises(SystemExit) as end:
            main([*words, *more])
        assert not end.value.code
    how = "`labrig bench blind --classes force --n 3 --seed 0`, and more of null with `--resume`"
    assert how in results.read_text(encoding="utf-8").splitlines()


def test_a_diagnosis_that_crashes_is_a_wrong_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """The record says what happened, and the benchmark goes on."""

    def crash(*_: object, **__: object) -> None:
        raise ZeroDivisionError("no noise")

    monkeypatch.setattr("labrig.diagnosis.diagnose", crash)
    record = _run.run_one("single-2", 0, baselines=False)
    assert record["answer"]["error_text"] == "ZeroDivisionError: no noise"
    assert record["right"] is False


def test_no_effect_has_to_take_away_what_is_wrong_in_the_form_of_the_base() -> None:
    """A fresh programme's best is the noise and the base's own error there: the right name goes all the way to it."""
    record = _run.run_one("structural", 430004, baselines=False)
    assert record["answer"]["effects"] == ["coupling"]
    assert record["fresh"]["model"] > 2.0 * record["fresh"]["floor"]
    assert record["fresh"]["drop"] > 0.9


def test_one_campaign_is_drawn_diagnosed_and_judged() -> None:
    """A record holds truth, answer, baselines and figures, and is plain JSON."""
    record = _run.run_one("force", 0)
    assert json.loads(json.dumps(record)) == record
    assert record["truth"]["effects"] == ["friction"]
    assert record["answer"]["verdict"] != "error"
    assert {"bic", "f-test"} <= set(record["baselines"])


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
    assert json.loads((tmp_path / "summary.json").read_text())["classes"]["null"]["right"] == 1.0
    results = tmp_path / "RESULTS.md"
    results.write_text("# Results\n\n## Other\n\nkept\n\n## Blind benchmark\n\nold\n\n## Last\n\nkept too\n")
    write_results(summary, results, "how")
    write_results(summary, results, "how")
    text = results.read_text()
    assert text.count("## Blind benchmark") == 1
    assert "old" not in text
    assert text.index("kept") < text.index("how") < text.index("## Last") < text.index("kept too")
    assert "| null | 3 | 100.0 % |" in text


def test_times_have_a_section_of_their_own(tmp_path: Path) -> None:
    """The times of diagnoses and the figures of the blind benchmark share one file without touching each other."""
    results = tmp_path / "RESULTS.md"
    write_results(summarise([_record("null", 0)]), results, "how")
    write_speed([(100, 40800, 3.0, 4.5), (300, 122400, 9.0, 12.0)], results)
    text = results.read_text()
    assert "| 300 | 122400 | 9.0 | 12.0 | 40 |" in text
    assert "## Blind benchmark" in text
