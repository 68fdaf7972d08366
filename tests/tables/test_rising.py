"""Which columns of a table are taken for a clock: those that rise, but for a few places."""

import numpy as np
import pytest

from labrig.tables._time import only_rises


@pytest.mark.parametrize(("places", "rises"), [(0, True), (2, True), (3, False), (6, False)])
def test_a_clock_begins_anew_in_a_few_places_only(places: int, rises: bool) -> None:
    """One step in fifty may go back, as where files are joined; a column that goes back more often is a measurement."""
    step = np.ones(100)
    step[10 * np.arange(places)] = -5.0
    assert only_rises(np.cumsum(np.concatenate([[0.0], step]))) is rises
