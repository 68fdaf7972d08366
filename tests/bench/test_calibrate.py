"""How much names are to be trusted, as it is counted and learnt."""

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.special import expit, logit

from labrig._errors import LabrigError
from labrig.bench import _calibrate, calibration_plan, run_calibrate, surprise, write_calibration
from labrig.bench._calibrate import MIX, UNLEARNT, Said, fitted
from labrig.diagnosis._verdict import Considered

TRUE = {"creep": 3.0, "drift": 0.0, "frame": -1.5}
"""What each effect adds to the log odds, in the drawn names: what it adds as far as there is evidence."""


def drawn(count: int, seed: int = 0) -> list[Said]:
    """Names that are there as often as a logistic law says, of all portions."""
    random, out = np.random.default_rng(seed), []
    for i in range(count):
        effect, p, share = random.choice(list(TRUE)), expit(random.uniform(-6, 6)), random.uniform(0.1, 1)
        own = TRUE[effect] * (p if TRUE[effect] > 0 else 1.0)
        there = random.random() < expit(own - 1 + 0.4 * logit(p) + 1.5 * share)
        out.append(Said(UNLEARNT[i % len(UNLEARNT)], str(effect), float(p), float(share), bool(there)))
    return out


def test_what_names_are_worth_comes_back() -> None:
    """Of many names the law that they were drawn by is found: evidence, share, and each effect."""
    found = fitted(drawn(6000))
    assert found.odds == pytest.approx(0.4, abs=0.05)
    assert found.share == pytest.approx(1.5, abs=0.3)
    own = {name: found.always + more for name, more in found.effects.items()}
    assert own == pytest.approx({name: more - 1 for name, more in TRUE.items()}, abs=0.3)


def test_of_few_names_effects_are_alike() -> None:
    """An effect that was seen twice is taken for nearly an average one, whatever was seen."""
    few = [*drawn(400), *[Said("ninth", "leak", 0.99, 0.9, False)] * 2]
    assert -1.5 < fitted(few).effects["leak"] < 0


def test_it_is_judged_on_portions_that_it_has_not_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calibrated names are less of a surprise than what evidence says, each portion judged by the others."""
    seen: list[set[str]] = []

    def learnt(said: list[Said]):
        seen.append({one.half for one in said})
        return fitted(said)

    monkeypatch.setattr(_calibrate, "fitted", learnt)
    alone, calibrated = surprise(drawn(1200))
    assert calibrated < 0.9 * alone
    assert sorted(map(sorted, seen)) == sorted(sorted(set(UNLEARNT) - {half}) for half in UNLEARNT)


def test_campaigns_are_of_all_classes_and_portions() -> None:
    """Each portion has as many of each class, one after another, with a seed of its own."""
    todo = calibration_plan(2 * len(MIX), 7)
    for half in UNLEARNT:
        own = [(name, seed) for name, seed, other in todo if other == half]
        assert own == [(name, 7 + i) for i, name in enumerate(MIX + MIX)]


def test_a_campaign_says_what_evidence_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A drawn campaign is diagnosed: what is hidden in it is among its names, with share and evidence."""
    monkeypatch.setattr(_calibrate, "draw", partial(_calibrate.draw, captures=40))
    (said,) = run_calibrate([("single", 94_000_000, "eleventh")], tmp_path / "names.jsonl", 1)
    assert [one.half for one in said] == ["eleventh"] * len(said)
    assert sum(one.there for one in said) == 1
    assert all(0 < one.by_evidence <= 1 + 1e-9 and 0 < one.share <= 1.01 for one in said)
    write_calibration([*drawn(60), *said], tmp_path / "calibration.json", "how")
    written = json.loads((tmp_path / "calibration.json").read_text())
    assert (written["how"], written["names"]) == ("how", 60 + len(said))
    assert set(written) == {"how", "names", "always", "odds", "share", "effects"}


def test_a_count_goes_on_where_it_was_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With `resume` what was counted is not counted again, and says the same; without it the file is refused."""
    asked: list[tuple[str, int, str]] = []

    def said_of(task: tuple[str, int, str]) -> list[Said]:
        asked.append(task)
        return [Said(task[2], "creep", 0.9, 0.5, there=True)]

    monkeypatch.setattr(_calibrate, "said_of", said_of)
    todo, names = calibration_plan(2, 7), tmp_path / "names.jsonl"
    first = list(run_calibrate(todo[:5], names, 1))
    again = list(run_calibrate(todo, names, 1, resume=True))
    assert asked == todo
    assert again[:5] == first
    assert len(again) == len(todo)
    with pytest.raises(LabrigError) as raised:
        next(run_calibrate(todo, names, 1))
    assert (
        str(raised.value) == f"{names} holds the names of {len(todo)} campaigns: add --resume, or remove it"
    )
    names.write_text('[["single", 7, "ninth"], [{"effect": "creep", "ahead": 1.0}]]', encoding="utf-8")
    with pytest.raises(LabrigError) as raised:
        next(run_calibrate(todo, names, 1, resume=True))
    assert str(raised.value) == f"{names} is of another release: remove it"


def test_names_that_the_base_may_go_by_are_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the base has a wrong law of its own, its names say nothing; nor does what is ruled out."""
    task = ("structural", 92_003_003, "ninth")  # the base's chambers have another law
    also = _calibrate.draw(*task).truth["also"]
    assert also
    rows = [
        Considered(also[0], 0.9, by_evidence=0.9, share=0.5),
        Considered("leak", 0.2, by_evidence=0.1, share=0.3),
    ]
    monkeypatch.setattr(_calibrate, "considered", lambda *_: (*rows, Considered("delay", 0.0)))
    assert _calibrate.said_of(task) == [Said("ninth", "leak", 0.1, 0.3, False)]
