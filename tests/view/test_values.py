"""Fitted values in words."""

import numpy as np
import pytest

from labrig.view._values import Fitted, leak_words, plain_words, values_words

CHAMBERS = [f"c{i}" for i in range(1, 6)]


def per_chamber(values, sds, unit="1"):
    """A parameter of each chamber."""
    return {"value": values, "sd": sds, "unit": unit, "per": CHAMBERS[: len(values)]}


def test_a_value_for_each_of_a_few_chambers():
    """A few chambers are named, each with its own value."""
    said = values_words({"gain": per_chamber([0.1, -0.2], [0.01, 0.02], "kPa")})
    assert said == "gain c1 0.100 ± 0.010\u00a0kPa, c2 -0.200 ± 0.020\u00a0kPa"


@pytest.mark.parametrize(
    ("since_s", "said"),
    [(44220.0, "12.3\u00a0h"), (300.0, "5\u00a0min"), (90.0, "90\u00a0s"), (0.0, "0\u00a0s")],
)
def test_a_moment_is_told_as_a_person_would(since_s: float, said: str) -> None:
    """When a marker slipped or a frame was moved is counted from the run's start, in hours where it is long."""
    words = values_words({"since_s": {"value": since_s, "unit": "s"}})
    assert words == f"since {said} after the start"


def test_of_many_chambers_the_largest():
    """Of more chambers the three with the largest values are named, the others by their range."""
    said = values_words({"gain": per_chamber([0.1, -0.9, 0.2, 0.5, 0.01], [0.1] * 5)})
    assert said == "gain c2 -0.90 ± 0.10, c4 0.50 ± 0.10, c3 0.20 ± 0.10, 2 others 0.01 to 0.1"


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        (
            {"loss": per_chamber([0.9, 0.01], [0.05, 0.02]), "tau_s": {"value": 30.0, "unit": "s"}},
            "c1 loses 3 % a second of its pressure at first (time constant 30 s); the other holds its own, as far as "
            "these data tell.",
        ),
        (
            {"loss": {"value": 1.0, "sd": 0.1, "unit": "1"}, "tau_s": {"value": 25000.0, "unit": "s"}},
            "Every chamber loses 0.24 % a minute of its pressure at first (time constant 25000 s).",
        ),
        (
            {
                "loss": {"value": 0.6, "sd": 0.1, "unit": "1"},
                "tau_s": {"value": 60.0, "unit": "s"},
                "chamber": {"value": 1.0, "unit": "1", "per": ["c2"]},
            },
            "c2 loses 1 % a second of its pressure at first (time constant 60 s).",
        ),
        (
            {"tau_s": per_chamber([100.0, 20.0], [1.0, 1.0], "s")},
            "c2 loses 5 % a second of its pressure at first (time constant 20 s); c1 loses 1 % a second of its "
            "pressure at first (time constant 100 s).",
        ),
        (
            {"sensor": {"value": 0.97, "sd": 0.01, "unit": "1"}},
            "Pressure is lost as the sensors measured it: 97 % of it reaches the surface.",
        ),
        (
            {"loss": per_chamber([0.01, 0.01], [0.05, 0.02]), "tau_s": {"value": 30.0, "unit": "s"}},
            "No single chamber leaks clearly.",
        ),
        ({}, ""),
    ],
)
def test_a_leak_says_which_chamber_and_how_fast(parameters, said):
    """The chambers that leak are named, the fastest first, with the share that escapes and the time constant."""
    assert leak_words(parameters).replace("\u00a0", " ") == said


def test_a_leak_without_a_formula_says_which_chamber_and_how_much() -> None:
    """Of a family's weights it is said what each chamber loses in a minute, or in the longest hold where that is less,
    the common part and its own together.
    """
    per = [
        "lost 60.0",
        "lost 20.0 root",
        "pocket 20.0",
        "lost 60.0 of c1",
        "lost 60.0 of c2",
        "lost 60.0 of c3",
    ]
    weights = {"value": [0.10, 0.05, 3.0, 0.2, -0.10, -0.18], "sd": [0.01] * 6, "per": per, "unit": "1"}
    said = plain_words("leak", {"weights": weights}).replace("\u00a0", " ")
    minute, whole = 1 - np.exp(-1), 1 - np.exp(-3)
    first, second = (round(100 * (own * minute + 0.05 * whole)) for own in (0.3, 0.0))
    assert said.startswith(
        f"c1 loses {first} % and c2 loses {second} % of its full pressure in a minute. No formula follows it"
    )
    shorter = plain_words("leak", {"weights": weights}, 6.0).replace("\u00a0", " ")
    lost = round(100 * (0.3 * (1 - np.exp(-0.1)) + 0.05 * (1 - np.exp(-0.3))))
    assert shorter.startswith(f"c1 loses {lost} %, ")
    assert " of its full pressure in 6 s. " in shorter
    assert plain_words("creep", {"weights": weights}).startswith("No formula follows it")
    skin = {"value": [1.5, -0.2], "sd": [0.1, 0.1], "per": ["skin 600.0", "skin 600.0 load"], "unit": "1"}
    assert plain_words("leak", {"weights": skin}).startswith(
        "The surface sinks as a whole: no chamber stands out."
    )
    nothing = weights | {"value": [0.0] * 6}
    assert plain_words("leak", {"weights": nothing}).startswith("No single chamber leaks clearly.")


