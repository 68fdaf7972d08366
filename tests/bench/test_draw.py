"""Blind campaigns: reproducible, of the layout that everything reads, and hiding what they say they hide."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.bench import CLASSES, Campaign, draw, make_base, own_error, write_campaign


def _residual(campaign: Campaign) -> np.ndarray:
    """Measured minus base, (capture, time, observable)."""
    data = campaign.dataset
    seen = data["position_mm"].values if "position_mm" in data else data["observed"].values
    assert campaign.base is not None
    return seen.reshape(*seen.shape[:2], -1) - make_base(campaign.base)(data["commanded"].values)[:, None]


@pytest.mark.parametrize("name", list(CLASSES))
def test_a_campaign_has_the_layout_of_the_reference(name: str) -> None:
    """Every class gives datasets whose events, captures, rows and coordinates agree with each other."""
    for seed in range(2):
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
            assert data["commanded"].values.max() <= 60.0
        assert len(campaign.truth["effects"]) == CLASSES[name].effects


def test_class_and_seed_fix_a_campaign() -> None:
    """The same class and seed give the same numbers; another seed gives others."""
    one, same, other = draw("pair", 4), draw("pair", 4), draw("pair", 5)
    assert one.truth == same.truth
    assert one.dataset.identical(same.dataset)
    assert one.truth != other.truth


def test_a_null_differs_from_its_base_by_noise_alone() -> None:
    """In a white null the middle of the residuals has the spread of the noise that was asked for."""
    for seed in range(6):
        campaign = draw("null", seed)
        spread = np.nanmedian(np.abs(_residual(campaign))) / 0.6745
        how = campaign.truth["spoil"]
        assert spread == pytest.approx(np.hypot(how["row"], how["capture"]), rel=0.15)


def test_the_hard_null_carries_slow_noise_that_all_markers_share() -> None:
    """Captures' common offset has half a floor of spread and an autocorrelation that falls by 0.9 a step."""
    squares, lag_one, lag_two = [], [], []
    for seed in range(20):
        campaign = draw("null-slow", seed)
        if campaign.truth["body"].get("surface") != "mannequin":
            continue
        rest = _residual(campaign)
        common = np.nanmedian(rest.reshape(*rest.shape[:2], -1, 3), axis=(1, 2)) / campaign.truth["floor"]
        squares.append(np.mean(common**2))
        lag_one.append(np.mean(common[1:] * common[:-1]))
        lag_two.append(np.mean(common[2:] * common[:-2]))
    assert np.sqrt(np.mean(squares)) == pytest.approx(0.5, rel=0.2)
    assert np.sum(lag_two) / np.sum(lag_one) == pytest.approx(0.9, abs=0.08)


def test_an_effect_is_as_large_as_the_class_says() -> None:
    """Single effects of class single-1 and single-2 change the observables by one and two floors."""
    for name, floors in (("single-1", 1.0), ("single-2", 2.0)):
        for seed in range(4):
            truth = draw(name, seed).truth
            assert next(iter(truth["amplitudes"].values())) == pytest.approx(floors, rel=0.05)


def test_a_structural_error_has_one_to_two_floors() -> None:
    """The base of class structural is wrong in form by the size that was drawn."""
    for seed in range(3):
        campaign = draw("structural", seed)
        pressure = campaign.dataset["event_commanded"].values
        right = make_base({**campaign.base, "error": None})(pressure)
        size = np.sqrt(np.mean((make_base(campaign.base)(pressure) - right) ** 2)) / campaign.truth["floor"]
        assert 0.9 < size < 2.2
        assert own_error(campaign.base, pressure) == pytest.approx(size * campaign.truth["floor"])
        assert own_error({**campaign.base, "error": None}, pressure) == 0.0


def test_deleting_what_is_hidden_makes_unknown_the_right_answer() -> None:
    """A campaign whose effect the library will not have asks for the verdict unknown."""
    plain = draw("single-2", 1)
    without = draw("single-2", 1, without=tuple(plain.truth["effects"]))
    assert plain.truth["verdict"] == "identified"
    assert without.truth["verdict"] == "unknown"
    assert without.dataset.identical(plain.dataset)


def test_a_class_that_does_not_exist_is_named() -> None:
    """An unknown class is one line that lists the known ones."""
    with pytest.raises(LabrigError, match=r"^bench: there is no class 'single' \(known: null, null-slow, "):
        draw("single", 0)


@pytest.mark.parametrize(("name", "seed"), [("force", 1), ("null-static", 1), ("confounded", 0), ("pair", 1)])
def test_plain_files_hold_the_whole_campaign(name: str, seed: int, tmp_path: Path) -> None:
    """The table has a row for every moment and every silent actuation; the base in base.py is the campaign's."""
    import pandas as pd

    campaign = draw(name, seed)
    write_campaign(campaign, tmp_path)
    frame = pd.read_csv(tmp_path / "table.csv")
    data = campaign.dataset
    silent = data.sizes["event"] - len(set(data["event_of"].values.tolist()))
    assert len(frame) == int(np.isfinite(data["hold_s"].values).sum()) + silent
    mapping = yaml.safe_load((tmp_path / "map.yaml").read_text())
    for column in [mapping["time"], *mapping["actuation"], *mapping["observables"]]:
        assert column["column"] in frame
    assert json.loads((tmp_path / "truth.json").read_text())["class"] == name
    model = yaml.safe_load((tmp_path / "model.yaml").read_text())
    if campaign.base is None:
        assert model["base"] == {"kind": "static", "degree": 1}
    else:
        scope: dict = {}
        exec((tmp_path / "base.py").read_text(), scope)
        pressure = data["commanded"].values[:3]
        np.testing.assert_array_equal(scope["predict"](pressure), make_base(campaign.base)(pressure))


def test_the_files_make_the_same_campaign_again(tmp_path: Path) -> None:
    """Imported, the table gives the drawn Dataset back, to the digits that it has."""
    from labrig.log import import_table

    campaign = draw("force", 1)
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
