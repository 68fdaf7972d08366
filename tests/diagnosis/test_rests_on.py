"""What is named by one or two captures is said to be."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import prepared
from labrig.diagnosis._formula import fit_named
from labrig.diagnosis._rests_on import rests_on
from labrig.diagnosis._verdict import Verdict
from labrig.effects import get, rows_of

FOUND = Verdict("identified", ("contact",), 0.9)


def said_of(lab: Any, name: str, values: np.ndarray) -> list[str]:
    """What is said of an effect that is named on these measurements."""
    ready = prepared(rows_of(lab.dataset(values + lab.noise())), lab.model())
    return rests_on(ready, fit_named(ready.regression, ready.context, [get(name)]), FOUND)


@pytest.mark.parametrize(("touched", "said"), [((7, 18), True), ((3, 7, 12, 18, 21), False)])
def test_what_few_captures_say_is_said(make_lab: Any, touched: tuple[int, ...], said: bool) -> None:
    """A wall that is met in two captures of 24, smoothly: they are named; of five nothing is said."""
    lab = make_lab(captures=24, repeats=False, chambers=1, bent=0.0)
    lab.commanded = lab.random.uniform(0, 40, (24, 1))
    lab.commanded[list(touched)] = lab.random.uniform(50, 60, (len(touched), 1))
    over = np.maximum(lab.u - 42.0, 0.0)
    lines = said_of(lab, "contact", lab.predict(lab.u - over**2 / (over + 2.0)))
    assert lines == (
        [
            "nearly all that is explained by contact lies in captures 7 and 18 of 24: a mistake in so few looks the "
            "same, so measure set-points like these again"
        ]
        if said
        else []
    )


def test_what_goes_on_within_two_holds_is_borne_out_by_their_rows(make_lab: Any) -> None:
    """A leak that two long holds show is seen in each of their rows: nothing is said."""
    lab = make_lab(captures=24, long_s=(3.0, 10.0, 20.0, 40.0, 60.0), bent=0.0)
    emptied = lab.u / (1 + np.nan_to_num(lab.hold_s)[:, :, None] / 150.0)
    assert not said_of(lab, "leak", lab.predict(emptied))
