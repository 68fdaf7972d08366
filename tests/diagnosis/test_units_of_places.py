"""Where something went is in the unit of the markers, whatever that is."""

from dataclasses import replace

import pytest

from labrig.diagnosis._problem import prepared, rows_from
from labrig.effects import unit_on


@pytest.mark.parametrize(
    ("effect", "parameter", "unit"),
    [
        ("marker_slip", "slip", "px"),
        ("frame", "shift", "px"),
        ("frame", "shift_since", "px, rad"),
    ],
)
def test_of_markers_in_pixels_it_is_pixels(make_lab, effect: str, parameter: str, unit: str) -> None:
    """A marker that slipped on a camera's picture went so many pixels, no millimetres."""
    lab = make_lab(captures=12)
    context = prepared(rows_from(lab.dataset(lab.predict(lab.u))), lab.model()).context
    on_screen = replace(context, rows=replace(context.rows, unit=("px",) * len(context.rows.unit)))
    assert unit_on(on_screen, lab.model().library()[effect].parameter(parameter).unit) == unit
