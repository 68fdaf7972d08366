"""What the fitted values of an effect come to, in its own words."""

from typing import Any

import numpy as np
import pytest

from labrig.effects import Fitted, library

CHAMBERS = [f"c{i}" for i in range(1, 6)]


def per_chamber(values: list[float], sds: list[float], unit: str = "1") -> dict[str, Any]:
    """A parameter of each chamber."""
    return {"value": values, "sd": sds, "unit": unit, "per": CHAMBERS[: len(values)]}


def words(effect: str, parameters: dict[str, Any], form: str = "", **more: Any) -> str:
    """What an effect of the library says of its values."""
    return library()[effect].in_words(Fitted(effect, form, parameters, **more)).replace("\u00a0", " ")


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
    assert words("leak", parameters) == said


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
    said = words("leak", {"weights": weights})
    minute, whole = 1 - np.exp(-1), 1 - np.exp(-3)
    first, second = (round(100 * (own * minute + 0.05 * whole)) for own in (0.3, 0.0))
    assert said.startswith(f"c1 loses {first} % and c2 loses {second} % of its full pressure in a minute.")
    shorter = words("leak", {"weights": weights}, longest_s=6.0)
    lost = round(100 * (0.3 * (1 - np.exp(-0.1)) + 0.05 * (1 - np.exp(-0.3))))
    assert shorter.startswith(f"c1 loses {lost} %, ")
    assert shorter.endswith(" of its full pressure in 6 s.")
    assert words("creep", {"weights": weights}) == ""
    skin = {"value": [1.5, -0.2], "sd": [0.1, 0.1], "per": ["skin 600.0", "skin 600.0 load"], "unit": "1"}
    assert words("leak", {"weights": skin}).startswith("The surface sinks as a whole: no chamber stands out.")
    nothing = weights | {"value": [0.0] * 6}
    assert words("leak", {"weights": nothing}).startswith("No single chamber leaks clearly.")


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
    assert (
        words("contact", {"limit": {"value": 0.6}, **parameters}, form=form, ranges=ranges, unit="mbar")
        == said
    )
