"""Blind campaigns: reproducible, of the layout that everything reads, and hiding what they say they hide."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.bench import CLASSES, Campaign, draw, make_base, make_rig, own_error, write_campaign
from labrig.bench._bases import chambers_own_law, draw_base
from labrig.bench._hide import has
from labrig.bench._path import PAUSE_S, make_path
from labrig.bench._programmes import Plan, make_plan
from labrig.bench._size import strength_for

PADS = {"half": "development", "rig": "pads", "rig_seed": 1, "linear": False}


def _seen(campaign: Campaign) -> np.ndarray:
    """What was measured, (capture, time, observable)."""
    data = campaign.dataset
    seen = data["position_mm"].values if "position_mm" in data else data["observed"].values
    return seen.reshape(*seen.shape[:2], -1)


def _residual(campaign: Campaign) -> np.ndarray:
    """Measured minus what the rig would be without anything hidden."""
    base = make_base({**campaign.truth["base"], "kind": "exact"})
    return _seen(campaign) - base(campaign.dataset["commanded"].values)[:, None]


@pytest.mark.parametrize("name", list(CLASSES))
def test_a_campaign_has_the_layout_of_the_reference(name: str) -> None:
    """Every class gives datasets whose events, captures, rows and coordinates agree with each other."""
    for seed in range(3):
        campaign = draw(name, seed)
        for data in (campaign.dataset, campaign.fresh):
            event = data["event_of"].values
            np.testing.assert_array_equal(data["event_commanded"].values[event], data["commanded"].values)
            np.testing.assert_array_equal(data["event_session"].values[event], data["session"].values)
            assert (np.diff(data["event_time_s"].values) > 0).all()
            began = (
                data["time_s"].values - data["hold_s"].values - data["event_time_s"].values[event][:, None]
            )
            assert np.nanmax(np.abs(began)) < 1e-6
            assert np.isfinite(data["hold_s"].values[:, 0]).all()
            assert (data["commanded"].values <= data["chamber_max"].values).all()
        assert len(campaign.truth["effects"]) == len(campaign.truth["laws"]) == CLASSES[name].effects


def test_class_seed_and_half_fix_a_campaign() -> None:
    """The same class, seed and half give the same numbers; another seed or half gives others."""
    one, same = draw("pair", 4, captures=20), draw("pair", 4, captures=20)
    assert one.truth == same.truth
    assert one.dataset.identical(same.dataset)
    assert one.truth != draw("pair", 5, captures=20).truth
    assert not one.dataset.equals(draw("pair", 4, "exam", captures=20).dataset)


def test_a_null_differs_from_its_rig_by_noise_alone() -> None:
    """In a white null the middle of the residuals has the spread of the noise that was asked for."""
    for seed in range(6):
        campaign = draw("null", seed)
        spread = np.nanmedian(np.abs(_residual(campaign))) / 0.6745
        how = campaign.truth["spoil"]
        assert spread == pytest.approx(np.hypot(how["row"], how["capture"]), rel=0.15)


def test_the_hard_null_carries_slow_noise_that_all_markers_share() -> None:
    """Captures' common offset has half a floor of spread and an autocorrelation that falls by 0.9 a step."""
    squares, lag_one, lag_two = [], [], []
    for seed in range(30):
        campaign = draw("null-slow", seed, captures=150)
        if campaign.truth["rig"] != "pads":
            continue
        rest = _residual(campaign)
        common = np.nanmean(rest.reshape(*rest.shape[:2], -1, 3).clip(-1.0, 1.0), axis=(1, 2))
        common /= campaign.truth["floor"]
        squares.append(np.mean(common**2) - 1.0 / 5)  # the mean over five markers has noise of its own
        lag_one.append(np.mean(common[1:] * common[:-1]))
        lag_two.append(np.mean(common[2:] * common[:-2]))
    assert np.sqrt(np.mean(squares)) == pytest.approx(0.5, rel=0.2)
    assert np.sum(lag_two) / np.sum(lag_one) == pytest.approx(0.9, abs=0.08)


