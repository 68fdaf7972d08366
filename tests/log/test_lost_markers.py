"""A marker that a run lost on its way is said: how often it was missed, and since when."""

import numpy as np
import pytest
import xarray as xr

from labrig._lost_markers import lost_markers


def run_of(unseen: dict[str, list[int]], captures: int = 20) -> xr.Dataset:
    """A run of four markers in which these were seen in no frame of these captures."""
    names = ["m1", "m2", "m3", "m4"]
    position = np.zeros((captures, 5, 4, 3))
    position[::2, 3:] = np.nan  # a capture that is shorter
    for name, where in unseen.items():
        position[where, :, names.index(name)] = np.nan
    dims = ("capture", "time", "marker", "axis")
    return xr.Dataset({"position_mm": (dims, position)}, {"marker": names})


@pytest.mark.parametrize(
    ("unseen", "lines"),
    [
        ({}, []),
        ({"m3": [4, 9]}, []),
        (
            {"m3": list(range(10, 20))},
            ["m3 was not seen in 10 of 20 captures (50 %), not once since capture 10: {why}"],
        ),
        (
            {"m1": [17, 18, 19], "m2": [17, 18, 19]},
            ["m1 and m2 were not seen in 3 of 20 captures (15 %), not once since capture 17: {why}"],
        ),
        (
            {"m4": list(range(1, 20, 2))[:-1]},
            ["m4 was not seen in 9 of 20 captures (45 %), first in capture 1: {why}"],
        ),
        ({"m2": list(range(20))}, ["m2 was never seen, in 20 captures: {why}"]),
    ],
)
def test_a_marker_that_is_lost_is_named(unseen: dict[str, list[int]], lines: list[str]) -> None:
    """With the share of the captures and the first; one that a pose covers now and then is not."""
    why = "fallen off, covered, or without a label?"
    assert lost_markers(run_of(unseen)) == [line.format(why=why) for line in lines]


def test_a_run_without_markers_lost_none() -> None:
    """A run of sensors, and one without captures, have no markers to lose."""
    assert lost_markers(xr.Dataset()) == []
    assert lost_markers(run_of({}, captures=0)) == []
