"""Captures that have each other's measurements: left out, and named."""

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared, rows_from
from labrig.diagnosis._interchanged import INTERCHANGED
from tests.laws import bowed, limited, orifice, power_law, sliding, strut

PAIRS = [(7, 8), (20, 21), (33, 40)]


def exchanged(values: np.ndarray) -> np.ndarray:
    """What is seen (n, T, K), with the captures of each pair in each other's place."""
    out = values.copy()
    for i, j in PAIRS:
        out[[i, j]] = values[[j, i]]
    return out


def read(lab, values: np.ndarray) -> tuple[set[int], tuple[str, ...]]:
    """The captures that are left out, and what is said."""
    rows = prepared(rows_from(lab.dataset(values)), lab.model()).context.rows
    return {*range(lab.captures)} - set(rows.capture.tolist()), rows.warnings


@pytest.mark.parametrize("law", [None, bowed, limited, orifice, power_law, sliding, strut])
def test_pairs_are_found_beside_an_effect(make_lab, law) -> None:
    """Neighbours and others: these captures, whatever else is missing; without an exchange none."""
    lab = make_lab(markers=12, seed=2, repeats=False)
    values = lab.predict(lab.u if law is None else law(lab)) + lab.noise()
    assert read(lab, values) == (set(), ())
    assert read(lab, exchanged(values)) == (
        {i for pair in PAIRS for i in pair},
        (
            "3 pairs of captures have each other's measurements (7 and 8, 20 and 21, 33 and 40): left out; put them "
            "right",
        ),
    )


def test_captures_that_should_be_alike_are_not_told_apart(make_lab) -> None:
    """Two repeats of one set-point may have changed places: nobody sees it, and nothing is left out."""
    lab = make_lab(markers=12)
    values = lab.predict(lab.u) + lab.noise()
    values[[4, 14]] = values[[14, 4]]
    assert read(lab, values) == (set(), ())


def test_few_observables_say_nothing(make_lab) -> None:
    """Of one force some capture is always near what another should be."""
    lab = make_lab(force=True, seed=2, repeats=False)
    assert read(lab, exchanged(lab.predict(lab.u) + lab.noise(0.2, 0.4)))[1] == ()


@pytest.mark.parametrize("size_kpa", [5.0, 15.0])
def test_a_wide_loop_is_no_exchange(make_lab, size_kpa: float) -> None:
    """Under a loop of a quarter of the range other captures are often near, and nothing has changed places."""
    for seed in range(3):
        lab = make_lab(chambers=2, markers=12, seed=seed, repeats=False)
        clean = lab.predict(lab.u)
        assert read(lab, clean + 2 * (lab.predict(lab.looped(size_kpa)) - clean) + lab.noise()) == (set(), ())


@pytest.mark.parametrize(("law", "effects"), [(None, []), (power_law, ["creep"])])
def test_what_is_missing_beside_them(make_lab, law, effects: list[str]) -> None:
    """With an effect it is named; without, what single captures were left out for is why the verdict is unknown."""
    lab = make_lab(chambers=2, markers=8, seed=2, repeats=False)
    values = lab.predict(lab.u if law is None else law(lab)) + lab.noise()
    summary = diagnose(lab.dataset(exchanged(values)), lab.model()).summary
    assert summary["effects"] == effects
    assert (summary["verdict"], summary["carried_by"]) == (
        ("identified", None) if effects else ("unknown", INTERCHANGED)
    )