@pytest.mark.parametrize(
    ("form", "parameters", "ranges", "said"),
    [
        ("pressure", {}, {"c1": (0.0, 300.0)}, "Something is met from 180 mbar on."),
        ("pressure", {}, {"c1": (-300.0, 0.0)}, "Something is met from -180 mbar on."),
        ("per chamber", {}, {"c1": (0, 300), "c2": (0, 300)}, "Something is met from 180 mbar on."),
        (
            "per chamber",
            {},
            {"c1": (0, 300), "c2": (-50, 50)},
            "Something is met from 180 mbar (c1) and 10 mbar (c2) on.",
        ),
        (
            "one chamber",
            {"chamber": {"value": 1.0}},
            {"c1": (0, 300), "c2": (0, 200)},
            "c2 is stopped from 120 mbar on.",
        ),
        ("deflection", {}, {"c1": (0.0, 300.0)}, ""),
    ],
)
def test_a_limit_is_a_pressure(form: str, parameters: dict, ranges: dict, said: str) -> None:
    """Where something is met is said in the unit of the rig, not as a share of a range that nobody has in mind."""
    one = Fitted("contact", form, {"limit": {"value": 0.6}, **parameters}, 60.0, ranges, "mbar")
    assert one.plain.replace("\u00a0", " ") == said


def test_each_value_of_a_frame_has_its_own_unit() -> None:
    """A motion is three lengths and three turns: no length is said in millimetres and radians."""
    per = ["x", "y", "about x"]
    values = {
        "shift": {"value": [1.5, -0.5, 0.016], "sd": [0.02, 0.04, 0.001], "unit": "mm, rad", "per": per}
    }
    said = values_words(values).replace("\u00a0", " ")
    assert "mm, rad" not in said
    assert "x 1.500 ± 0.020 mm, y -0.500 ± 0.040 mm, about x 0.0160 ± 0.0010 rad" in said


def test_only_markers_and_moments_lose_their_number() -> None:
    """Of a second marker its name and moment are said as of the first; what an own effect counts keeps its number."""
    said = values_words(
        {
            "marker_2": {"value": 7.0, "per": ["m8"]},
            "since_2_s": {"value": 90.0, "unit": "s"},
            "k_2": {"value": 3.0, "sd": 0.1},
        }
    )
    assert said.replace("\xa0", " ") == "marker m8, since 90 s after the start, k 2 3.00 ± 0.10"


def test_each_value_of_several_observables_has_its_own_unit() -> None:
    """What belongs to an angle is in degrees and what belongs to a sensor in ohms: no value is in one or the other."""
    units = {"angle": "deg", "r1": "ohm", "r2": "ohm"}
    shift = {
        "value": [-0.572, 1.218, 1.140],
        "sd": [0.048, 0.042, 0.038],
        "unit": "(deg or ohm)/h",
        "per": [*units],
    }
    tilt = {"value": [[1.0, 2.0, 3.0], [-1.0, 4.0, 5.0]], "unit": "(deg or ohm)", "per": [*units]}
    said = values_words({"shift": shift, "tilt": tilt}, units).replace("\u00a0", " ")
    assert said == (
        "shift angle -0.572 ± 0.048 deg/h, r1 1.218 ± 0.042 ohm/h, r2 1.140 ± 0.038 ohm/h, "
        "tilt -1 to 1 deg and 2 to 5 ohm (6 values)"
    )


def test_others_are_summed_up_in_their_own_units() -> None:
    """Of many observables the largest are named, and the ranges of the others are those of each unit."""
    units = {"angle": "deg", "a": "ohm", "b": "ohm", "c": "ohm", "tip": "deg"}
    pattern = {"value": [0.5, -9.0, 8.0, 0.4, 7.0], "unit": "(deg or ohm)", "per": [*units]}
    said = values_words({"pattern": pattern}, units).replace("\u00a0", " ")
    assert said == "pattern a -9 ohm, tip 7 deg, b 8 ohm, 2 others 0.5 deg and 0.4 ohm"


def test_each_motion_of_a_frame_in_a_session_has_its_own_unit() -> None:
    """A frame that is another in each session is shifted in millimetres and turned in radians."""
    per = [f"{day}: {motion}" for day in ("day1", "day2") for motion in ("x", "z", "about x")]
    shift = {"value": [0.1, 0.846, 0.01, 0.2, 0.3, 0.04], "unit": "mm, rad", "per": per}
    said = values_words({"shift_in_session": shift}).replace("\u00a0", " ")
    assert "mm, rad" not in said
    assert "day1: z 0.846 mm" in said
    assert "day2: about x 0.04 rad" in said


@pytest.mark.parametrize(
    ("known", "said"),
    [
        (0.0, "tau 12 s"),
        (0.2592, "tau 12 s, 26 % of it in the base already"),
        (1.0, "tau 12 s, all of it in the base already"),
    ],
)
def test_how_much_of_creep_the_base_has_is_said_in_words(known: float, said: str) -> None:
    """The model file's `known` is no word: people read how much of the creep the base has already, or nothing."""
    values = {"tau_s": {"value": 12.0, "unit": "s"}, "known": {"value": known, "unit": "1"}}
    assert values_words(values).replace("\u00a0", " ") == said
