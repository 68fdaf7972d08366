"""The report: complete, offline, and never half written."""

import json
import re

import numpy as np
import pytest

from labrig.diagnosis import Result
from labrig.view import write_report
from labrig.view._report import report_html


def figures_of(html):
    """The figures that the page draws, parsed as the browser would."""
    return json.loads(re.search(r"const figures=(\[.*\]);\nPromise", html)[1].replace("<\\/", "</"))


def x_titles(html):
    """The titles of the figures' x axes."""
    return [f["layout"].get("xaxis", {}).get("title", {}).get("text", "") for f in figures_of(html)]


def body_of(html):
    """What a person reads: the page without scripts and style."""
    return re.sub(r"<(script|style|title)>.*?</\1>", "", html, flags=re.DOTALL)


def test_report_loads_nothing(make_result, tmp_path):
    """The file holds everything: the plotting library once, no link, no image, no style from elsewhere."""
    path = write_report(make_result(), tmp_path / "out")
    html = path.read_text(encoding="utf-8")
    assert path == tmp_path / "out" / "report.html"
    assert html.count("plotly.js v") == 1
    assert not re.search(r"(src|href)\s*=|@import|url\(", body_of(html))
    assert "<link" not in html
    assert "<script src" not in html


def test_report_says_it_in_order(make_result):
    """First the verdict, why, what else and what next; then the pictures, from the whole to single captures."""
    body = body_of(report_html(make_result()))
    wanted = [
        ">identified<",
        "Creep is missing from the model.",
        "Creep, sure (98\u00a0%, 2.0\u00a0±\u00a00.1\u00a0mm); possible beside it: drift (20\u00a0%), neither needed",
        "held-out error falls from",
        "Alternatives",
        "Next experiment",
        "Notes",
        "Effect by effect",
        "From the model to the noise",
        "Single-effect ranking",
        "On the surface",
        "Where it fails",
        "Signatures",
        "The worst captures",
    ]
    places = [body.index(text) for text in wanted]
    assert places == sorted(places)


def surfaces_of(html):
    """The skins that the page draws."""
    return [trace for f in figures_of(html) for trace in f["data"] if trace["type"] == "mesh3d"]


def test_colours_count_in_noise_floors(make_result):
    """Before and after have one scale, which the floor alone sets: the same error is paler above a higher floor."""
    before, after = surfaces_of(report_html(make_result()))
    assert (before["cmin"], before["cmax"]) == (after["cmin"], after["cmax"]) == (0, 1)
    assert max(before["intensity"]) > 3 * max(after["intensity"])
    error = {"base": 1.92, "model": 0.31, "floor": 0.48, "ceiling": 0.5}
    coarse, _ = surfaces_of(report_html(make_result(error=error)))
    assert max(coarse["intensity"]) == pytest.approx(max(before["intensity"]) - 0.5, abs=0.01)


def test_nothing_missing_shows_one_pale_surface(make_result, fields):
    """Where nothing was added there is no before and after, and what is not above the floor has no colour."""
    error = {"base": 0.11, "model": 0.11, "floor": 0.11, "ceiling": 0.11}
    quiet = fields.assign(base=fields["model"])
    html = report_html(
        make_result(fields=quiet, verdict="nothing_missing", effects=[], effects_considered=[], error=error)
    )
    (surface,) = surfaces_of(html)
    assert np.median(surface["intensity"]) < 0.25
    assert "Nothing is missing" in body_of(html)
    assert "data-show" not in body_of(html)


def test_each_unit_has_its_errors(make_result) -> None:
    """Beside the unit that is quoted the page says what the errors are in every other."""
    by_unit = {
        "mm": {"base": 1.9, "model": 0.3, "floor": 0.1},
        "N": {"base": 4.2, "model": 0.7, "floor": 0.2},
    }
    said = body_of(report_html(make_result(error_by_unit=by_unit)))
    assert "In N: the model as it was 4.2, with creep 0.7 and noise floor 0.2." in said
    assert "In mm:" not in said


def test_without_geometry_measured_against_predicted(make_result, fields):
    """A run of forces has no surface: measured is drawn against predicted."""
    plain = fields.drop_vars("rest_mm").isel(observable=slice(0, 2))
    html = report_html(make_result(fields=plain))
    assert "Measured against predicted" in body_of(html)
    assert x_titles(html)[0] == "predicted, mm"
    assert [trace["name"] for trace in figures_of(html)[0]["data"]] == ["before", "after", "exact"]


