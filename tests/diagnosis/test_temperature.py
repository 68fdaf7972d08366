"""A room temperature that was logged: what follows it is drift, through whatever it does so."""

import numpy as np
import pytest

from tests.naming import verdict_of


@pytest.mark.parametrize("seed", [0, 1])
def test_pressures_whose_zero_follows_a_logged_temperature_drift(make_lab, seed: int) -> None:
    """A regulator whose zero goes with the room's temperature, which comes and goes, is drift, surely."""
    lab = make_lab(chambers=2, captures=60, seed=seed)
    room = 21 + np.cumsum(np.random.default_rng(seed).normal(0, 0.5, 60))
    off_kpa = 8.0 * np.exp(
        -0.06 * (room - 21)
    )  # as the current of a bridge falls with its thermistor's resistance
    off_kpa -= off_kpa.mean()
    off_kpa *= 0.7 / off_kpa.std()
    values = lab.predict(lab.u + off_kpa[:, None, None]) + lab.noise()
    found = verdict_of(lab.dataset(values, {"room_temperature": ("degC", room)}), lab.model())
    assert (found.verdict, found.effects, found.rivals) == ("identified", ("drift",), ())
