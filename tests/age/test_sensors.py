"""Leaks and zeros of sensors with coarse digits, of vacuum, and of rigs that do both."""

import numpy as np
import pytest
import xarray as xr

from labrig.age import Reading, Series, changes
from labrig.age._sensors import sensor_readings

DAYS, CHANGED, LEAK = 40, 20, 5.0
ALPHA = 0.05 / 60


def recorded(
    held_kpa: list[float],
    *,
    leak: float = 0.0,
    zero_kpa: float = 0.0,
    digit_kpa: float = 0.0,
    noise_kpa: float = 0.005,
    limits_kpa: tuple[float, float] = (0.0, 60.0),
    duration_s: float = 90.0,
    seed: int = 0,
) -> xr.Dataset:
    """A run of one chamber that loses `leak` % a minute: filling up once, a rest, and some held set-points."""
    random, time_s = np.random.default_rng(seed), np.arange(0, duration_s, 0.2)
    filling = np.linspace(*limits_kpa, len(time_s))
    commanded = np.array([0.0, 0.0, *held_kpa])
    true = np.array([filling, *(kpa * (1 - leak / 100 * time_s / 60) for kpa in commanded[1:])])
    measured = true + zero_kpa + noise_kpa * random.normal(size=true.shape)
    if digit_kpa:
        measured = np.round(measured / digit_kpa) * digit_kpa
    settled = np.ones(measured.shape, dtype=bool)
    settled[0] = False
    return xr.Dataset(
        {
            "measured": (("capture", "row", "chamber"), measured[..., None]),
            "hold_s": (("capture", "row"), np.tile(time_s + 3, (len(commanded), 1))),
            "settled": (("capture", "row"), settled),
            "commanded": (("capture", "chamber"), commanded[:, None], {"units": "kPa"}),
            "chamber_min": ("chamber", [limits_kpa[0]]),
            "chamber_max": ("chamber", [limits_kpa[1]]),
        },
        coords={"chamber": ["c1"]},
    )


def read(run: xr.Dataset) -> dict[str, Reading]:
    """What the sensors say of a run."""
    return {each.group: each for each in sensor_readings(run) if each is not None}


def noticed(days: list[dict[str, Reading]], group: str) -> list[int]:
    """The days on which a reading's changes begin; every day must have one."""
    own = [day[group] for day in days]
    sd = np.array([np.nan if each.sd is None else each.sd for each in own])
    value = np.array([each.value for each in own])
    series = Series(np.arange(len(own), dtype=float), value, sd, np.array(["check"] * len(own)))
    return [change.begins for change in changes(series, ALPHA).changes]


@pytest.mark.parametrize(("noise_kpa", "duration_s"), [(0.005, 90.0), (0.02, 1.0)])
def test_a_coarse_digit_hides_no_change(noise_kpa: float, duration_s: float) -> None:
    """With 0.1 kPa a digit, each day has its readings, and a zero that steps by 2 kPa is found on its day."""
    days = [
        read(
            recorded(
                [20, 40], digit_kpa=0.1, noise_kpa=noise_kpa, duration_s=duration_s, seed=day,
                zero_kpa=2.0 * (day >= CHANGED),
            )
        )
        for day in range(DAYS)
    ]  # fmt: skip
    assert noticed(days, "zero") == [CHANGED]
    assert noticed(days, "leak") == []


def test_a_leak_shows_through_a_coarse_digit() -> None:
    """Its first day is found, though the sensor reads the same all the time before."""
    days = [
        read(recorded([20, 40], digit_kpa=0.1, leak=LEAK * (day >= CHANGED), seed=day)) for day in range(DAYS)
    ]
    assert days[0]["leak"].value == (0.0,)
    assert noticed(days, "leak") == [CHANGED]


def test_what_never_moves_is_as_unsure_as_its_digit() -> None:
    """A reading that stays is off by a rounding, in the zero and at both ends of a hold, and not by nothing."""
    found = read(recorded([40], digit_kpa=0.1, zero_kpa=1.3, noise_kpa=0.0))
    assert found["zero"].value[0] == pytest.approx(1.3)
    assert found["zero"].sd == pytest.approx(0.1 / np.sqrt(12), rel=1e-3)
    assert found["leak"].value == (0.0,)
    assert found["leak"].sd == pytest.approx(0.1 / np.sqrt(6) / 89.8 * 6000 / 41.3, rel=1e-3)


@pytest.mark.parametrize(
    ("limits_kpa", "held_kpa", "zero_kpa"),
    [
        ((-60.0, 0.0), [-20, -40, -60], 0.0),
        ((-60.0, 0.0), [-20, -40, -60], 0.5),
        ((-60.0, 60.0), [20, -40, -60], 0.5),
    ],
)
def test_a_leak_of_vacuum_is_one_of_pressure(
    limits_kpa: tuple[float, float], held_kpa: list[float], zero_kpa: float
) -> None:
    """It has the size that it has, whichever way the chamber is driven, and vented chambers say nothing of it."""
    found = read(recorded(held_kpa, leak=LEAK, zero_kpa=zero_kpa, limits_kpa=limits_kpa))
    assert found["leak"].value[0] == pytest.approx(LEAK, rel=0.08)
    assert found["leak"].sd is not None
    assert found["leak"].sd < 0.1
