"""The verdict: what hand-made answers come to, with their probabilities; and when too little was measured."""

import ast
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrig.diagnosis import Calibration, _verdict, diagnose
from labrig.diagnosis import _constants as k
from labrig.diagnosis._answers import Answer, Size
from labrig.diagnosis._diagnose import laid_out, result_of
from labrig.diagnosis._problem import prepared, rows_from
from labrig.diagnosis._ranking import drop_of
from labrig.diagnosis._verdict import (
    Considered,
    Verdict,
    decide,
    detectable_floors,
    less_sure,
    taken_back,
    underpowered,
)

EFFECTS = ("leak", "creep", "drift", "hysteresis")
WORDS = {"?form": "each chamber by itself", "?history": "history", "?time": "time"}
LEAST, LARGE, SMALL = 1.0, 8.0, 0.1


def answer(
    probability: float, *names: str, beside: str = "", unnamed: float = 2 * LARGE, **sizes: float
) -> Answer:
    """An explanation with these effects, well worth a name, with others of given sizes, and something unnamed."""
    all_sizes = {**dict.fromkeys(names, LARGE), **sizes}
    found = {name: Size(size, 0.5, size) for name, size in all_sizes.items()}
    return Answer(probability, found, {beside: unnamed} if beside else {}, LEAST)


def told(*answers: Answer) -> Verdict:
    """The verdict on these answers."""
    return decide(answers, EFFECTS, WORDS)


def chances(verdict: Verdict) -> dict[str, float]:
    """The probability of each effect that has any."""
    return {c.effect: round(c.probability, 6) for c in verdict.considered if c.probability > 0}


