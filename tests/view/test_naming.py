"""Sure, possible, not it: the sentences about each effect, from hand-made summaries."""

import pytest

from labrig.diagnosis._problem import ASTRAY
from labrig.effects import library
from labrig.view import UNSEEN, added, astray, effect_rows, names_in_short, summary_words, unseen_words
from labrig.view._naming import carries
from labrig.view._words import note

ERROR = {"base": 2.1, "model": 0.3, "floor": 0.1, "ceiling": 0.15}


@pytest.fixture
def make_summary(make_considered):
    """Make a summary of a verdict; probabilities of effects by name, other keys as `more`."""

    def make(verdict, probability, more=None, **probabilities):
        rows = make_considered(**probabilities)
        sure = [row["effect"] for row in rows if row["call"] == "sure"]
        possible = [row["effect"] for row in rows if row["call"] == "possible"]
        return {
            "verdict": verdict,
            "probability": probability,
            "effects": sure if verdict in ("identified", "multiple", "confounded") else [],
            "rivals": possible if verdict == "confounded" else [],
            "effects_considered": rows,
            "unnamed": {},
            "units": "mm",
            "error": ERROR,
            "where": [],
            "ranking": [],
            "next_experiment": None,
            **(more or {}),
        }

    return make


@pytest.mark.parametrize(
    ("verdict", "probability", "effects", "found"),
    [
        (
            "identified",
            0.6,
            {"hysteresis": 0.998, "regulator": 0.34, "stiffening": 0.12, "creep": 0.04},
            "identified: hysteresis, sure (over 99 %, 2.0 ± 0.1 mm); possible beside it: regulator (34 %), "
            "stiffening (12 %), neither needed nor ruled out",
        ),
        (
            "multiple",
            0.9,
            {"creep": 0.97, "marker_slip": 0.95},
            "several effects: creep, sure (97 %, 2.0 ± 0.1 mm) and marker slip, sure (95 %, 2.0 ± 0.1 mm)",
        ),
        (
            "confounded",
            0.1,
            {"frame": 0.52, "rest_shape": 0.41},
            "confounded: nothing is sure; possible: frame (52 %), rest shape (41 %); these data do not determine it",
        ),
        (
            "confounded",
            0.55,
            {"leak": 0.99, "drift": 0.5},
            "confounded: leak, sure (99 %, 2.0 ± 0.1 mm); possible beside it: drift (50 %); "
            "these data do not determine it",
        ),
        ("nothing_missing", 0.97, {"creep": 0.02}, "nothing missing: 97 % sure"),
        (
            "unknown",
            0.8,
            {"leak": 0.95},
            "unknown effect: an effect that labrig does not know, 80 % sure; leak, sure (95 %, 2.0 ± 0.1 mm)",
        ),
        ("underpowered", 1.0, {"leak": 0.0}, "too few data: the data are too few or too noisy"),
    ],
)
def test_what_is_found(make_summary, verdict, probability, effects, found):
    """One line says what is sure and what is possible, each with the probability that is its own."""
    said = summary_words(make_summary(verdict, probability, **effects)).found
    assert said.replace("\u00a0", " ") == found


@pytest.mark.parametrize(
    ("verdict", "effects", "whole"),
    [
        ("identified", {"creep": 0.98, "leak": 0.3}, "Probability of creep and nothing else: 70 %."),
        ("multiple", {"creep": 0.98, "leak": 0.95}, "Probability of creep and leak and nothing else: 70 %."),
        (
            "confounded",
            {"creep": 0.4, "leak": 0.4},
            "Probability that at least one of the possible effects is missing: 70 %.",
        ),
        ("confounded", {"creep": 0.98, "leak": 0.6}, ""),
        ("nothing_missing", {}, ""),
        ("unknown", {}, ""),
    ],
)
def test_the_probability_of_the_whole(make_summary, verdict, effects, whole):
    """The verdict's own probability stands beside the very thing that it is of."""
    assert summary_words(make_summary(verdict, 0.7, **effects)).whole == whole


@pytest.mark.parametrize(
    ("verdict", "record", "whole"),
    [
        (
            "identified",
            {"right": 25, "of": 46, "there": 32},
            "Probability of creep and nothing else: 70 %. On laws and rigs that nothing was learnt from, what such a "
            "verdict names was there 32 times of 46, and nothing else 25 times.",
        ),
        (
            "unknown",
            {"right": 33, "of": 39},
            "On laws and rigs that nothing was learnt from, 33 of 39 such verdicts were right.",
        ),
        ("confounded", None, ""),
    ],
)
def test_how_often_such_a_verdict_was_right(make_summary, verdict, record, whole):
    """Beside the probability, which takes the families for granted, stands what was counted."""
    summary = make_summary(verdict, 0.7, creep=0.98) | {"track_record": record}
    assert summary_words(summary).whole == whole


