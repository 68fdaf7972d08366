"""A verdict in words."""

import pytest

from labrig._text import chance, give_or_take, listed, number, percent
from labrig.view._others import what_else
from labrig.view._words import has_improved, note

BASE = {
    "units": "mm",
    "error": {"base": 2.0, "model": 0.3, "floor": 0.1, "ceiling": 0.15},
    "probability": 0.97,
    "effects": [],
    "rivals": [],
    "where": [],
    "ranking": [],
    "next_experiment": None,
}
PERHAPS = {"effect": "frame", "probability": 0.4, "call": "possible"}


@pytest.mark.parametrize(
    ("changes", "headline"),
    [
        ({"verdict": "nothing_missing"}, "Nothing is missing: the model is as good as the measurements."),
        (
            {"verdict": "nothing_missing", "effects_considered": [PERHAPS]},
            "Nothing is surely missing: the model is nearly as good as the measurements, and frame may be missing.",
        ),
        (
            {"verdict": "nothing_missing", "left_out_share": 0.14},
            "Nothing is missing beside 14 % of the values, which were left out as mistaken.",
        ),
        ({"verdict": "identified", "effects": ["marker_slip"]}, "Marker slip is missing from the model."),
        ({"verdict": "multiple", "effects": ["creep", "leak"]}, "Creep and leak are missing from the model."),
        (
            {"verdict": "confounded", "rivals": ["drift", "creep"]},
            "An effect is missing, and these data do not determine which: drift or creep.",
        ),
        (
            {"verdict": "confounded", "rivals": ["drift"]},
            "An effect is missing: perhaps drift, or one that labrig does not know.",
        ),
        (
            {"verdict": "confounded", "effects": ["leak"], "rivals": ["drift", "creep"]},
            "Leak is missing, and these data do not determine whether drift or creep is missing too.",
        ),
        (
            {"verdict": "confounded", "rivals": ["drift", "creep", "leak", "delay", "frame"]},
            "An effect is missing, and these data do not determine which: drift, creep, leak or one of 2 others.",
        ),
        (
            {"verdict": "unknown"},
            "An effect is missing, and it is none of those that labrig knows.",
        ),
        (
            {"verdict": "unknown", "effects_considered": [PERHAPS]},
            "An effect is missing, more probably none of those that labrig knows.",
        ),
        ({"verdict": "underpowered"}, "The data are too few or too noisy for a verdict."),
        ({"effects": ["creep"]}, "With creep the held-out error falls from 2\u00a0mm to 0.3\u00a0mm."),
        ({}, "The model's error is 0.3\u00a0mm; the noise floor is 0.1\u00a0mm."),
    ],
)
def test_headline(changes, headline):
    """Each verdict, an improvement and a comparison have a headline of their own."""
    assert note({**BASE, **changes}).headline == headline


def test_why_gives_the_figures():
    """The reason names the error before and after, the floor, and the share explained."""
    why = note({**BASE, "verdict": "identified", "effects": ["creep"]}).why
    assert why == (
        "The held-out error falls from 2\u00a0mm to 0.3\u00a0mm with creep added; the noise floor is 0.1\u00a0mm. "
        "That is 92 % of the explainable error."
    )


def test_only_places_that_stand_out_are_named():
    """A place that is no worse than the rest is not called the place where it fails."""
    places = [
        {"group": "marker", "name": "m17", "error": 4.0, "share": 0.2, "clear": True},
        {"group": "chamber", "name": "c1 above half", "error": 2.1, "share": 0.5, "clear": True},
        {"group": "time in hold", "name": "0 to 3 s", "error": 9.0, "share": 0.5, "clear": False},
    ]
    why = note({**BASE, "verdict": "identified", "effects": ["creep"], "where": places}).why
    assert why.endswith("The model as it was fails most at marker m17 (4\u00a0mm).")


def test_the_runner_up_is_named():
    """What else it could be says how far the next best explanation comes."""
    ranking = [{"effect": "creep", "heldout_error": 0.3}, {"effect": "rest_shape", "heldout_error": 0.9}]
    words = note({**BASE, "verdict": "identified", "effects": ["creep"], "ranking": ranking})
    assert words.else_ == (
        "The best alternative, rest shape alone, is clearly worse: it leaves 0.9 mm on the same captures."
    )


def test_a_close_runner_up_is_called_close():
    """A runner-up that leaves hardly more than the winner is not said to be far off."""
    ranking = [{"effect": "creep", "heldout_error": 0.3}, {"effect": "drift", "heldout_error": 0.33}]
    words = note({**BASE, "verdict": "identified", "effects": ["creep"], "ranking": ranking})
    assert words.else_.startswith("The best alternative, drift alone, is close: it leaves 0.33 mm")


def test_a_better_runner_up_is_not_kept_back():
    """Where another effect alone leaves less than the answer, the note says so."""
    ranking = [{"effect": "creep", "heldout_error": 0.3}, {"effect": "drift", "heldout_error": 0.2}]
    words = note({**BASE, "verdict": "identified", "effects": ["creep"], "ranking": ranking})
    assert words.else_.startswith("Drift alone leaves less (0.2 mm), although the evidence as a whole")


def test_one_of_several_that_does_it_all():
    """Where one of several effects leaves hardly more than all together, the note says so."""
    ranking = [{"effect": "leak", "heldout_error": 0.31}, {"effect": "creep", "heldout_error": 1.2}]
    words = note({**BASE, "verdict": "multiple", "effects": ["creep", "leak"], "ranking": ranking})
    assert words.else_.startswith("Leak alone leaves 0.31 mm, hardly more than all of them")