def test_effects_are_as_large_as_the_class_says() -> None:
    """What each law changes at the rows of the campaign, alone, has the size in floors that the truth tells."""
    for name, (low, high) in (("single-1", (1.0, 1.0)), ("single", (2.0, 4.0)), ("pair", (1.0, 2.0))):
        for seed in range(4):
            campaign = draw(name, seed, captures=40)
            truth = campaign.truth
            rows = int(np.isfinite(campaign.dataset["hold_s"].values).sum())
            for effect in truth["effects"]:
                part = campaign.parts[effect]
                assert part.shape == (rows, _seen(campaign).shape[2])
                floors = np.sqrt(np.mean(part**2)) / truth["floor"]
                assert floors == pytest.approx(truth["amplitudes"][effect])
                assert 0.97 * low < floors < 1.03 * high


def test_parts_are_in_the_order_of_the_rows() -> None:
    """Without what a law changes, the rows of a campaign are its rig's settled states and noise."""
    campaign = draw("single", 0, captures=60)
    (part,) = campaign.parts.values()
    inside = np.isfinite(campaign.dataset["hold_s"].values)
    left = _residual(campaign)[inside]
    noise = np.hypot(campaign.truth["spoil"]["row"], campaign.truth["spoil"]["capture"])
    assert np.nanmedian(np.abs(left - part)) / 0.6745 == pytest.approx(noise, rel=0.15)
    assert np.nanmedian(np.abs(left)) / 0.6745 > 1.2 * noise


def test_laws_get_only_what_they_need() -> None:
    """A law that needs a tilt or markers is hidden where there are some, and the tilt is logged."""
    seen = 0
    for seed in range(12):
        campaign = draw("single", seed, captures=30)
        if campaign.truth["effects"] == ["gravity"]:
            seen += 1
            assert campaign.truth["rig"] != "cell"
            assert "tilt" in campaign.dataset["covariate"].values
            assert "tilt" in campaign.fresh["covariate"].values
    assert seen


def test_what_a_rig_and_a_path_have() -> None:
    """Markers, several chambers and a curve are the rig's; long holds, tilts and weights the programme's."""
    random = np.random.default_rng(0)
    pads, cell = make_rig(PADS), make_rig({**PADS, "rig": "cell"})
    assert has(pads) == {"markers", "marker", "several", "curved"}
    assert has(cell) == {"curved", "force"}
    assert has(make_rig({**PADS, "linear": True})) == {"markers", "marker", "several"}
    plain = make_plan("holds", random, pads.high_kpa, 10, False, long_share=0.0)
    rich = make_plan("walk", random, pads.high_kpa, 40, False, True, long_share=0.5, loaded=True)
    assert has(cell, make_path(plain)) == {"curved", "force"}
    assert has(cell, make_path(rich)) == {"curved", "force", "holds", "tilt", "payload"}


def test_a_path_is_fine_where_things_move() -> None:
    """Chambers follow within half a second, rows are where the plan has them, sessions have their own clock."""
    plan = make_plan("sessions", np.random.default_rng(1), np.array([60.0, 50.0]), 30, long_share=0.3)
    path = make_path(plan)
    rows = np.concatenate([t + r for t, r in zip(plan.capture_s, plan.capture_rows_s, strict=True)])
    np.testing.assert_array_equal(path.time_s[path.row], rows)
    assert (np.diff(path.time_s) > 0.01).all()
    late = path.hold_s > 0.5
    assert np.abs(path.kpa - path.commanded_kpa)[late].max() < 0.02 * 60.0
    assert (path.session_s >= 0).all()
    first = [path.session_s[path.session == s].min() for s in range(plan.session + 1)]
    np.testing.assert_array_equal(first, 0.0)
    assert np.bincount(path.event).min() >= 8


