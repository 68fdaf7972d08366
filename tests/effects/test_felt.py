"""What rubs with one force wherever the base is steep or flat: a seal on a rig whose slopes differ."""

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.model import Model
from tests.naming import verdict_of

BASES = {
    "a product": lambda u: (0.006 * u[:, 0] * u[:, 1])[:, None],
    "a parabola": lambda u: (0.008 * u[:, 1] ** 2 + 0.2 * u[:, 0])[:, None],
    "a plane": lambda u: (0.3 * u[:, 1] + 0.2 * u[:, 0])[:, None],
}


def campaign(base, law, seed: int = 0):
    """A force over pressure and stroke, by a base and a law of the stroke, three rows a set-point, as a run."""
    random = np.random.default_rng(seed)
    u = np.stack([random.uniform(0, 100, 60), random.uniform(0, 40, 60)], axis=1)
    rows = np.repeat(np.arange(60), 3)
    force = (base(u)[:, 0] + law(u[:, 1]))[rows] + random.normal(0, 0.1, 180)
    columns = {
        "t (s)": 9.0 * rows + np.tile([0, 2, 4], 60),
        "p_set (kPa)": u[rows, 0],
        "x_set (mm)": u[rows, 1],
    }
    return labrig.import_table(pd.DataFrame(columns | {"F (N)": force}), "run")


@pytest.fixture(autouse=True)
def _there(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def stribeck(x: np.ndarray) -> np.ndarray:
    """Against the motion, by Stribeck's curve of the way that was gone: R. Stribeck, Z. VDI 46 (1902)."""
    way = np.diff(x, prepend=0.0)
    return 0.4 * np.sign(way) * (1 + 0.3 * np.exp(-np.abs(way) / 5.0))


@pytest.mark.parametrize("base", BASES)
def test_a_seal_rubs_as_hard_where_a_lever_is_short(base: str) -> None:
    """A force of one size against each motion is friction, however the base's slope changes."""
    assert verdict_of(campaign(BASES[base], stribeck), Model.of(BASES[base])).effects == ("friction",)


@pytest.mark.parametrize("base", BASES)
def test_noise_alone_is_felt_as_nothing(base: str) -> None:
    """The same rigs with nothing hidden."""
    assert (
        verdict_of(campaign(BASES[base], np.zeros_like), Model.of(BASES[base])).verdict == "nothing_missing"
    )


def test_its_formula_takes_it_off() -> None:
    """What is named lowers the error on captures that were left out: the force has a value for each input."""
    base = BASES["a product"]
    better = labrig.improve(campaign(base, stribeck), base, "friction")
    assert better.error["model"] < 0.4 * better.error["base"]
    assert set(better.model.file.effects[0].parameters) == {"force"}