def test_why_says_what_was_added_to_a_doubt():
    """For a confounded verdict the reason says that the likeliest of what is possible was added."""
    why = note({**BASE, "verdict": "confounded", "effects": ["leak"], "rivals": ["drift", "creep"]}).why
    assert "to 0.3\u00a0mm with leak and drift, the likeliest of what is possible, added;" in why


def test_the_next_experiment_is_what_the_diagnosis_designed():
    """Probes that the diagnosis names are put into a sentence, each once."""
    planned = {"separates": ["creep", "drift"], "probes": ["hold 3 and 300 s", "wait", "wait"]}
    words = note({**BASE, "verdict": "confounded", "rivals": ["creep", "drift"], "next_experiment": planned})
    assert words.next_ == (
        "To tell creep and drift apart: hold 3 and 300 s; or wait. `labrig next` makes a procedure of it."
    )


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"unsettled": []}, "2 captures would tell creep and drift apart: wait. "),
        (
            {"unsettled": ["creep from drift"]},
            "2 captures aims to tell creep and drift apart, and may not settle it by itself: wait. ",
        ),
        ({}, "2 captures aims to tell creep and drift apart, and may not settle it by itself: wait. "),
    ],
)
def test_a_programme_promises_no_more_than_is_expected_of_it(said, words):
    """Where it may not settle the doubt, the sentence has the same caution as the programme's own report."""
    programme = [{"probe": "wait", "separates": "creep from drift", "times": 1, "minutes": 1.0}]
    planned = {"separates": ["creep", "drift"], "programme": programme, "minutes": 1.0, "captures": 2, **said}
    assert words in note({**BASE, "verdict": "confounded", "next_experiment": planned}).next_


def test_an_error_that_rises_is_not_said_to_fall():
    """Where no formula follows what is seen, the error may be larger with it: it is said so."""
    why = note(
        {**BASE, "verdict": "identified", "effects": ["creep"], "error": {"base": 1.0, "model": 3.0}}
    ).why
    assert "The held-out error rises from 1\u00a0mm to 3\u00a0mm with creep added" in why


def test_after_a_sudden_change_look_at_the_rig():
    """What happened at one moment is not found by a programme of pressures: the advice is to look there."""
    words = note({**BASE, "verdict": "unknown", "carried_by": "a sudden change before capture 12"})
    assert words.next_.startswith("Look at what happened to the rig at that moment: hoses, seams")


def test_what_is_sure_needs_no_telling_apart():
    """The next experiment is about what is possible, not about what is sure."""
    planned = {"separates": ["leak", "drift"], "probes": ["wait"]}
    doubt = {**BASE, "verdict": "confounded", "effects": ["leak"], "rivals": ["drift"]}
    assert note({**doubt, "next_experiment": planned}).next_.startswith(
        "To learn whether drift is there too: "
    )


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.9234, "1.92"),
        (0.0, "0"),
        (12345.6, "12346"),
        (4.2e-7, "4.20e-07"),
        (float("nan"), "–"),
        (None, "–"),
    ],
)
def test_number(value, text):
    """Numbers have three significant digits; what is not known is a dash."""
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(0.97, "97 %"), (0.999, "over 99 %"), (0.001, "under 1 %"), (None, "–")]
)
def test_percent_is_never_certain(value, text):
    """A probability is never said to be 0 or 100 %."""
    assert percent(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.7499, "74 %"), (0.75, "75 %"), (0.0999, "9 %"), (0.29, "29 %"), (0.0, "under 1 %"), (None, "–")],
)
def test_a_chance_never_reaches_a_limit_that_it_does_not(value, text):
    """A doubt just below a limit is not said to be as probable as what is sure, or possible, from there on."""
    assert chance(value) == text


def test_listed():
    """Names are joined as in a sentence, without underscores."""
    assert listed(["creep", "marker_slip", "leak"]) == "creep, marker slip and leak"


def test_has_improved_needs_a_fall():
    """There is a before and an after only if the error fell."""
    assert has_improved(BASE)
    assert not has_improved({"error": {"base": 2.0, "model": 2.0}})
    assert not has_improved({"error": {"model": 2.0}})


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (2.114, 0.0999, "2.1 ± 0.1"),
        (169.17, 3.56, "169 ± 4"),
        (1234.0, 260.0, "1200 ± 300"),
        (0.3, None, "0.3"),
        (0.0, 0.2, "0.0 ± 0.2"),
        (None, None, "–"),
    ],
)
def test_give_or_take(value, sd, text):
    """A value is given to the place of its standard deviation's first digit."""
    assert give_or_take(value, sd) == text


def test_a_single_name_that_is_only_possible_asks_for_a_new_run():
    """Other laws look like it, and the page says so; of several that are possible it says that one may be wrong."""
    one, two = PERHAPS, {"effect": "drift", "probability": 0.3, "call": "possible"}
    for rows, start in (
        (
            [one],
            "Frame is consistent with these data, and other laws look much the same: confirm it on a new run",
        ),
        ([one, two], "Each of the possible effects is consistent with these data."),
    ):
        rivals = [row["effect"] for row in rows]
        summary = {**BASE, "verdict": "confounded", "rivals": rivals, "effects_considered": rows}
        assert what_else(summary).startswith(start)