def test_a_later_path_begins_with_what_was_before() -> None:
    """The history of the earlier plan and a pause come first, and only the later rows are measured."""
    random = np.random.default_rng(1)
    before = make_plan("walk", random, np.array([60.0]), 10, False)
    after = Plan(random, np.array([60.0]))
    after.capture(np.array([30.0]), 5.0, 4)
    path, alone = make_path(after, before=before), make_path(after)
    assert len(path.row) == 4
    np.testing.assert_allclose(path.time_s[path.row] - alone.time_s[alone.row], before.time_s + PAUSE_S)
    assert path.session[path.row[0]] == 1
    assert path.kpa[path.event == path.event[-1] - 1][-1] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(path.kpa[path.row], alone.kpa[alone.row])


@pytest.mark.parametrize("law", [lambda s: 3.0 * s, lambda s: s**3 + 0.1 * s, lambda s: np.tanh(s)])
def test_a_size_is_found_where_there_is_one(law) -> None:
    """Whatever the law, its strength gives the wanted size; and there is none where it does not get there."""
    for wanted in (0.01, 0.5, 0.9):
        strength = strength_for(law, wanted, 8.0)
        assert strength is not None
        assert law(strength) == pytest.approx(wanted, rel=0.021)
    assert strength_for(law, 1e4, 8.0) is None


def test_bases_of_every_kind_are_rebuilt_from_plain_data() -> None:
    """A recipe that went through JSON makes the same base; a learnt one is close, a clipped one stops at limits."""
    kpa = np.random.default_rng(0).uniform(-5.0, 65.0, (40, 3))
    rig = make_rig(PADS)
    inside = np.clip(kpa, 0.0, rig.high_kpa)
    found = set()
    for seed in range(30):
        recipe = draw_base(PADS, inside, 0.15, np.random.default_rng(seed), 0.0)
        again = make_base(json.loads(json.dumps(recipe)))
        np.testing.assert_array_equal(again(kpa), make_base(recipe)(kpa))
        assert own_error(recipe, inside) < 0.5 * 0.15
        found.add(recipe["kind"])
    assert found == {"exact", "clipped", "learnt"}
    np.testing.assert_array_equal(make_base({**PADS, "kind": "clipped"})(kpa), rig.settled(inside))


def test_a_structural_error_has_one_to_two_floors() -> None:
    """The base of class structural is wrong in form by the size that was drawn, and may go by what it is."""
    for seed in range(3):
        campaign = draw("structural", seed, captures=60)
        truth, pressure = campaign.truth, campaign.dataset["event_commanded"].values
        assert truth["base_kind"] == "wrong"
        assert 0.9 < truth["structural"] / truth["floor"] < 2.1
        assert own_error(truth["base"], pressure) == pytest.approx(truth["structural"], rel=0.1)
        assert chambers_own_law(truth["base"], pressure)
        assert truth["also"] == ["contact", "regulator", "stiffening", "tension"]


def test_a_static_base_leaves_what_is_hidden() -> None:
    """Where the base is a map fitted to the campaign, a rig is linear, and the size is that of what the map leaves."""
    campaign = draw("static", 0, captures=60)
    assert campaign.base is None
    rig = make_rig(campaign.truth["base"])
    kpa = np.random.default_rng(0).uniform(0.0, 40.0, (9, len(rig.chambers)))
    middle = 0.5 * (rig.settled(kpa) + rig.at_rest)
    np.testing.assert_allclose(rig.settled(0.5 * kpa), middle, atol=1e-9)


def test_deleting_what_is_hidden_makes_unknown_the_right_answer() -> None:
    """A campaign whose effect the library will not have asks for the verdict unknown."""
    plain = draw("single", 1, captures=20)
    without = draw("single", 1, without=tuple(plain.truth["effects"]), captures=20)
    assert plain.truth["verdict"] == "identified"
    assert without.truth["verdict"] == "unknown"
    assert without.dataset.identical(plain.dataset)
    deleted = draw("deleted", 0, captures=20).truth
    assert set(deleted["effects"]) < set(deleted["without"])
    assert deleted["verdict"] == draw("outside", 0, captures=20).truth["verdict"] == "unknown"