def test_how_often_a_name_was_right(make_summary):
    """Beside each name that is sure stands how often it was right where it was sure, and beside no other."""
    summary = make_summary("multiple", 0.7, creep=0.98, rest_shape=0.97, leak=0.4)
    for row, there in zip(summary["effects_considered"], (14, 9, 1), strict=True):
        row["track_record"] = {"there": there, "of": 14}
    whole = (
        "Probability of creep and rest shape and nothing else: 70 %. On laws and rigs that nothing was learnt from, "
        "creep was sure 14 times, and there 14 times; rest shape was sure 14 times, and there 9 times."
    )
    assert summary_words(summary).whole == whole
    summary["effects_considered"][1]["track_record"] = {"there": 0, "of": 3}  # three times say nothing
    assert summary_words(summary).whole == whole.replace(
        "; rest shape was sure 14 times, and there 9 times", ""
    )


def test_one_name_that_is_left_is_a_perhaps(make_summary):
    """Where one name is all that fits, nothing is left to determine: it is added, and confirmed on another run."""
    summary = make_summary("confounded", 0.68, contact=0.68, creep=0.02)
    said = note(summary)
    assert summary_words(summary).named == "perhaps contact (68 %), or an effect that labrig does not know"
    assert said.headline == "An effect is missing: perhaps contact, or one that labrig does not know."
    assert said.next_.startswith(
        "Experiment that isolates it: small steps of one chamber around the limit. To confirm"
    )
    two = make_summary("confounded", 0.68, contact=0.68, creep=0.2)
    assert "these data do not determine it" in summary_words(two).named


def test_a_sudden_change_is_looked_at_not_probed(make_summary):
    """What changed at one moment, set-points do not tell: the person looks, also where a programme was proposed."""
    planned = {"programme": [{"probe": "p1: one large step"}], "minutes": 3.0, "captures": 4, "separates": []}
    more = {"carried_by": "a sudden change before capture 52", "next_experiment": planned}
    assert note(make_summary("unknown", 0.9, more)).next_.startswith(
        "Look at what happened to the rig at that moment"
    )


def test_what_could_not_be_seen_is_not_said_to_be_absent(make_summary):
    """An effect that the runs have nothing to be seen by stands apart, with what it needs, and has no probability."""
    summary = make_summary("identified", 0.9, creep=0.95, marker_slip=0.0, contact=0.0)
    assert unseen_words(summary) == ""
    summary["effects_considered"][1]["seen"] = False
    assert unseen_words(summary) == "can't be seen in these runs: marker slip (needs two markers or more)"
    summary["runs"] = [{"run": "second", "id": "2", "ruled_out": ["marker_slip"]}]
    words = "marker slip (needs a run in which it was not ruled out)"
    assert unseen_words(summary) == f"can't be seen in these runs: {words}"
    summary["runs"].append({"run": "first", "id": "1"})
    assert "ruled out" not in unseen_words(summary)
    assert [row[:3] for row in effect_rows(summary)] == [
        ("creep", "sure", "95 %"),
        ("marker slip", UNSEEN, "–"),
        ("contact", "not it", "under 1 %"),
    ]


def test_what_has_no_name(make_summary):
    """Structure without a name is said in plain words with its size, the largest first; traces are not spoken of."""
    unnamed = {"form": 0.21, "history": 0.432, "time": 0.004, "the weather": 0.1}
    more = {"unnamed": unnamed, "error": {**ERROR, "model": 0.6}}
    said = summary_words(make_summary("identified", 0.9, more, creep=0.98)).unnamed
    assert said.replace("\u00a0", " ") == (
        "Unexplained by any effect: 0.43 mm depends on earlier pressures (history-dependent); 0.21 mm is a structural "
        "error of the base model: chambers move the rig in other patterns than it predicts; 0.1 mm is "
        "carried by the weather."
    )
    assert summary_words(make_summary("identified", 0.9, creep=0.98)).unnamed == ""


def test_nothing_unnamed_is_larger_than_what_is_left(make_summary):
    """Beside named effects, what has no name is no larger than what the held-out error leaves above the floor."""
    unnamed = {"nothing that was recorded": 0.13}
    near = {"unnamed": unnamed, "error": {"base": 0.848, "model": 0.13, "floor": 0.126}}
    said = summary_words(make_summary("identified", 0.99, near, creep=0.99)).unnamed
    assert said.replace("\u00a0", " ") == "Unexplained by any effect: 0.032 mm follows no logged quantity."
    at = {"unnamed": unnamed, "error": {"base": 0.848, "model": 0.126, "floor": 0.126}}
    assert summary_words(make_summary("identified", 0.99, at, creep=0.99)).unnamed == ""
    assert "0.13" in summary_words(make_summary("unknown", 0.99, near)).unnamed


