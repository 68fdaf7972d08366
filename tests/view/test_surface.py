"""Surfaces of a page: their numbers, outlines, the list of captures, and what turns together."""

import json
import re

import numpy as np
import pytest

from labrig.diagnosis import compare, improve
from labrig.view._colours import error_colours, rgb
from labrig.view._fields import cloud, kept_captures, skin
from labrig.view._outlines import chamber_outlines
from labrig.view._report import report_html
from labrig.view._style import ERROR_SCALE
from labrig.view._surface_figure import CHAMBERS, MARKERS, NAMES, surface_figure


def explorer_of(html):
    """What the page's script is given."""
    return json.loads(re.search(r'<script type="application/json">(.*?)</script>', html, re.DOTALL)[1])


def a_lab(make_lab):
    """A rig whose pressures are a tenth too high, with a mistaken position and markers that were not seen."""
    lab = make_lab(chambers=4, markers=9, captures=40)
    values = lab.predict(1.1 * lab.u) + lab.noise()
    values[3, :, 4] += 30.0
    values[lab.random.random(values.shape[:2]) < 0.1] = np.nan
    return lab, lab.dataset(values)


def test_map_and_table_have_the_same_numbers(make_lab):
    """A marker's error on the map is that of its row in the table, mistaken positions left out of both."""
    lab, data = a_lab(make_lab)
    for result in (compare(data, lab.model()), improve(data, lab.model(), ["regulator"])):
        markers = cloud(result.fields)
        figure = surface_figure(markers.names, markers.rest_mm, markers.before_mm, 0.1, "mm")
        shown = dict(zip(markers.names, figure["data"][MARKERS]["customdata"], strict=True))
        rows = {row["name"]: row["error"] for row in result.where if row["group"] == "marker"}
        assert set(rows) == set(shown)
        assert shown == pytest.approx(rows, rel=1e-4)


def test_a_surface_has_no_letters_but_its_names(make_lab):
    """Its axes bring no title and no numbers, of which plotly would make letters even if they are not seen."""
    lab, data = a_lab(make_lab)
    markers = cloud(compare(data, lab.model()).fields)
    scene = surface_figure(markers.names, markers.rest_mm, markers.before_mm, 0.1, "mm")["layout"]["scene"]
    for axis in (scene[f"{name}axis"] for name in "xyz"):
        assert "visible" not in axis
        assert (axis["title"]["text"], axis["tickvals"], axis["showticklabels"]) == ("", [], False)


def test_the_scale_of_colours():
    """Up to one floor there is no colour, from sixteen on the darkest, whatever else is shown."""
    first, last = rgb(ERROR_SCALE[0][1]), rgb(ERROR_SCALE[-1][1])
    colours = error_colours(np.array([0.0, 0.1, 1.6, 99.0, np.nan]), 0.1)
    assert [tuple(c) for c in colours[:4].tolist()] == [first, first, last, last]
    assert tuple(colours[4].tolist()) not in (first, last)


def test_outlines_run_where_a_chamber_moves_half(make_lab):
    """On a chamber's line it moves the surface by half of its most; its name stands where that is."""
    lab, data = a_lab(make_lab)
    markers = cloud(compare(data, lab.model()).fields)
    rest = np.column_stack([np.tile(np.arange(3), 3), np.repeat(np.arange(3), 3), np.zeros(9)]) * 10.0
    surface = skin(rest)
    outlines = chamber_outlines(surface, markers.chambers, markers.reach)
    assert [o.name for o in outlines] == list(lab.dataset(lab.predict(lab.u))["chamber"].values)
    for outline, reach in zip(outlines, markers.reach.T, strict=True):
        top = outline.middle @ reach
        assert len(outline.ends) > 3
        assert outline.ends @ reach == pytest.approx(0.5 * top, rel=1e-6)
        assert top == pytest.approx(surface.vertices(reach).max())


def test_markers_and_chambers_have_names(make_result, fields):
    """Each marker's and each chamber's name stands on the surface."""
    moved = np.random.default_rng(0).random((34, 9))
    html = report_html(make_result(fields=fields.assign(reach=(("marker", "chamber"), moved))))
    figures = json.loads(re.search(r"const figures=(\[.*\]);\nPromise", html)[1].replace("<\\/", "</"))
    traces = next(f["data"] for f in figures if f["data"][0]["type"] == "scatter3d")
    assert traces[NAMES]["text"] == [f"m{i:02d}" for i in range(1, 35)]
    assert traces[CHAMBERS]["text"] == [f"c{i}" for i in range(1, 10)]


def test_every_capture_can_be_picked(make_result, fields):
    """The list has all captures with their set-points and errors; picked, a capture has its shape and its errors."""
    html = report_html(make_result())
    data = explorer_of(html)
    options = re.findall(r"<option .*?>(.*?)</option>", html)
    assert len(options) == 41
    assert re.match(r"0: c\d [\d.]+, .* kPa \([\d.]+ mm\)", options[1])
    assert sum(", the worst" in option for option in options) == 1
    markers = cloud(fields)
    n, m = np.argwhere(np.isfinite(markers.base_error_mm))[100]
    assert data["shapes"][n][m] == pytest.approx(markers.measured_mm[n, m], abs=0.01)
    assert data["each"][0][n][m] == pytest.approx(markers.base_error_mm[n, m], abs=1e-3)
    assert data["each"][1][n][m] == pytest.approx(markers.model_error_mm[n, m], abs=1e-3)
    assert len(data["weight"][0]) == 34


def test_of_many_captures_the_worst_stay():
    """Where a page would be too large, captures are left out evenly, and never the worst."""
    error = np.random.default_rng(0).random(1000)
    kept = kept_captures(1000, error, 100)
    assert len(kept) <= 100
    assert int(error.argmax()) in kept
    assert np.diff(kept).max() <= 15
    assert kept_captures(5, error[:5], 100) == [0, 1, 2, 3, 4]


def test_surfaces_turn_together(make_result):
    """The page shares one camera among its surfaces, and looks at both from one place to begin with."""
    html = report_html(make_result())
    assert html.count("plotly_relayouting', change => turn") == 1
    figures = json.loads(re.search(r"const figures=(\[.*\]);\nPromise", html)[1].replace("<\\/", "</"))
    cameras = [f["layout"]["scene"]["camera"] for f in figures if "scene" in f["layout"]]
    assert len(cameras) == 2
    assert cameras[0] == cameras[1]


@pytest.mark.parametrize(
    ("places", "roomy"),
    [
        ([[0, 0, 33], [0.4, 0.1, 66], [0.8, 0.2, 100]], True),
        ([[0, 0, 0], [50, 0, 0], [0, 40, 0], [50, 40, 0], [25, 20, 3]], False),
    ],
)
def test_markers_on_a_line_are_in_the_picture(places, roomy):
    """A finger at rest, which is thin both ways, has room around it: it is seen as large as its camera expects.

    A sheet, in front of which its names stand, needs none.
    """
    places = np.array(places, dtype=float)
    figure = surface_figure([f"m{n}" for n in range(len(places))], places, np.zeros(len(places)), 0.1, "mm")
    traces = [trace for trace in figure["data"] if trace.get("name") == "room"]
    assert bool(traces) is roomy
    shown = np.concatenate([[trace[a] for a in "xyz"] for trace in figure["data"]], axis=1)
    extent = np.ptp(shown, axis=1)
    eye = np.linalg.norm([*figure["layout"]["scene"]["camera"]["eye"].values()])
    assert extent.max() / np.prod(extent) ** (1 / 3) < eye
