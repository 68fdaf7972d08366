"""The plots that give effects away."""

import numpy as np

from labrig.view._signature_figure import BINS, binned, signature


def traces(make_result, which):
    """The figure of one of the two signatures of the made-up result, and that signature."""
    item = make_result().signatures[which]
    return signature(item), item


def test_the_fitted_curve_lies_over_what_was_measured(make_result):
    """The line is the fitted effect, the dots are means of the measured in the same bins, and both rise alike."""
    figure, item = traces(make_result, 0)
    line = next(t for t in figure["data"] if t["mode"] == "lines")
    dots = next(t for t in figure["data"] if t["name"].endswith("measured"))
    assert len(line["x"]) == BINS
    assert line["x"] == dots["x"]
    assert np.corrcoef(line["y"], dots["y"])[0, 1] > 0.99
    assert line["y"][-1] > line["y"][0] + 10
    x, measured, fitted = binned(item, np.arange(800))
    np.testing.assert_allclose([line["x"], dots["y"], line["y"]], [x, measured, fitted], rtol=1e-4)


def test_axes_have_names_and_units(make_result):
    """Each axis says which quantity is on it, in what unit; a time in hold of many lengths is logarithmic."""
    creep, loop = (traces(make_result, k)[0]["layout"] for k in (0, 1))
    assert creep["xaxis"]["title"]["text"] == "time in hold, s"
    assert creep["yaxis"]["title"]["text"] == "share of the last move, %"
    assert creep["xaxis"]["type"] == "log"
    assert "20" in creep["xaxis"]["ticktext"]
    assert loop["xaxis"]["title"]["text"] == "pressure of the chamber, kPa"
    assert "type" not in loop["xaxis"]


def test_strokes_are_drawn_apart(make_result):
    """A loop has a curve from above and one from below, each with its name in the legend."""
    figure, _ = traces(make_result, 1)
    lines = {t["name"]: np.mean(t["y"]) for t in figure["data"] if t["mode"] == "lines"}
    assert lines["from above"] > 1.5
    assert lines["from below"] < -1.5
    assert figure["layout"]["showlegend"]
