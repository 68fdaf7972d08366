"""Rigs whose sensors have several units, and are not equally noisy: each number counts by its own noise."""

from pathlib import Path

import numpy as np
import pytest

from labrig.bench import Campaign, draw, make_base, make_rig, own_error, write_campaign
from labrig.bench._bases import draw_base
from labrig.bench._halves import half_of
from labrig.bench._learner import capture_error
from labrig.bench._nature import Rig
from labrig.bench._noise import Spoil, spoil
from labrig.bench._stopping import acted
from labrig.effects import rows_of


def _rig(kind: str = "elbow", seed: int = 0) -> Rig:
    return half_of("twelfth").rigs[kind](np.random.default_rng(seed))


def _spoilt(rig: Rig, how: Spoil, captures: int = 800, rows: int = 4) -> np.ndarray:
    """The noise alone of captures, (F, T, K)."""
    true = np.zeros((captures * rows, len(rig.observables)))
    capture = np.repeat(np.arange(captures), rows)
    return spoil(true, rig, capture, how, np.random.default_rng(1)).reshape(captures, rows, -1)


def test_each_sensor_has_the_noise_of_its_unit() -> None:
    """Row and capture noise of each number is the rig's times how noisy it is, and outliers are as large for it."""
    rig = _rig()
    own = np.asarray(rig.noisier)
    assert np.ptp(own) > 0.2
    rows = _spoilt(rig, Spoil(row=0.3, capture=0.0)).reshape(-1, len(own))
    np.testing.assert_allclose(rows.std(axis=0), 0.3 * own, rtol=0.05)
    captures = _spoilt(rig, Spoil(row=0.0, capture=0.3))[:, 0]
    np.testing.assert_allclose(captures.std(axis=0), 0.3 * own, rtol=0.12)
    wild = np.abs(_spoilt(rig, Spoil(row=1e-9, capture=1.0, outliers=0.2), 4000)).max(axis=(0, 1))
    np.testing.assert_allclose(wild / own, (wild / own).mean(), rtol=0.5)


def test_slow_noise_is_shared_by_sensors_of_one_unit_only() -> None:
    """Two angles wander together, an angle and a force each for itself, by as much as they are noisy."""
    rig = next(r for r in (_rig(seed=s) for s in range(20)) if len(r.observables) == 6)
    unit = np.array([o.unit for o in rig.observables])
    slow = _spoilt(rig, Spoil(row=1e-9, capture=1e-9, common=1.0), 4000)[:, 0]
    alike = np.corrcoef(slow.T)
    same = unit[:, None] == unit
    assert alike[same].min() > 0.999
    assert np.abs(alike[~same]).max() < 0.3
    np.testing.assert_allclose(slow.std(axis=0), rig.noisier, rtol=0.3)


def _campaign(name: str = "single") -> Campaign:
    """A campaign of sensors whose noises are far apart."""
    campaigns = (draw(name, seed, "twelfth", captures=24) for seed in range(30))
    return next(c for c in campaigns if np.ptp(make_rig(c.truth["base"]).noisier) > 0.4)


def test_sizes_are_in_each_numbers_own_floor() -> None:
    """An effect is as large as it was drawn if each number counts by its own floor, and not in raw units."""
    campaign = _campaign()
    truth, noisier = campaign.truth, make_rig(campaign.truth["base"]).noisier
    (name,) = truth["effects"]
    raw, own = (np.sqrt(np.mean((campaign.parts[name] / n) ** 2)) / truth["floor"] for n in (1.0, noisier))
    assert own == pytest.approx(truth["amplitudes"][name], rel=1e-6)
    assert raw != pytest.approx(truth["amplitudes"][name], rel=0.02)
    assert acted(campaign, truth["captures"]) == {name: pytest.approx(own)}
    assert truth["unit"] == " and ".join(dict.fromkeys(o.unit for o in make_rig(truth["base"]).observables))


def test_wrong_bases_are_wrong_by_each_numbers_own_floor() -> None:
    """A structural error, and what is left of an exact base, count each number by its own floor."""
    campaign = _campaign("structural")
    truth, rig = campaign.truth, make_rig(campaign.truth["base"])
    kpa = campaign.dataset["event_commanded"].values
    off = (make_base(truth["base"])(kpa) - rig.settled(kpa)) / rig.noisier
    assert np.sqrt(np.mean(off**2)) == pytest.approx(truth["structural"], rel=0.05)
    assert own_error(truth["base"], kpa) == pytest.approx(truth["structural"], rel=0.05)
    kinds = [draw_base(truth["base"], kpa, truth["floor"], np.random.default_rng(s), 0.0) for s in range(20)]
    assert max(own_error(recipe, kpa) for recipe in kinds) < 0.5 * truth["floor"]


def test_errors_on_fresh_campaigns_are_in_each_numbers_own_noise() -> None:
    """The noisiest sensor that is wrong by three of its own noises adds nine over the number of sensors, squared."""
    campaign = _campaign()
    rig, rows = make_rig(campaign.truth["base"]), rows_of(campaign.fresh)
    right, own = rig.settled(rows.actuation), np.asarray(rig.noisier)
    off = np.where(np.arange(len(own)) == np.argmax(own), 3.0 * own, 0.0)
    level, up, down = (capture_error(rows, right + d, rig.noisier) ** 2 for d in (0.0, off, -off))
    assert 0.5 * (up + down) - level == pytest.approx(9.0 / len(own), rel=1e-6)


@pytest.mark.parametrize("kind", half_of("twelfth").rigs)
def test_files_keep_every_unit(kind: str, tmp_path: Path) -> None:
    """Written as plain files and imported, a campaign has the same numbers in the same units."""
    from labrig.log import import_table

    campaign = next(
        c for c in (draw("null", s, "twelfth", captures=12) for s in range(60)) if c.truth["rig"] == kind
    )
    write_campaign(campaign, tmp_path / "files")
    again, drawn = import_table(tmp_path / "files" / "map.yaml", tmp_path / "run"), campaign.dataset
    assert again["unit"].values.tolist() == drawn["unit"].values.tolist()
    assert len(set(drawn["unit"].values.tolist())) > 1
    np.testing.assert_allclose(again["observed"].values, drawn["observed"].values, atol=1e-3)
