"""The functions of a family under names that an engineer reads."""

from typing import Any

import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.effects import Fitted, library, weighable
from labrig.effects._weights import labels_of
from labrig.view import place_tables, shown_of, values_words


def of(effect: str, *names: str) -> Fitted:
    """An effect with a weight of 0.2 for each of these functions."""
    many = len(names)
    weights = {"value": [0.2] * many, "sd": [0.01] * many, "unit": "1", "per": [*names]}
    return Fitted(effect, "family, sliding", {"weights": weights}, unit_in_names="%")


@pytest.mark.parametrize("effect", ["friction", "hysteresis"])
def test_no_function_has_a_short_name(make_lab: Any, effect: str) -> None:
    """Every function of both families that can be saved is said in words, of all chambers and of one."""
    lab = make_lab(captures=24, long_s=(3.0, 5.0, 10.0, 30.0))
    context = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model()).context
    chambers = context.rows.chambers
    names = [n for s in weighable(library()[effect], context) for n in labels_of(s, chambers)]
    assert any(name.endswith(f" of {chambers[0]}") for name in names)
    one = of(effect, *names)
    same = set(one.shown["weights"]["per"]) & set(shown_of(one)["weights"]["per"])
    assert same == set()
    assert one.names("weights") == names


def test_the_words_say_what_a_function_does() -> None:
    """In the sentence and in the table alike: what holds back, where, and after which turn."""
    one = of("friction", "direction", "presliding 0.025 load of c2", "last turn 3 at 2", "way 0.02 load1")
    said = values_words(shown_of(one)).replace("\u00a0", " ")
    assert said.startswith("weights Coulomb friction 0.200 ± 0.010, presliding friction within 2.5 % of ")
    ((kind, _, rows),) = place_tables(shown_of(one), {}, "kPa", {})
    assert (kind, [row[0] for row in rows]) == (
        "function",
        [
            "Coulomb friction",
            "presliding friction within 2.5 % of the range after a turn growing with the pressure (more in c2)",
            "at 50 % after the last turn at 75 % of the range",
            "what builds up over 2 % of the range after a turn growing with the pressure",
        ],
    )


def test_another_effects_functions_keep_their_names() -> None:
    """What somebody's own effect calls its functions means what they say."""
    assert shown_of(of("mine", "direction"))["weights"]["per"] == ["direction"]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("turn 0 1", "Coulomb friction from chamber 2 at sensor 1"),
        ("play 0.06 1 0", "play of 6 % of the range from chamber 1 at sensor 2"),
        ("play 0.06 of -1.00 to 0.33", "play of 6 % of the range between -100 % and 33 % of it"),
        ("body settled 0.5", "how far the whole body went to the power of 0.5"),
    ],
)
def test_what_few_rigs_have_is_said_too(name: str, said: str) -> None:
    """Functions of single sensors, of a part of the range, and of a power that is no share of anything."""
    assert shown_of(of("hysteresis", name))["weights"]["per"] == [said]