def test_unknown_beside_what_is_sure(make_summary):
    """Something unknown does not hide what is sure beside it."""
    summary = make_summary("unknown", 0.8, {"carried_by": "history"}, leak=0.95)
    words = note(summary)
    assert words.headline == "Besides leak, an effect is missing that is none of those that labrig knows."
    assert "The unexplained part depends on earlier pressures (history-dependent)." in words.why
    assert words.named.startswith("An effect that labrig does not know, 80 % sure; leak, sure (95 %")


def test_rows_of_words(make_summary):
    """Every effect is a row; one that is nowhere has no size, and where nothing was weighed there is no row."""
    rows = effect_rows(make_summary("identified", 0.9, creep=0.98, marker_slip=0.2, delay=0.0))
    assert rows == [
        ("creep", "sure", "98 %", "2.0 ± 0.1", "20 ± 1"),
        ("marker slip", "possible", "20 %", "2.0 ± 0.1", "20 ± 1"),
        ("delay", "not it", "under 1 %", "–", "–"),
    ]
    assert effect_rows(make_summary("underpowered", 1.0, creep=0.0)) == []


def test_names_for_a_cell(make_summary):
    """A cell of a table says what is sure, and what perhaps."""
    assert names_in_short(make_summary("identified", 0.9, creep=0.98)) == "creep (sure)"
    short = names_in_short(make_summary("confounded", 0.9, creep=0.98, leak=0.3, drift=0.2))
    assert short == "creep (sure); perhaps leak 30 % or drift 20 %"
    assert names_in_short(make_summary("confounded", 0.9, leak=0.3, drift=0.2)) == "leak 30 % or drift 20 %"
    assert names_in_short({"verdict": "", "effects": [], "rivals": []}) == ""


def test_an_older_diagnosis():
    """Of a file that has no effects_considered, what it names is said without figures."""
    older = {
        "verdict": "confounded",
        "effects": ["leak"],
        "rivals": ["drift"],
        "probability": 0.9,
        "error": {},
    }
    assert summary_words(older).found == (
        "confounded: leak, sure; possible beside it: drift; these data do not determine it"
    )


@pytest.mark.parametrize(
    ("carried", "why"),
    [
        ("single set-points that a chamber missed", "in which a chamber did not do what it was told"),
        ("captures that have each other's measurements", "that have each other's measurements"),
    ],
)
def test_what_single_captures_were_left_out_for(make_summary, carried, why):
    """Beside captures that are mistaken nothing is missing: that is said, and not that an effect is unknown."""
    words = summary_words(make_summary("unknown", 0.99, {"carried_by": carried}))
    assert words.headline == "Some captures are mistaken, and left out; beside them nothing is missing."
    assert words.named == "nothing is missing beside captures that were left out, 99 % sure"
    assert why in carries(carried)


def test_partners_are_not_called_alternatives(make_summary):
    """Two effects that fit together, neither of them surely, are both said to be missing, and both are in the model."""
    summary = make_summary("confounded", 0.9, creep=0.71, regulator=0.68, leak=0.2)
    summary["together"] = ["creep", "regulator"]
    words = summary_words(summary)
    assert (
        words.headline == "Effects are missing that fit together, none of them surely: creep and regulator."
    )
    assert words.named == (
        "nothing is sure; possible: creep (71 %), regulator (68 %), leak (20 %); creep and regulator fit together, "
        "none of them surely"
    )
    assert added(summary) == ["creep", "regulator"]
    summary["together"] = []
    assert added(summary) == ["creep"]
    assert "do not determine" in summary_words(summary).headline


def test_what_is_astray_is_called_alike_by_diagnosis_and_words(make_summary):
    """Whatever the diagnosis leaves single captures out for, the words know it."""
    assert all(astray(make_summary("unknown", 0.99, {"carried_by": why})) for why in ASTRAY)
    assert not astray(make_summary("unknown", 0.99, {"carried_by": "history"}))


@pytest.mark.parametrize(
    ("effect", "by_evidence", "said"),
    [("frame", 0.99, True), ("frame", 0.6, False), ("marker_slip", 0.999, False)],
)
def test_why_what_evidence_is_sure_of_is_not(
    make_summary, effect: str, by_evidence: float, said: bool
) -> None:
    """Beside a possible name that evidence alone is sure of stands why it is not; of others nothing is said, nor of one
    that such evidence makes sure, which is doubted for another reason.
    """
    summary = make_summary("confounded", 0.5, **{effect: 0.5, "creep": 0.03})
    summary["effects_considered"][0] |= {"by_evidence": by_evidence, "share": 1.0}
    why = (
        "Evidence alone makes frame 99 %, but such names were there less often, on laws that nothing was learnt from. "
        "Set-points alone never make it sure (57 % at most); what confirms it: "
        f"{library()['frame'].ruled_out_by}, and measure again (labrig next)."
    )
    assert summary_words(summary).whole == (why if said else "")
    sure = make_summary("identified", 0.9, frame=0.9)
    sure["effects_considered"][0] |= {"by_evidence": 0.99, "share": 1.0}
    assert "Evidence alone" not in summary_words(sure).whole