@pytest.fixture(autouse=True)
def as_evidence_says(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Probabilities are those of the evidence, but for what a test adds to the log odds of an effect."""

    def trusted(**effects: float) -> None:
        monkeypatch.setattr(_verdict, "shipped", lambda: Calibration(0.0, 1.0, 0.0, effects))

    trusted()
    return trusted


def test_nothing_missing() -> None:
    """Where most of the probability is on no effect, nothing is missing; what may be there all the same is listed."""
    verdict = told(answer(0.8), answer(0.2, "creep"))
    assert (verdict.verdict, verdict.effects, verdict.rivals) == ("nothing_missing", (), ())
    assert verdict.probability == pytest.approx(0.8)
    assert chances(verdict) == pytest.approx({"creep": 0.2}, abs=1e-6)
    assert verdict.considered[0].effect == "creep"


def test_nothing_is_said_to_be_missing_where_that_is_likelier_than_names(
    as_evidence_says: Callable[..., None],
) -> None:
    """Names that are often right are no verdict by being many, where nothing at all is likelier than all of them."""
    as_evidence_says(leak=15.0, creep=15.0, drift=15.0)  # a record counts as far as there is evidence
    several = [answer(0.09, name) for name in ("leak", "creep", "drift")]
    verdict = told(answer(0.42), *several, answer(0.31, beside="?form"))
    assert verdict.verdict == "nothing_missing"
    assert verdict.probability == pytest.approx(0.42)
    assert 1 - np.prod([1 - c.probability for c in verdict.considered]) > 0.5
    assert told(answer(0.22), *several, answer(0.51, beside="?form")).verdict == "unknown"


def test_names_that_are_seldom_right_leave_something_missing(
    as_evidence_says: Callable[..., None],
) -> None:
    """Where each explanation has an effect that is hardly ever right, something is missing, without a name."""
    as_evidence_says(leak=-4.0, creep=-4.0)
    verdict = told(answer(0.5, "leak", beside="?form"), answer(0.5, "creep", beside="?form"))
    assert {c.call for c in verdict.considered} == {"not it"}
    assert (verdict.verdict, verdict.effects) == ("unknown", ())


def test_a_name_that_is_taken_back_leaves_the_others() -> None:
    """What cannot be a delay is none: what stays sure is said as it is, and where nothing stays it is unknown."""
    words = {"leak": "what is ahead of the input"}
    two = taken_back(told(answer(0.97, "leak", "creep"), answer(0.03, "leak")), words)
    assert (two.verdict, two.effects, two.carried_by) == (
        "identified",
        ("creep",),
        "what is ahead of the input",
    )
    assert chances(two) == pytest.approx({"creep": 0.97}, abs=1e-6)
    assert two.probability == pytest.approx(0.97, abs=1e-6)
    one = taken_back(told(answer(0.97, "leak"), answer(0.03, "drift")), words)
    assert (one.verdict, one.effects, one.rivals) == ("unknown", (), ())
    assert one.probability == pytest.approx(0.97 * 0.97, abs=1e-6)
    doubt = taken_back(told(answer(0.4, "leak"), answer(0.6, "drift")), words)
    assert (doubt.verdict, doubt.rivals) == ("confounded", ("drift",))
    assert doubt.probability == pytest.approx(0.6)
    less = taken_back(told(answer(0.7, "leak"), answer(0.3, "drift")), words)
    assert (less.verdict, less.rivals) == ("unknown", ())
    assert less.probability == pytest.approx(0.7)


def test_identified() -> None:
    """One effect in nearly all answers is it, as sure as that nothing else is; what may stand beside it is possible."""
    verdict = told(answer(0.83, "leak"), answer(0.14, "leak", "drift"), answer(0.03, "creep"))
    assert (verdict.verdict, verdict.effects, verdict.rivals) == ("identified", ("leak",), ())
    assert verdict.probability == pytest.approx(0.97 * (1 - 0.14) * (1 - 0.03))
    said = {"leak": 0.97, "drift": 0.14, "creep": 0.03}
    assert chances(verdict) == pytest.approx(said, abs=1e-6)
    assert [c.call for c in verdict.considered] == ["sure", "possible", "not it", "not it"]


def test_multiple() -> None:
    """Two effects that nearly all answers have are both missing."""
    verdict = told(answer(0.97, "leak", "creep"), answer(0.03, "leak"))
    assert (verdict.verdict, set(verdict.effects)) == ("multiple", {"leak", "creep"})
    assert verdict.probability == pytest.approx(0.97, abs=3e-3)


def test_what_is_sure_by_the_evidence_alone_is_not_sure_yet(as_evidence_says: Callable[..., None]) -> None:
    """A name that is often not there is no name though the evidence is certain: it is possible, or most probably it is
    something that labrig does not know.
    """
    certain = (answer(0.9995, "leak"), answer(0.0005, "creep"))
    for trust, verdict, names, rivals in (
        (-5.0, "identified", ("leak",), ()),
        (-6.0, "confounded", (), ("leak",)),
        (-8.0, "unknown", (), ()),
    ):
        as_evidence_says(leak=trust)
        found = told(*certain)
        p = found.considered[0].probability
        assert (found.verdict, found.effects, found.rivals) == (verdict, names, rivals)
        assert found.considered[0].by_evidence == pytest.approx(0.9995)
        assert found.found == names + rivals
        assert found.probability == pytest.approx(1 - p if verdict == "unknown" else p, abs=2e-3)


def test_what_is_sure_stays_where_nothing_else_is_possible(as_evidence_says: Callable[..., None]) -> None:
    """Though one of several others is there by the evidence, none may be worth a doubt: what is sure is named."""
    as_evidence_says(creep=-9.0, drift=-9.0)
    verdict = told(answer(0.5, "leak", "creep"), answer(0.5, "leak", "drift"))
    assert (verdict.verdict, verdict.effects, verdict.rivals) == ("identified", ("leak",), ())


def test_partners_stay_partners_where_neither_is_sure_any_more() -> None:
    """Of two that were sure together, whose formulas help by chance, neither is the other's rival: both are fitted."""
    both = told(answer(0.98, "leak", "creep"), answer(0.02, "leak"))
    assert (both.verdict, both.rivals) == ("multiple", ())
    less = less_sure(both, {"leak", "creep"})
    assert less.verdict == "confounded"
    assert set(less.rivals) == set(less.together) == set(less.added) == {"leak", "creep"}


def test_partners_are_no_rivals(as_evidence_says: Callable[..., None]) -> None:
    """Two effects that the evidence has together are both fitted, though neither name is sure; a third that stands in
    for one of them is an alternative, and beside what is sure a single partner is one, too.
    """
    as_evidence_says(leak=-4.0, creep=-4.0)
    both = (answer(0.96, "leak", "creep"), answer(0.03, "leak", "drift"), answer(0.01, "creep"))
    verdict = told(*both)
    assert (verdict.verdict, verdict.effects) == ("confounded", ())
    assert set(verdict.together) == {"leak", "creep"}
    assert set(verdict.added) == {"leak", "creep"}
    as_evidence_says(creep=-6.0)
    beside = told(answer(0.999, "leak", "creep"), answer(0.001, "leak"))
    assert (beside.verdict, beside.effects, beside.rivals) == ("confounded", ("leak",), ("creep",))
    assert beside.added == ("leak", "creep")
    assert taken_back(beside, {"leak": "what is ahead"}).together == ("creep",)
    as_evidence_says()
    either = told(answer(0.55, "leak"), answer(0.45, "creep"))
    assert (either.verdict, either.together, either.added) == ("confounded", (), ("leak",))
    less = told(answer(0.4, "leak", "creep"), answer(0.31, "leak"), answer(0.29, "creep"))
    assert (less.verdict, less.together) == ("confounded", ())


def test_confounded() -> None:
    """Two effects, one in each of two likely answers, are rivals; so they are beside one that is sure."""
    verdict = told(answer(0.6, "leak"), answer(0.38, "creep"), answer(0.02, "drift"))
    assert (verdict.verdict, verdict.effects, verdict.rivals) == ("confounded", (), ("leak", "creep"))
    assert verdict.probability == pytest.approx(1 - 0.4 * 0.62)
    assert verdict.found == ()
    verdict = told(
        answer(0.5, "hysteresis", "leak"), answer(0.47, "hysteresis", "creep"), answer(0.03, "leak")
    )
    assert (verdict.verdict, verdict.effects) == ("confounded", ("hysteresis",))
    assert verdict.rivals == ("leak", "creep")


def test_unknown() -> None:
    """Something without a name is unknown, alone or beside a smaller name; what carries it is said."""
    for answers in (
        (answer(1.0, beside="?history"),),
        (answer(0.97, "leak", beside="?history"), answer(0.03, "leak")),
    ):
        verdict = told(*answers)
        assert (verdict.verdict, verdict.effects, verdict.carried_by) == ("unknown", (), "history")
        assert verdict.probability == pytest.approx(answers[0].probability, abs=2e-3)
        assert verdict.beside == {"history": pytest.approx(2 * LARGE * answers[0].probability)}


def test_what_fits_a_part_of_the_unknown_is_said() -> None:
    """Beside something larger without a name, an effect that is needed for a part is kept, with its size; no other."""
    verdict = told(
        answer(0.95, "leak", beside="?history", creep=SMALL), answer(0.05, "leak", "drift", beside="?history")
    )
    assert (verdict.verdict, verdict.effects) == ("unknown", ())
    assert verdict.within == {"leak": pytest.approx(LARGE)}
    assert told(answer(0.7, "leak", beside="?history"), answer(0.3, beside="?history")).within == {}


@pytest.mark.parametrize("beside", ["?history", "?time"])
def test_a_name_larger_than_what_has_none_keeps_it(beside: str) -> None:
    """A name stands beside unnamed structure that is smaller; how large that is, and what carries it, is said."""
    verdict = told(answer(1.0, "leak", beside=beside, unnamed=0.5 * LARGE))
    assert (verdict.verdict, verdict.effects) == ("identified", ("leak",))
    assert verdict.beside == {WORDS[beside]: pytest.approx(0.5 * LARGE)}
    assert told(answer(1.0, "leak", beside=beside, unnamed=1.6 * LARGE)).verdict == "unknown"


def test_the_bases_own_form_outvotes_no_name() -> None:
    """That the base is wrong in form is no mystery: however large, it stands beside a name; alone, it is unknown."""
    verdict = told(answer(1.0, "leak", beside="?form", unnamed=1.6 * LARGE))
    assert (verdict.verdict, verdict.effects) == ("identified", ("leak",))
    assert verdict.beside == {WORDS["?form"]: pytest.approx(1.6 * LARGE)}
    assert told(answer(1.0, beside="?form", unnamed=1.6 * LARGE)).verdict == "unknown"


def test_what_is_too_small_has_no_name() -> None:
    """An effect that is in every answer, but hardly, is not missing; its probability is that it is worth a name."""
    verdict = told(answer(1.0, leak=SMALL))
    assert verdict.verdict == "nothing_missing"
    assert chances(verdict) == {}
    assert chances(told(answer(0.5, "leak"), answer(0.5, leak=SMALL))) == {"leak": 0.5}


def test_sizes_are_means_over_the_answers() -> None:
    """The size of an effect is its mean over the answers that have it, its sd within and between them together."""
    verdict = told(answer(0.75, leak=10.0), answer(0.25, leak=14.0))
    found = verdict.considered[0]
    assert (found.effect, found.size_floors) == ("leak", pytest.approx(11.0))
    assert found.size_sd_floors == pytest.approx(np.sqrt(0.5**2 + 3.0))


def test_calls_follow_probabilities() -> None:
    """Sure, possible and not it begin where the constants say."""
    calls = [
        Considered("leak", p).call for p in (1.0, k.SURE, k.SURE - 1e-9, k.POSSIBLE, k.POSSIBLE - 1e-9, 0.0)
    ]
    assert calls == ["sure", "sure", "possible", "possible", "not it", "not it"]


@given(
    st.lists(
        st.tuples(st.floats(0.01, 1.0), st.sets(st.sampled_from(EFFECTS), max_size=3)), min_size=1, max_size=6
    )
)
def test_what_is_named_is_what_is_sure(drawn: list[tuple[float, set[str]]]) -> None:
    """Whatever the answers, no name is given that is not sure, no rival that is not possible."""
    total = sum(p for p, _ in drawn)
    verdict = told(*[answer(p / total, *sorted(names)) for p, names in drawn])
    p = chances(verdict)
    assert all(p[name] >= k.SURE - 1e-6 for name in verdict.effects)
    assert all(p[name] >= k.POSSIBLE - 1e-6 for name in verdict.rivals)
    assert not set(verdict.effects) & set(verdict.rivals)
    assert 0 <= verdict.probability <= 1 + 1e-9
    assert (verdict.verdict in {"identified", "multiple"}) <= bool(verdict.effects)
    assert (verdict.verdict == "confounded") == bool(verdict.rivals)


@pytest.mark.parametrize(("captures", "rows"), [(2, 6), (12, 1), (1, 3)])
def test_too_few_numbers_say_nothing(make_lab, captures: int, rows: int) -> None:
    """Two captures, or twelve rows, name nothing however large the error; what to measure is said."""
    lab = make_lab(captures=captures, rows_s=tuple(1.5 * np.arange(2, rows + 2)), repeats=False)
    values = lab.predict(lab.u * (1 - 0.05 * lab.hold_s[:, :, None])) + lab.noise()
    summary = diagnose(lab.dataset(values), lab.model()).summary
    assert (summary["verdict"], summary["effects"], summary["rivals"]) == ("underpowered", [], [])
    assert summary["drop"] <= 1
    said = next(w for w in summary["warnings"] if "can't tell effects apart" in w)
    assert said.startswith(f"{captures} capture{'s' * (captures > 1)} with ")
    assert f"measure at least {k.FEWEST_OBSERVATIONS}, some set-points twice" in said


def measured(count: int, observables: int = 1) -> Any:
    """So many observations."""
    return cast(
        Any, SimpleNamespace(values=np.zeros((count, observables)), n_captures=count, conditions=count)
    )


def test_a_tolerance_below_what_can_be_seen_is_underpowered() -> None:
    """The smallest effect that could be shown is said in units; a tolerance above it is answered."""
    least = detectable_floors(measured(100))
    verdict = underpowered(measured(100), EFFECTS, 0.5 * least, "mm", 2.0)
    assert verdict is not None
    assert verdict.verdict == "underpowered"
    assert verdict.warnings[0].startswith("the smallest effect that these captures could show is ")
    assert f"larger than the tolerance of {least:.2g} mm" in verdict.warnings[0]
    assert underpowered(measured(100), EFFECTS, 2 * least, "mm", 2.0) is None
    assert underpowered(measured(100), EFFECTS, 0.0, "mm", 2.0) is None


def test_more_captures_show_less() -> None:
    """The smallest effect that can be shown falls as more is measured, down to what is worth a name at all."""
    sizes = [detectable_floors(measured(n)) for n in (30, 100, 300, 10_000, 10**7)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > 2 * sizes[2]
    assert sizes[-1] >= k.LEAST_FLOORS


@given(st.floats(0, 1e3), st.floats(0, 1e3), st.floats(0, 1e3))
def test_a_drop_is_never_more_than_all(base: float, now: float, reachable: float) -> None:
    """However the errors lie, the share of the explainable error that is gone is at most one, and none of nothing."""
    assert drop_of(base, now, reachable) <= 1 + 1e-9
    if base <= reachable:
        assert drop_of(base, now, reachable) == 0
    if now <= reachable < 0.9 * base:
        assert drop_of(base, now, reachable) == pytest.approx(1.0)
    if now > base and reachable < 0.9 * base:
        assert drop_of(base, now, reachable) < 0


@pytest.mark.parametrize(("hidden", "doubted"), [(0.0, True), (0.03, False)])
def test_a_name_whose_formula_helps_nothing_is_not_sure(make_lab, hidden: float, doubted: bool) -> None:
    """A leak that the evidence is sure of is possible only where adding it lowers the held-out error no more than
    chance, and is not added.
    """
    lab = make_lab(captures=40, long_s=(3.0, 4.0, 6.0, 10.0, 20.0, 40.0))
    left = np.maximum(np.sqrt(lab.u) - hidden * lab.hold_s[:, :, None], 0.0) ** 2
    model = lab.model()
    ready = prepared(rows_from(lab.dataset(lab.predict(left) + lab.noise())), model)
    ready, observations, _ = laid_out(ready, model.library())
    verdict = Verdict(
        "identified", ("leak",), 0.9, considered=(Considered("leak", 0.9), Considered("creep", 0.1))
    )
    said = result_of(ready, observations, verdict, model, model.library())
    found = said.summary
    assert (found["verdict"], found["effects"]) == (
        ("confounded", []) if doubted else ("identified", ["leak"])
    )
    assert found["rivals"] == (["leak", "creep"] if doubted else [])
    assert found["effects_considered"][0]["probability"] == (0.5 if doubted else 0.9)
    assert (said.improved is None) == doubted
    notes = [note for note in said.summary["warnings"] if note.startswith("with leak added")]
    assert bool(notes) == doubted
    if notes:
        assert re.fullmatch(
            r"with leak added, the held-out error falls no more than by chance \(by -?[\d.e-]+ mm, needed [\d.]+ mm\): "
            r"captures that were left out bear out no formula of it, so it is not sure, and nothing is added for it",
            notes[0],
        )


def test_a_name_without_a_formula_on_these_runs_is_still_named(make_lab) -> None:
    """Where a family is wider than its formulas, the diagnosis says what it found, adds the rest, and says so."""
    lab = make_lab(
        captures=40, long_s=(3.0, 4.0, 6.0, 10.0, 20.0, 40.0), force=True
    )  # no markers that could slip
    left = np.maximum(np.sqrt(lab.u) - 0.03 * lab.hold_s[:, :, None], 0.0) ** 2
    model = lab.model()
    ready = prepared(rows_from(lab.dataset(lab.predict(left) + lab.noise())), model)
    ready, observations, _ = laid_out(ready, model.library())
    for names, kept in ((("marker_slip", "leak"), ["leak"]), (("marker_slip",), [])):
        verdict = Verdict("multiple" if kept else "identified", names, 1.0)
        said = result_of(ready, observations, verdict, model, model.library())
        assert said.summary["effects"] == list(names)
        assert ([entry.name for entry in said.improved.file.effects] if said.improved else []) == kept
        assert (
            "no formula of marker_slip can act on these runs: it is named, and nothing is added to the model for it"
            in said.summary["warnings"]
        )


def test_few_numbers_weigh_explanations() -> None:
    """Fewer than 25 numbers decide between explanations, and each name says what it means."""
    body = ast.parse(Path(k.__file__).read_text(encoding="utf-8")).body[1:]
    assert all(isinstance(line, ast.Assign) for line in body[::2])
    assert all(isinstance(line, ast.Expr) for line in body[1::2])
    values = [line.value for line in body[::2] if isinstance(line, ast.Assign)]
    each = [part for value in values for part in (value.elts if isinstance(value, ast.Tuple) else [value])]
    assert 0 < sum(isinstance(part, ast.Constant) for part in each) < 25
