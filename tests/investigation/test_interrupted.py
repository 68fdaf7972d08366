"""An investigation that was cut short, and what counts as the same on fresh captures."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from labrig import LabrigError
from labrig.investigation import Settings, _loop, _rounds
from labrig.investigation._programmes import _asked
from labrig.investigation._state import start_or_resume
from tests.investigation.test_programmes import work_in


def a_round(number: int, programme: str, verdict: str = "identified") -> dict[str, Any]:
    """A round as investigation.json has it; without a verdict it was measured and not diagnosed."""
    error = {"model": 0.2, "floor": 0.1}
    said = {"verdict": verdict, "effects": ["leak"], "rivals": [], "probability": 0.9, "error": error}
    return {
        "round": number,
        "programme": programme,
        "run": f"run-{number}",
        "minutes": 2,
        "captures": 14,
        **said,
    }


@pytest.mark.parametrize(
    ("rounds", "confirmed", "kept"),
    [
        ([a_round(1, "capture")], None, 1),
        ([a_round(1, "capture", "")], None, 0),
        ([a_round(1, "capture"), a_round(2, "experiment", "")], None, 1),
        ([a_round(1, "capture"), a_round(2, "confirmation", "")], None, 1),
        ([a_round(1, "capture"), a_round(2, "confirmation")], None, 1),
        ([a_round(1, "capture"), a_round(2, "confirmation")], "run-2", 2),
        ([a_round(1, "capture"), a_round(2, "confirmation"), a_round(3, "confirmation")], "run-2", 2),
        ([{**a_round(1, "given", ""), "given": ["first"]}], None, 1),
    ],
)
def test_what_was_measured_is_judged_after_a_resume_and_not_measured_again(
    tmp_path: Path, rounds: list[dict[str, Any]], confirmed: str | None, kept: int
) -> None:
    """A round that was cut short behind its run is gone through again: its run is whole, and is only read."""
    work = work_in(tmp_path, rounds)
    if confirmed is not None:
        numbers = {"before": 1.0, "after": 0.5, "floor": 0.1, "drop": 0.6}
        work.state.confirmation = {"effects": ["leak"], "run": confirmed, **numbers}  # type: ignore[typeddict-item]
    work.state.end("interrupted", "Interrupted.")
    again = start_or_resume(work.state.settings, resume=True)
    assert len(again.rounds) == kept


@pytest.mark.parametrize(
    ("before", "after", "held"),
    [(1.0, 0.12, True), (1.0, 0.5, False), (0.099, 0.098, False), (0.1, 0.05, False), (0.099, 0.2, False)],
)
def test_captures_on_which_nothing_is_off_confirm_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, before: float, after: float, held: bool
) -> None:
    """A name holds where four fifths of what is above the floor go; where nothing is above it, nothing can."""
    errors = iter([before, after])
    monkeypatch.setattr(
        "labrig.diagnosis.compare",
        lambda *_, **__: SimpleNamespace(summary={"error": {"model": next(errors)}}),
    )
    again = SimpleNamespace(summary={"error": {"floor": 0.1}})
    monkeypatch.setattr(_rounds, "measured_round", lambda *_: again)
    work = work_in(tmp_path, [a_round(1, "confirmation")])
    work.state._opened = [SimpleNamespace()]  # type: ignore[list-item]
    found = SimpleNamespace(improved=SimpleNamespace(), summary={"effects": ["leak"]})
    assert _rounds.confirmed(work, found, SimpleNamespace())[0] is held  # type: ignore[arg-type]
    assert work.state.confirmation is not None
    assert abs(work.state.confirmation["drop"]) < 10


def test_the_order_of_names_does_not_make_them_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Diagnoses name the likeliest first: the same two names the other way round are the same finding."""
    said = {"verdict": "multiple", "effects": ["creep", "leak"], "rivals": [], "probability": 0.8}
    work = work_in(tmp_path, [a_round(1, "capture"), a_round(2, "confirmation")], budget_min=30)
    work.state.confirmation = {"effects": ["leak", "creep"], "drop": 0.2}  # type: ignore[typeddict-item]
    asked = _asked(work, said)  # type: ignore[arg-type]
    assert asked is not None
    assert asked["verdict"] == "unknown"
    first, again = (
        SimpleNamespace(summary={**said, "effects": n}) for n in (["leak", "creep"], said["effects"])
    )
    ended: list[bool | None] = []
    for name, what in {
        "fresh_programme": lambda _: None,
        "_first": lambda *_: first,
        "experiment": lambda *_: None,
        "fitted": lambda *_: first,
        "confirmed": lambda *_: (True, again),
        "_improved": lambda _work, _result, held: ended.append(held),
    }.items():
        monkeypatch.setattr(_loop, name, what)
    monkeypatch.setattr(type(work.bench), "minutes", lambda *_: 1.0)
    _loop._loop(work)
    assert ended == [True]


def test_a_full_disk_does_not_hide_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where not even the report can be written, the first error is said, with the command that resumes."""
    work = work_in(tmp_path / "asked", [])

    def fails(*_: Any) -> None:
        (work.state.folder / "run-1").mkdir()
        raise LabrigError("no space left")

    monkeypatch.setattr(_loop, "_loop", fails)
    monkeypatch.setattr("labrig.view.write_investigation", fails)
    settings = Settings(rig="rig.yaml", model="model.yaml", out=tmp_path / "asked")
    with pytest.raises(
        LabrigError, match=r"^no space left; 0 rounds are in .*; to resume: labrig.investigate"
    ):
        _loop._investigated(settings, work.bench, work.model, False, work.reporter)


def test_another_model_does_not_go_on_with_what_one_began(tmp_path: Path) -> None:
    """Errors of two models are no rounds of one investigation; where nothing was diagnosed yet, it may be mended."""
    work = work_in(tmp_path, [a_round(1, "capture")], model_sha256="a")
    work.state.end("interrupted", "Interrupted.")
    edited = replace(work.state.settings, model_sha256="b")
    assert len(start_or_resume(work.state.settings, resume=True).rounds) == 1
    with pytest.raises(LabrigError, match=r"is not the model that .* began with"):
        start_or_resume(edited, resume=True)
    work.state.rounds[0]["verdict"] = ""
    work.state.end("interrupted", "Interrupted.")
    assert start_or_resume(edited, resume=True).rounds == []
