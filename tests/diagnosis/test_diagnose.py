"""The whole pipeline on small campaigns: every verdict, its JSON, and what the data may be like."""

import json
from typing import Any

import numpy as np
import pytest

from labrig._json import write_json
from labrig.diagnosis import Result, compare, diagnose, rows_from
from labrig.diagnosis._problem import last_of
from labrig.effects._registry import shipped
from tests.conftest import Lab
from tests.naming import verdict_of

LONG_S = (3.0, 4.0, 6.0, 10.0, 20.0, 40.0)
GROUPS = {
    "marker",
    "observable",
    "region",
    "chamber",
    "pressure band",
    "direction",
    "time in session",
    "time in hold",
    "pair of chambers",
    "capture",
}


def slipped(lab: Any, size_mm: float = 2.0) -> np.ndarray:
    """Values of a rig whose fourth marker has moved after half of the captures."""
    values = lab.predict(lab.u)
    values[lab.captures // 2 :, :, 9:12] += size_mm
    return values


def as_json(result: Result, tmp_path) -> dict[str, Any]:
    """What a result's file holds."""
    write_json(result.summary, tmp_path / "result.json")
    return json.loads((tmp_path / "result.json").read_text())


def answer(result: Result) -> tuple[str, set[str]]:
    """Verdict and names."""
    return result.summary["verdict"], set(result.summary["effects"])


@pytest.fixture(scope="module")
def slip(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, dict[str, Any]]:
    """A rig on which a marker slips, and what the diagnosis' file holds."""
    folder = tmp_path_factory.mktemp("slip")
    lab = Lab(folder, chambers=2, captures=40, long_s=LONG_S)
    return lab, as_json(diagnose(lab.dataset(slipped(lab) + lab.noise()), lab.model()), folder)


def test_the_file_is_of_the_documented_form(slip) -> None:
    """diagnosis.json has the keys that others rely on, of the right kinds, and nothing that is not JSON."""
    _, content = slip
    documented = {"verdict", "effects", "probability", "rivals", "units", "error", "where", "ranking"}
    documented |= {"next_experiment", "warnings", "effects_considered"}
    assert set(content) >= documented
    more = {"together", "drop", "carried_by", "floor", "left_out", "unnamed", "runs", "model", "track_record"}
    more |= {"error_by_unit", "left_out_share", "unnamed_units"}
    assert set(content) - documented == more
    assert (content["verdict"], content["effects"], content["rivals"]) == ("identified", ["marker_slip"], [])
    assert content["units"] == "mm"
    assert 0.7 < content["probability"] <= 1
    assert list(content["error"]) == ["base", "model", "floor", "ceiling"]
    error = content["error"]
    assert 0 < error["floor"] <= 1.2 * error["model"] < 0.5 * error["base"]
    assert error["ceiling"] <= error["model"] * 1.001
    assert 0.9 < content["drop"] <= 1
    assert {w["group"] for w in content["where"]} <= GROUPS
    assert {"marker", "time in hold", "capture"} <= {w["group"] for w in content["where"]}
    for place in content["where"]:
        assert set(place) == {"group", "name", "error", "share", "clear"}
        assert place["error"] > 0
        assert 0 <= place["share"] <= 1
    assert [w["error"] for w in content["where"]] == sorted(
        (w["error"] for w in content["where"]), reverse=True
    )
    first = content["ranking"][0]
    assert set(first) == {"effect", "form", "heldout_error", "drop", "se", "probability", "parameters"}
    assert first["effect"] == "marker_slip"
    assert [r["heldout_error"] for r in content["ranking"]] == sorted(
        r["heldout_error"] for r in content["ranking"]
    )
    for value in first["parameters"].values():
        assert {"value", "unit"} <= set(value)
    assert first["parameters"]["slip"]["unit"] == "mm"
    assert content["next_experiment"] is None
    assert not any("repeats" in w or "sessions" in w or "outlying" in w for w in content["warnings"])


def test_each_effect_is_considered(slip) -> None:
    """The file says of every effect how probable it is, what that comes to, and how large it is, surest first."""
    lab, content = slip
    considered = content["effects_considered"]
    assert {c["effect"] for c in considered} == set(shipped())
    assert [c["probability"] for c in considered] == sorted(
        (c["probability"] for c in considered), reverse=True
    )
    for c in considered:
        sizes = {"size", "size_sd", "size_floors", "size_sd_floors"}
        assert set(c) == {"effect", "probability", "call", "by_evidence", "share", "track_record"} | sizes
        assert (c["track_record"] is None) == (c["call"] != "sure")
        assert 0 <= c["probability"] <= 1
        assert c["call"] in {"sure", "possible", "not it"}
    first = considered[0]
    assert (first["effect"], first["call"]) == ("marker_slip", "sure")
    clean = slipped(lab) - lab.predict(lab.u)
    true = float(np.sqrt(np.mean(clean[np.isfinite(lab.hold_s)] ** 2)))
    assert abs(first["size"] - true) < max(4 * first["size_sd"], 0.1 * true)
    assert not any(c["call"] == "sure" for c in considered[1:])


def test_the_waterfall_falls(make_lab, few_effects) -> None:
    """Base, each effect, ceiling, floor: held-out errors, the effects' steps downwards, ends as in `error`."""
    few_effects("hysteresis", "marker_slip", "friction", "drift")
    lab = make_lab(chambers=2, captures=60)
    values = lab.predict(lab.looped(3.0))
    values[30:, :, 9:12] += 2.0
    result = diagnose(lab.dataset(values + lab.noise()), lab.model())
    assert {*result.summary["effects"], *result.summary["rivals"]} == {"hysteresis", "marker_slip"}
    labels, steps = zip(*result.waterfall, strict=True)
    assert labels[0] == "base"
    assert set(labels[1:3]) == {"+ hysteresis", "+ marker_slip"}
    assert labels[3:] == ("ceiling", "floor")
    assert steps[0] > steps[1] > steps[2] >= steps[3] * 0.999
    error = result.summary["error"]
    assert [steps[0], *steps[2:]] == pytest.approx([error[k] for k in ("base", "model", "ceiling", "floor")])


def test_noise_is_nothing(make_lab) -> None:
    """A base that is right up to noise lacks nothing; the model is not changed."""
    lab = make_lab(captures=40, long_s=LONG_S)
    result = diagnose(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model())
    assert answer(result) == ("nothing_missing", set())
    assert result.improved is None
    assert result.summary["error"]["base"] == pytest.approx(result.summary["error"]["floor"], rel=0.35)
    assert [label for label, _ in result.waterfall] == ["base", "ceiling", "floor"]


def test_one_slow_fall_has_two_explanations(make_lab) -> None:
    """One hold, one force that falls in a straight line: leak and drift are both possible, and none is all there is."""
    lab = make_lab(
        chambers=1, force=True, captures=1, rows_s=tuple(np.arange(1.0, 140.0, 0.25)), repeats=False
    )
    lab.commanded[:] = 50.0
    values = lab.predict(lab.u) * (1 - 0.00003 * lab.hold_s[:, :, None])
    summary = diagnose(lab.dataset(values + lab.noise(row=0.05, capture=0.0)), lab.model()).summary
    assert summary["verdict"] in {"confounded", "underpowered", "unknown"}
    assert summary["next_experiment"] is not None
    if summary["verdict"] == "confounded":
        assert any(
            "leak doubles with the pressure" in probe for probe in summary["next_experiment"]["probes"]
        )


def test_what_no_effect_explains_is_unknown(make_lab) -> None:
    """With what could explain it left out of the library, something predictable is found, and what carries it."""
    lab = make_lab(chambers=2, captures=60)
    data = lab.dataset(lab.predict(lab.looped(6.0)) + lab.noise())
    summary = diagnose(data, lab.model(), without=["hysteresis", "friction", "delay"]).summary
    assert summary["verdict"] == "unknown"
    assert summary["effects"] == []
    assert "history" in summary["carried_by"]
    assert summary["unnamed"][summary["carried_by"]] > 0
    assert summary["error"]["ceiling"] < 0.8 * summary["error"]["base"]


def test_a_tolerance_below_what_can_be_seen(make_lab, few_effects) -> None:
    """Asked for a hundredth of the noise, few captures can't say; asked for plenty, they can."""
    few_effects("regulator", "creep", "drift")
    lab = make_lab(captures=20, chambers=1, force=True)
    data, model = lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()
    small = diagnose(data, model, tolerance=0.001).summary
    assert small["verdict"] == "underpowered"
    assert small["warnings"][0].startswith("the smallest effect that these captures could show is 0.")
    assert diagnose(data, model, tolerance=5.0).summary["verdict"] == "nothing_missing"


def test_an_effect_below_the_tolerance_is_let_pass(make_lab, few_effects) -> None:
    """What is real but smaller than what matters is not claimed."""
    few_effects("marker_slip", "frame", "drift")
    lab = make_lab(chambers=2, captures=40)
    data, model = lab.dataset(slipped(lab) + lab.noise()), lab.model()
    assert answer(diagnose(data, model, tolerance=0.2)) == ("identified", {"marker_slip"})
    assert answer(diagnose(data, model, tolerance=50.0)) == ("nothing_missing", set())


def test_a_tolerance_counts_in_the_same_noise_as_sizes(make_lab, few_effects) -> None:
    """Where rows are far noisier than means, a tolerance above the size that is stated lets it pass, and none below."""
    few_effects("marker_slip", "frame", "drift")
    lab = make_lab(chambers=2, captures=40, rows_s=(3.0, 4.0, 5.0, 6.0, 7.0, 8.0))
    data, model = lab.dataset(slipped(lab) + lab.noise(row=0.6, capture=0.05)), lab.model()
    first = diagnose(data, model).summary
    assert first["effects"] == ["marker_slip"]
    size = first["effects_considered"][0]["size"]
    assert diagnose(data, model, tolerance=0.6 * size).summary["effects"] == ["marker_slip"]
    assert diagnose(data, model, tolerance=1.7 * size).summary["verdict"] == "nothing_missing"


def test_the_same_input_gives_the_same_file(make_lab, tmp_path, few_effects) -> None:
    """Twice the same numbers, to the last digit of the JSON."""
    few_effects("marker_slip", "frame", "drift", "creep", "hysteresis")
    lab = make_lab(chambers=2, captures=24)
    data, model = lab.dataset(slipped(lab) + lab.noise()), lab.model()
    one, two = (as_json(diagnose(data.copy(deep=True), model), tmp_path) for _ in range(2))
    assert one == two


def test_a_library_may_be_cut_down(make_lab, few_effects) -> None:
    """An effect that is left out is neither considered nor named."""
    few_effects("marker_slip", "frame", "drift")
    lab = make_lab(chambers=2, captures=40)
    data = lab.dataset(slipped(lab) + lab.noise())
    result = diagnose(data, lab.model(), without=["marker_slip"])
    assert "marker_slip" not in {r["effect"] for r in result.summary["ranking"]}
    assert "marker_slip" not in {c["effect"] for c in result.summary["effects_considered"]}
    assert "marker_slip" not in answer(result)[1]


def test_a_curve_without_a_name(make_lab) -> None:
    """A static law that no effect in a cut-down library has: some answer, whatever it is, and no crash."""
    lab = make_lab(chambers=2, captures=40)
    data = lab.dataset(lab.predict(lab.u * (1 + 0.2 * (lab.u / 60) ** 3)) + lab.noise())
    gone = ["stiffening", "contact", "tension", "regulator"]
    summary = diagnose(data, lab.model(), without=gone).summary
    assert summary["verdict"] != "nothing_missing"
    assert not set(summary["effects"]) & set(gone)
    assert summary["error"]["model"] <= summary["error"]["base"] * 1.001


def test_twenty_captures(make_lab) -> None:
    """A short campaign is enough to be sure of an effect of several floors."""
    lab = make_lab(captures=20, chambers=2)
    found = verdict_of(lab.dataset(slipped(lab) + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("identified", ("marker_slip",))


def test_fifteen_hundred_captures(make_lab, few_effects) -> None:
    """A long campaign of single rows of one force is no trouble, and finds what is small."""
    few_effects("hysteresis", "friction", "creep", "drift", "regulator")
    lab = make_lab(captures=1500, chambers=1, force=True, rows_s=(3.0,))
    u = lab.looped(0.8)
    result = diagnose(lab.dataset(lab.predict(u) + lab.noise(row=0.0, capture=0.25)), lab.model())
    assert "hysteresis" in {*result.summary["effects"], *result.summary["rivals"]} or answer(result)[1] == {
        "friction"
    }
    assert result.summary["error"]["floor"] == pytest.approx(0.25, rel=0.3)


def test_millimetres_and_newtons_in_one_run(make_lab, few_effects) -> None:
    """Each unit has its own floor, so that numbers of another size do not drown the others."""
    few_effects("marker_slip", "frame", "rest_shape", "drift")
    lab = make_lab(chambers=2, captures=40)
    data = lab.dataset(slipped(lab) + lab.noise())
    grip = 1000.0 * lab.u.mean(axis=2, keepdims=True) + 200.0 * lab.random.normal(size=(40, 3, 1))
    data["observed"] = (("capture", "time", "observable"), grip)
    data = data.assign_coords(
        observable=["grip"],
        unit=("observable", ["N"]),
        marker_of=("observable", [""]),
        axis_of=("observable", [""]),
    )
    model = lab.model()
    (lab.folder / "base.py").write_text(
        (lab.folder / "base.py").read_text().replace("def predict", "def markers")
        + "\n\ndef predict(u):\n    return np.column_stack([markers(u), 1000.0 * u.mean(axis=1)])\n"
    )
    result = diagnose(data, model)
    assert answer(result) == ("identified", {"marker_slip"})
    assert result.summary["units"] == "mm"
    assert result.summary["error"]["base"] < 10
    assert result.summary["error"]["floor"] == pytest.approx(0.12, rel=0.4)


def test_markers_out_of_sight(make_lab) -> None:
    """Many values missing, a marker never seen and a capture never seen, change nothing of the verdict."""
    lab = make_lab(chambers=2, captures=40)
    values = (slipped(lab) + lab.noise()).reshape(40, -1, 6, 3)
    values[lab.random.random(values.shape[:3]) < 0.4] = np.nan
    values[:, :, 4] = np.nan
    values[11] = np.nan
    result = diagnose(lab.dataset(values.reshape(40, -1, 18)), lab.model())
    assert answer(result) == ("identified", {"marker_slip"})
    assert "m4" not in {w["name"] for w in result.summary["where"]}


def test_a_base_that_is_badly_wrong(make_lab) -> None:
    """Half the reach and a wrong law: no claim that all is well, and the error does not rise by what is added."""
    lab = make_lab(chambers=2, captures=40)
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    lab.reach, lab.bent = 0.5 * lab.reach, 0.0
    result = diagnose(data, lab.model())
    assert result.summary["verdict"] not in {"nothing_missing", "underpowered"}
    assert result.summary["error"]["model"] <= result.summary["error"]["base"] * 1.001
    assert np.isfinite(result.summary["error"]["ceiling"])


def test_it_says_where(make_lab, few_effects) -> None:
    """The marker that slipped comes first among the markers, the captures after it among the captures."""
    few_effects("marker_slip", "frame", "drift")
    lab = make_lab(captures=40)
    values = lab.predict(lab.u) + lab.noise()
    values[30:, :, 9:12] += 3.0
    for result in (diagnose(lab.dataset(values), lab.model()), compare(lab.dataset(values), lab.model())):
        markers = [w for w in result.where if w["group"] == "marker"]
        assert markers[0]["name"] == "m3"
        assert markers[0]["clear"]
        assert markers[0]["share"] > 0.9
        assert not any(w["clear"] for w in markers[1:])
        assert {int(w["name"]) for w in result.where if w["group"] == "capture"} <= set(range(30, 40))
        times = [w for w in result.where if w["group"] == "time in session"]
        assert (
            max(times, key=lambda w: w["error"])["name"].split(" to ")[1].split()[0]
            == f"{lab.time_s.max():.3g}"
        )


def test_sessions_and_missing_repeats_are_noted(make_lab, few_effects) -> None:
    """What the answer rests on is said: unknown pressures between sessions, no repeats, outliers."""
    few_effects("marker_slip", "frame", "drift")
    lab = make_lab(captures=40, sessions=2, between="unknown", repeats=False)
    values = lab.predict(lab.u) + lab.noise()
    values[7, :, 4] += 40.0
    warnings = diagnose(lab.dataset(values), lab.model()).summary["warnings"]
    assert (
        "no repeats with the same history: the noise floor is an estimate, repeat some set-points" in warnings
    )
    said = "what the pressures did between sessions is unknown: taken as vented; `between_sessions:` in the mapping"
    assert any(line.startswith(said) for line in warnings)
    assert any(" outlying values were left out (" in w and " of m1" in w for w in warnings)


def test_measurements_that_are_the_model_itself_lack_nothing(make_lab) -> None:
    """A simulation of the model, to the last digit, is as good as it can be: no question of units."""
    lab = make_lab(captures=40, repeats=False)
    summary = diagnose(lab.dataset(lab.predict(lab.u)), lab.model()).summary
    assert (summary["verdict"], summary["probability"]) == ("nothing_missing", 1.0)


@pytest.mark.parametrize("steps", [True, False])
def test_what_may_be_an_error_of_each_set_point_is_said(make_lab, few_effects, steps: bool) -> None:
    """A regulator in steps of 6 kPa looks like noise where nothing is repeated: rows of a hold are quieter by far."""
    few_effects("regulator", "creep", "drift")
    lab = make_lab(chambers=1, captures=60, repeats=False, force=True)
    u = np.round(lab.u / 6.0) * 6.0 if steps else lab.u
    warnings = diagnose(lab.dataset(lab.predict(u) + lab.noise(0.4, 0.1)), lab.model()).summary["warnings"]
    (line,) = [w for w in warnings if "repeat some set-points" in w]
    assert line.startswith("captures are off by" if steps else "no repeats with the same history")


def test_the_last_run_alone_remembers_those_before(make_lab) -> None:
    """Only its own rows count, and it begins with what the others have left."""
    lab = make_lab(captures=8, repeats=False)
    runs = [
        lab.dataset(lab.predict(lab.u) + off).assign_attrs(between_sessions="vented", start_s=start)
        for off, start in ((0.0, 1000.0), (0.5, 8200.0))
    ]
    rows = last_of(runs)
    assert rows.values == pytest.approx(rows_from(runs[1]).values)
    assert rows.goes_on == (1,)
    assert lab.model().predictor(rows).context(rows).started[rows.event[0]] == 8
    errors = [compare(given, lab.model(), only_last=last).summary["error"]["model"]
              for given, last in ((runs, True), (runs[1:], False), (runs, False))]  # fmt: skip
    assert errors[0] == pytest.approx(errors[1]) == pytest.approx(0.5)
    assert errors[2] < 0.4


def test_two_runs_are_diagnosed_together(make_lab, few_effects) -> None:
    """Several runs of one rig make one diagnosis; each is its own session."""
    few_effects("marker_slip", "frame", "rest_shape", "drift")
    one = make_lab(chambers=2, captures=24)
    two = make_lab(chambers=2, captures=24, seed=1)
    after = two.predict(two.u)
    after[:, :, 9:12] += 2.0
    data = [one.dataset(slipped(one) + one.noise()), two.dataset(after + two.noise())]
    result = diagnose(data, one.model())
    assert answer(result) == ("identified", {"marker_slip"})
    assert set(result.fields["session"].values) == {"1:s0", "2:s0"}
    assert result.fields.sizes["capture"] == 48


@pytest.mark.parametrize(
    "settings", [{"force": True, "chambers": 1}, {"markers": 4}], ids=["force", "markers"]
)
def test_where_nothing_is_missing_no_place_stands_out(make_lab, settings: dict) -> None:
    """Of two hundred captures one is always the worst: that is chance, and is not called a place where it fails."""
    clear = 0
    for seed in range(3):
        lab = make_lab(captures=200, seed=seed, **settings)
        run = lab.dataset(lab.predict(lab.u) + lab.noise())
        found = compare(run, lab.model()).summary
        clear += sum(place["clear"] for place in found["where"])
    assert clear <= 1