def test_names_that_do_not_exist() -> None:
    """An unknown class or half is one line that lists the known ones."""
    with pytest.raises(LabrigError, match=r"^bench: there is no class 'force' \(known: null, null-slow, "):
        draw("force", 0)
    with pytest.raises(
        LabrigError,
        match=r"^bench: there is no half 'thirteenth' \(known: development, exam, third, fourth, fifth, sixth, "
        r"seventh, eighth, ninth, tenth, eleventh, twelfth\)",
    ):
        draw("null", 0, "thirteenth")


def test_only_what_is_plain_is_pickled() -> None:
    """A campaign goes to another process without what can be measured later and without what is hidden in it."""
    campaign = pickle.loads(pickle.dumps(draw("single", 0, captures=20)))
    assert campaign.later is None
    assert campaign.parts == {}
    assert campaign.truth["effects"]


def _of_rig(name: str, rig: str) -> Campaign:
    """The first small campaign of a class with such a rig."""
    return next(c for c in (draw(name, seed, captures=20) for seed in range(50)) if c.truth["rig"] == rig)


@pytest.mark.parametrize("rig", ["pads", "cell", "flat"])
@pytest.mark.parametrize("name", ["null-static", "single-1", "confounded"])
def test_plain_files_hold_the_whole_campaign(name: str, rig: str, tmp_path: Path) -> None:
    """The table has a row for every moment and every silent actuation; the base in base.py is the campaign's."""
    import pandas as pd

    campaign = _of_rig(name, rig)
    write_campaign(campaign, tmp_path)
    frame = pd.read_csv(tmp_path / "table.csv")
    data = campaign.dataset
    silent = data.sizes["event"] - len(set(data["event_of"].values.tolist()))
    assert len(frame) == int(np.isfinite(data["hold_s"].values).sum()) + silent
    mapping = yaml.safe_load((tmp_path / "map.yaml").read_text())
    for column in [mapping["time"], *mapping["actuation"], *mapping["observables"]]:
        assert column["column"] in frame
    assert json.loads((tmp_path / "truth.json").read_text()) == campaign.truth
    model = yaml.safe_load((tmp_path / "model.yaml").read_text())
    if campaign.base is None:
        assert model["base"] == {"kind": "static", "degree": 1}
    else:
        scope: dict = {}
        exec((tmp_path / "base.py").read_text(), scope)
        pressure = data["commanded"].values[:3]
        np.testing.assert_array_equal(scope["predict"](pressure), make_base(campaign.base)(pressure))


@pytest.mark.parametrize("rig", ["pads", "cell", "flat"])
def test_the_files_make_the_same_campaign_again(rig: str, tmp_path: Path) -> None:
    """Imported, the table gives the drawn Dataset back, to the digits that it has."""
    from labrig.log import import_table

    campaign = _of_rig("null-slow", rig)
    write_campaign(campaign, tmp_path / "files")
    again = import_table(tmp_path / "files" / "map.yaml", tmp_path / "run")
    drawn = campaign.dataset
    assert again.attrs["between_sessions"] == drawn.attrs["between_sessions"]
    for name in drawn.data_vars:
        if name in ("time_s", "event_time_s"):
            continue
        np.testing.assert_allclose(again[name].values, drawn[name].values, atol=1e-3)
    shift = again["event_time_s"].values - drawn["event_time_s"].values
    np.testing.assert_allclose(shift, shift[0], atol=2e-3)
    for name in ("session", "repeat", "event_of", "event_session"):
        np.testing.assert_array_equal(again[name].values, drawn[name].values)
