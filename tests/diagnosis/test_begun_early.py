"""Cameras that stamp too early: said in words, where it is so and nowhere else."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis._begun_early import begun_early
from labrig.effects import rows_of

HELD_S = tuple(np.arange(1, 41) * 0.1)
LATE_S = 0.15
"""How slowly the body follows: most of the way in so many seconds."""


def lines(make_lab: Any, ahead_s: float, programme: str = "random", seed: int = 0) -> list[str]:
    """What is said of a body that follows in tenths of a second, by cameras that stamp so many seconds too early."""
    lab = make_lab(captures=24, rows_s=HELD_S, seed=seed, repeats=False)
    if programme == "stairs":
        lab.commanded = np.linspace(5, 55, 24)[:, None] * np.ones((24, lab.chambers))
    u = lab.commanded
    lab.event_s = 4.1 * np.arange(24)
    lab.time_s = lab.hold_s + lab.event_s[:, None]
    after = np.concatenate([u[1:], u[-1:]])
    left_s = 4.1 - lab.hold_s - ahead_s  # until the next command, as the cameras stamp it
    gone = np.where(left_s < 0, -np.expm1(left_s / LATE_S), 0.0)[:, :, None]
    creep = 0.05 * np.log1p(lab.hold_s)[:, :, None] * u[:, None]
    values = lab.predict(u[:, None] * (1 - gone) + after[:, None] * gone + creep)
    rows = rows_of(lab.dataset(values + lab.noise()))
    return begun_early(lab.model().context(rows), np.full(values.shape[2], 0.05))


@pytest.mark.parametrize("ahead_s", [0.4, 0.8])
@pytest.mark.parametrize("seed", range(2))
def test_stamps_that_are_too_early_are_told(make_lab: Any, ahead_s: float, seed: int) -> None:
    """One line says so and since when, to two tenths of a second (the body needs one or two)."""
    (line,) = lines(make_lab, ahead_s, seed=seed)
    assert "measurements are stamped too early" in line
    said_s = float(line.split("from about ")[1].split(" s before")[0])
    assert said_s == pytest.approx(ahead_s, abs=0.2)


@pytest.mark.parametrize("programme", ["random", "stairs"])
@pytest.mark.parametrize("seed", range(3))
def test_creep_is_no_clock(make_lab: Any, programme: str, seed: int) -> None:
    """What goes on through the whole hold is not taken for one, in any order of the set-points."""
    assert not lines(make_lab, 0.0, programme, seed)
