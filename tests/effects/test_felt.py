"""What rubs with one force wherever the base is steep or flat: a seal on a rig whose slopes differ."""

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.model import Model
from tests.naming import verdict_of

BASES = {
    "a product": lambda u: (0.006 * u[:, 0] * u[:, 1])[:, None],
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


@pytest.mark.parametrize("base", ["a product", "a plane"])
def test_a_seal_rubs_as_hard_where_a_lever_is_short(base: str) -> None:
    """A force of one size against each motion is friction, however the base's slope changes."""
    assert verdict_of(campaign(BASES[base], stribeck), Model.of(BASES[base])).effects == ("friction",)


def test_noise_alone_is_felt_as_nothing() -> None:
    """Such a rig with nothing hidden."""
    base = BASES["a product"]
    assert verdict_of(campaign(base, np.zeros_like), Model.of(base)).verdict == "nothing_missing"


def test_its_formula_takes_it_off() -> None:
    """What is named lowers the error on captures that were left out: the force has a value for each input."""
    base = BASES["a product"]
    better = labrig.improve(campaign(base, stribeck), base, "friction")
    assert better.error["model"] < 0.4 * better.error["base"]
    assert set(better.model.file.effects[0].parameters) == {"force"}


def finger(u: np.ndarray) -> np.ndarray:
    """A finger in free air: it bends, and its tip presses nothing."""
    return np.stack([80.0 * np.tanh(u[:, 0] / 90.0), np.zeros(len(u))], axis=1)


def pressing(seed: int):
    """The finger with an object in its way: Hertz's law of the angle beyond it, a third of which is lost."""
    random = np.random.default_rng(seed)
    u = random.uniform(0, 100, (60, 1))
    angle = finger(u)[:, 0]
    beyond = np.maximum(angle - 42.0, 0.0)
    rows = np.repeat(np.arange(60), 3)
    read = np.stack([angle - beyond / 3.0, 0.03 * beyond**1.5], axis=1)[rows]
    read += random.normal(size=(180, 2)) * [0.5, 0.04]
    frame = pd.DataFrame({"p_set (kPa)": u[rows, 0], "bend (deg)": read[:, 0], "tip force (N)": read[:, 1]})
    return labrig.import_table(frame, f"run{seed}")


def test_what_a_sensor_reads_that_should_read_nothing_is_contact() -> None:
    """A force where the model has none, from a pressure on, beside an angle that lags: perhaps contact, and no other
    name; the model with it is near the noise on another run.
    """
    run = pressing(1)
    found = verdict_of(run, Model.of(finger))
    assert found.found == ("contact",)
    better = labrig.improve(run, finger, "contact")
    assert better.error["model"] < 0.2 * better.error["base"]
    fresh = labrig.compare(pressing(2), [finger, better.model])
    assert fresh.better == "second"
    assert fresh.error["second"] < 0.25 * fresh.error["first"]
