"""What the chambers were asked for and reached, as the report shows it."""

import re

import numpy as np
import xarray as xr

from labrig.view._page import Page
from labrig.view._pressures import pressures


def _cells(fields: xr.Dataset) -> list[list[str]]:
    page = Page("pressures")
    pressures(page, fields)
    return [
        re.findall(r"<td[^>]*>(.*?)</td>", row)
        for row in re.findall(r"<tr>(<td.*?)</tr>", page.html(), re.DOTALL)
    ]


def _fields(reached: np.ndarray | None) -> xr.Dataset:
    data = {"commanded": (("capture", "chamber"), np.array([[10.0, 20.0], [30.0, 40.0]]), {"units": "kPa"})}
    fields = xr.Dataset(data, coords={"capture": [3, 7], "chamber": ["c1", "c2"]})
    if reached is not None:
        fields["reached"] = (("capture", "chamber"), reached)
    return fields


def test_each_chamber_says_how_far_it_was_from_its_set_point() -> None:
    """The mean, the root mean square, and the capture that was farthest off; a chamber without a sensor says so."""
    rows = _cells(_fields(np.array([[10.5, np.nan], [28.0, np.nan]])))
    assert rows == [
        ["c1", "2", "-0.75", "1.46", "capture 7: 28.00 of 30.00"],
        ["c2", "0", "not measured", "", ""],
    ]


def test_without_measured_pressures_there_is_no_such_room() -> None:
    """An imported table without sensors has nothing to show."""
    assert _cells(_fields(None)) == []
