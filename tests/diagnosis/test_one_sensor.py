"""One sensor, or one marker, that reads wrongly is no effect of the rig: it is found by its name."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._one_sensor import of_one_sensor
from labrig.view._naming import carries
from tests.naming import verdict_of

REACH = np.array([[4.0, 1.0, 0.5, 2.0], [0.5, 3.0, 1.0, 1.5]])
"""Four sensors of two chambers, V at full pressure."""


def predicted(u: np.ndarray) -> np.ndarray:
    """Volts (F, 4) from kPa (F, 2): strain gauges of a body that stiffens."""
    x = u / 100.0
    return x * 1.4 / (1 + 0.4 * x) @ REACH


def table(read) -> pd.DataFrame:
    """Fifty set-points of three rows each, as these sensors `read` them."""
    random = np.random.default_rng(0)
    u = np.repeat(random.uniform(0, 100, (50, 2)).round(1), 3, axis=0)
    seen = read(predicted(u)) + random.normal(0, 0.03, (150, 4))
    time = np.repeat(np.arange(50) * 8.0, 3) + np.tile([3.0, 4.0, 5.0], 50)
    named = {f"gauge {k} (V)": seen[:, k].round(4) for k in range(4)}
    return pd.DataFrame({"t (s)": time, "p1 set (kPa)": u[:, 0], "p2 set (kPa)": u[:, 1], **named})


def one(read, which: int):
    """A fault in one of the sensors."""

    def of(volts: np.ndarray) -> np.ndarray:
        out = volts.copy()
        out[:, which] = read(volts[:, which])
        return out

    return of


def test_a_sensor_that_reads_wrongly_is_said_by_name(tmp_path) -> None:
    """Another gain and zero in one of four gauges: that one, and no effect."""
    run = labrig.import_table(table(one(lambda volts: 0.93 * volts + 0.05, 1)), tmp_path / "run")
    found = verdict_of(run, labrig.Model.of(predicted))
    assert (found.verdict, found.effects, found.carried_by) == ("unknown", (), "gauge 1 alone")


def test_a_wheel_that_is_out_of_true_is_found_beside_coarser_sensors(tmp_path) -> None:
    """An encoder that errs twice in a turn, by five times its noise; the forces beside it are coarse.

    Noise within holds is taken to be as in the coarsest sensor: what the encoder has less of it hides no error.
    """
    random = np.random.default_rng(1)
    u = np.repeat(random.uniform(60, 320, (60, 2)).round(1), 4, axis=0)

    def clean(u: np.ndarray) -> np.ndarray:
        angle = 45 * np.tanh((u[:, 0] - u[:, 1]) / 300)
        return np.stack([angle, 0.2 * u[:, 0] - 0.4 * angle, 0.2 * u[:, 1] + 0.4 * angle], axis=1)

    seen = clean(u) + random.normal(0, [0.15, 0.7, 2.1], (240, 3))
    seen[:, 0] += 1.1 * np.sin(np.deg2rad(4 * clean(u)[:, 0]) + 0.7)
    columns = {"t (s)": np.repeat(np.arange(60) * 8.0, 4) + np.tile([2.0, 3.0, 4.0, 5.0], 60)}
    columns |= {"P1 set (kPa)": u[:, 0], "P2 set (kPa)": u[:, 1], "joint (deg)": seen[:, 0].round(2)}
    columns |= {"F1 (N)": seen[:, 1].round(1), "F2 (N)": seen[:, 2].round(1)}
    run = labrig.import_table(pd.DataFrame(columns), tmp_path / "run")
    found = verdict_of(run, labrig.Model.of(clean))
    assert (found.verdict, found.carried_by) == ("unknown", "joint alone")


def test_what_all_sensors_read_wrongly_is_not_in_one(tmp_path) -> None:
    """Half of what is missing, or more, has to be in one."""
    run = labrig.import_table(table(lambda volts: 1.06 * volts), tmp_path / "run")
    found = verdict_of(run, labrig.Model.of(predicted))
    assert not any(what.endswith("alone") for what in found.beside)


def test_a_marker_that_is_seen_too_large_is_said_by_name(make_lab) -> None:
    """A marker of eight, with its three axes, that a worn lens shows farther out the farther out it is."""
    lab = make_lab(markers=8, captures=60, seed=4)
    positions = lab.predict(lab.u)
    rest = lab.predict(0 * lab.u)
    own = slice(15, 18)
    moved = positions[..., own] - rest[..., own]
    positions[..., own] += 0.25 * moved * np.linalg.norm(moved, axis=-1, keepdims=True) / np.abs(moved).max()
    found = verdict_of(lab.dataset(positions + lab.noise()), lab.model())
    assert (found.verdict, found.effects, found.carried_by) == ("unknown", (), "m5 alone")


def test_where_to_look_is_said() -> None:
    """A report says what to look at."""
    assert (
        carries("gauge 2 alone")
        == "is in gauge 2 alone: look at its calibration, its cable and its mount first"
    )


@pytest.mark.parametrize("wrong", [(2,), (2, 0, 1)])
def test_a_sensor_is_asked_about_where_it_has_half_of_what_is_missing(wrong: tuple[int, ...]) -> None:
    """Of three sensors, of which one is off, or all by about as much: then none is asked about by itself."""
    values = np.zeros((40, 3))
    values[:, list(wrong)] = 4.0
    values[:, wrong[0]] *= 1.02
    named = {"observables": ("a", "b", "c"), "unit": ("V",) * 3}
    rows = SimpleNamespace(marker=np.full(3, -1), owner=np.arange(3), fraction=np.ones((40, 1)), **named)
    context = SimpleNamespace(
        rows=rows,
        base=np.ones((40, 3)),
        displacement=np.ones((40, 3)),
        yardstick=lambda _, measure: measure(),
    )
    seen = SimpleNamespace(context=context, values=values, left=np.ones(40), seen=np.ones(3, dtype=bool))
    asked = [space.key for space in of_one_sensor(cast(Any, seen))]
    assert asked == (["c alone, gain", "c alone"] if wrong == (2,) else [])


def test_what_is_less_than_noise_within_holds_hides_no_error_of_means() -> None:
    """Means are off by two noises, and contrasts have a tenth of the noise that was taken for them."""
    own = SimpleNamespace(
        values=np.concatenate([np.full((10, 1), 2.0), np.full((20, 1), 0.1)]),
        left=np.ones(30),
        seen=np.ones(1, dtype=bool),
        n_captures=10,
        counts_for=np.full(30, 1 / 30),
    )
    to_explain = Observations.__dict__["to_explain"].func(own)
    assert to_explain == pytest.approx(np.sqrt(10 * (2.0**2 - 1) / 30))