def test_units_that_differ_are_scaled(make_result, fields):
    """Observables of different units are compared in standard deviations."""
    mixed = fields.drop_vars("rest_mm").isel(observable=slice(0, 2))
    mixed = mixed.assign_coords(unit=("observable", ["mm", "N"]))
    assert x_titles(report_html(make_result(fields=mixed)))[0] == "predicted, standard deviations"


def test_a_report_names_what_it_is_of(make_result):
    """Beside the sizes stand the runs, each with its folder, and the model's file: reports are called alike."""
    one = {"runs": [{"run": "/lab/demo/run", "id": "a"}], "model": "demo/model.yaml"}
    assert "labrig · demo/run · model.yaml · " in body_of(report_html(make_result(**one)))
    many = {"runs": [{"run": f"runs/{k}", "id": str(k)} for k in range(5)], "model": None}
    assert "labrig · runs/0 and 4 more runs · " in body_of(report_html(make_result(**many)))


def test_names_are_escaped(make_result):
    """What a file names cannot inject markup, in words or in figures."""
    html = report_html(make_result(effects=["</script><b>x"], warnings=["<img src=x>"]))
    assert "<b>x" not in html
    assert "<img" not in html


def test_comparison_has_a_report(fields):
    """A comparison, which has no verdict and no effects, is reported too."""
    summary = {"units": "mm", "error": {"model": 1.2, "floor": 0.1}, "where": [], "warnings": []}
    html = report_html(Result(summary, fields, [("model", 1.2), ("floor", 0.1)], [], []))
    assert "The model&#x27;s error is 1.2" in body_of(html)
    assert "Run <code>labrig diagnose</code>" in html
    for word in ("effect added", "before", "after", "eld out", "eld-out", "as it was"):
        assert word not in body_of(html), word


def test_values_of_parameters(make_result):
    """A value comes with its uncertainty and unit, many values with their spread."""
    creep = {
        "effect": "creep",
        "heldout_error": 0.3,
        "drop": 0.9,
        "se": 0.02,
        "probability": 0.9,
        "parameters": {
            "tau_s": {"value": 12.0, "sd": 1.5, "unit": "s"},
            "amplitude": {"value": [0.1, 0.2, 0.3], "sd": [0.01, 0.01, 0.01], "unit": "1"},
        },
    }
    body = body_of(report_html(make_result(ranking=[creep])))
    assert "tau 12.0 ± 1.5\u00a0s, amplitude 0.1 to 0.3 (3 values)" in body
    assert "90 ± 2 %" in body


def test_effect_by_effect(make_result):
    """What is sure and what is possible stand in the table; what is not it can be unfolded."""
    rows = re.findall(r"<tr.*?</tr>", body_of(report_html(make_result())), flags=re.DOTALL)
    cells = [re.sub(r"<[^>]+>", "|", row) for row in rows if 'class="call' in row]
    assert [re.sub(r"\|+", "|", row).strip("|") for row in cells] == [
        "creep|sure|98 %|2.0 ± 0.1|20 ± 1",
        "drift|possible|20 %|2.0 ± 0.1|20 ± 1",
        "leak|not it|3 %|2.0 ± 0.1|20 ± 1",
        "delay|not it|under 1 %|–|–",
    ]


@pytest.mark.parametrize("verdict", ["identified", "multiple", "confounded", "underpowered"])
def test_no_probability_beside_a_word_that_it_is_not_of(make_result, verdict):
    """The badge has no figure where each effect has a probability of its own."""
    html = body_of(report_html(make_result(verdict=verdict, probability=0.1, rivals=["drift"])))
    assert "sure</span><span>" not in html
    assert "10 % sure" not in html


def test_a_report_that_fails_leaves_the_old_one(make_result, fields, tmp_path):
    """What was there stays whole when drawing the new report fails, and nothing half-written stays behind."""
    path = write_report(make_result(), tmp_path)
    before = path.read_bytes()
    with pytest.raises(KeyError):
        write_report(make_result(fields=fields.drop_vars("base")), tmp_path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]


def test_a_marker_that_was_never_seen(make_result, fields):
    """A marker without a single measurement does not spoil the page."""
    blind = fields.copy(deep=True)
    blind["measured"].values[:, :3] = np.nan
    html = report_html(make_result(fields=blind))
    assert len(figures_of(html)) == 5
    assert "m01: not seen" in json.dumps(figures_of(html))
