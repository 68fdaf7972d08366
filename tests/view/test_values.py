"""Fitted values in words."""

from types import SimpleNamespace
from typing import Any

import pytest

from labrig.effects import EffectError, Fitted
from labrig.view._values import plain, values_words

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


def test_an_effects_own_words_stand_before_its_numbers() -> None:
    """An effect says what its values come to; where that fails, the fault stands there and the rest is shown."""

    def fails(found: Fitted) -> str:
        raise EffectError("effect 'boom': boom.py, line 3: Boom.in_words: KeyError: 'tau'")

    def said(in_words: Any, parameters: dict[str, Any]) -> str:
        improved = SimpleNamespace(library=lambda: {"boom": SimpleNamespace(in_words=in_words)})
        return plain(SimpleNamespace(improved=improved), Fitted("boom", "", parameters))  # type: ignore[arg-type]

    assert (
        said(lambda found: f"It booms by {found.numbers('size')[0]:g}.", {"size": {"value": 3}})
        == "It booms by 3."
    )
    assert said(lambda found: "", {"weights": {}}).startswith("No formula follows it well enough")
    assert said(fails, {}) == "effect 'boom': boom.py, line 3: Boom.in_words: KeyError: 'tau'."
