"""A verdict in words."""

import pytest

from labrig.view._words import has_improved, listed, note, number, percent, summary_words

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


@pytest.mark.parametrize(
    ("changes", "headline"),
    [
        ({"verdict": "nothing_missing"}, "Nothing is missing: the model is as good as the measurements."),
        ({"verdict": "identified", "effects": ["marker_slip"]}, "Marker slip is missing from the model."),
        ({"verdict": "multiple", "effects": ["creep", "leak"]}, "Creep and leak are missing from the model."),
        (
            {"verdict": "confounded", "effects": ["drift"], "rivals": ["drift", "creep"]},
            "Something is missing, and these data cannot tell drift and creep apart.",
        ),
        (
            {"verdict": "unknown"},
            "Something real is missing, and it is none of the effects that labrig knows.",
        ),
        ({"verdict": "underpowered"}, "These data are too few or too noisy to tell."),
        ({"effects": ["creep"]}, "With creep the held-out error falls from 2\u00a0mm to 0.3\u00a0mm."),
        ({}, "The model as it stands is off by 0.3\u00a0mm; repeats differ by 0.1\u00a0mm."),
    ],
)
def test_headline(changes, headline):
    """Each verdict, an improvement and a comparison have a headline of their own."""
    assert note({**BASE, **changes}).headline == headline


def test_why_gives_the_figures():
    """The reason names the error before and after, the floor, and the share explained."""
    why = note({**BASE, "verdict": "identified", "effects": ["creep"]}).why
    assert why == (
        "On captures that were held out from the fit, the error falls from 2\u00a0mm to 0.3\u00a0mm with creep added; "
        "repeats of one set-point differ by 0.1\u00a0mm. That explains 92 % of what can be explained."
    )


def test_only_places_that_stand_out_are_named():
    """A place that is no worse than the rest is not called the place where it fails."""
    places = [
        {"group": "marker", "name": "m17", "error": 4.0, "share": 0.2, "clear": True},
        {"group": "chamber", "name": "c1 above half", "error": 2.1, "share": 0.5, "clear": True},
        {"group": "time in hold", "name": "0-3 s", "error": 9.0, "share": 0.5, "clear": False},
    ]
    why = note({**BASE, "verdict": "identified", "effects": ["creep"], "where": places}).why
    assert why.endswith("It fails most at marker m17 (4\u00a0mm).")


def test_the_runner_up_is_named():
    """What else it could be says how far the next best explanation comes."""
    ranking = [{"effect": "creep", "heldout_error": 0.3}, {"effect": "rest_shape", "heldout_error": 0.9}]
    words = note({**BASE, "verdict": "identified", "effects": ["creep"], "ranking": ranking})
    assert words.else_ == (
        "Nothing else comes near: the next best explanation, rest shape, leaves 0.9 mm on the same captures."
    )


def test_a_close_runner_up_is_called_close():
    """A runner-up that leaves hardly more than the winner is not said to be far off."""
    ranking = [{"effect": "creep", "heldout_error": 0.3}, {"effect": "drift", "heldout_error": 0.33}]
    words = note({**BASE, "verdict": "identified", "effects": ["creep"], "ranking": ranking})
    assert words.else_.startswith("One comes near: the next best explanation, drift, leaves 0.33 mm")


def test_rivals_are_said_before_runners_up():
    """Where rivals are named, the note does not claim that nothing comes near."""
    words = note({**BASE, "verdict": "identified", "effects": ["creep"], "rivals": ["drift"]})
    assert words.else_ == "It could also be drift: the evidence against is weaker than labrig asks for."


def test_the_next_experiment_is_what_the_diagnosis_designed():
    """Probes that the diagnosis names are put into a sentence, each once."""
    planned = {"separates": ["creep", "drift"], "probes": ["hold 3 and 300 s", "wait", "wait"]}
    words = note({**BASE, "verdict": "confounded", "rivals": ["creep", "drift"], "next_experiment": planned})
    assert words.next_ == (
        "To tell creep and drift apart: hold 3 and 300 s; or wait. `labrig next` makes a procedure of it."
    )


def test_lines_for_a_terminal():
    """A command prints the verdict with its effect and how sure it is."""
    lines = summary_words({**BASE, "verdict": "identified", "effects": ["creep"]})
    assert lines.found == "identified: creep (97 % sure)"
    lines = summary_words({**BASE, "verdict": "confounded", "effects": ["frame"], "rivals": ["rest_shape"]})
    assert lines.found == "confounded: frame or rest shape (97 % sure)"


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


def test_listed():
    """Names are joined as in a sentence, without underscores."""
    assert listed(["creep", "marker_slip", "leak"]) == "creep, marker slip and leak"


def test_has_improved_needs_a_fall():
    """There is a before and an after only if the error fell."""
    assert has_improved(BASE)
    assert not has_improved({"error": {"base": 2.0, "model": 2.0}})
    assert not has_improved({"error": {"model": 2.0}})
