"""Creep that is over within seconds, and a lag that is slow: one function, whose size says which it is."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.diagnosis import diagnose
from labrig.model import Model

STEP_S = 0.02
ROWS_S = (0.5, 1.5, 3.0, 5.0, 7.5, 10.0)


def behind(drive: np.ndarray, tau_s: float) -> np.ndarray:
    """A first-order lag, step by step (implicit Euler)."""
    out, last = np.empty_like(drive), 0.0
    for i, now in enumerate(drive):
        last += STEP_S / (tau_s + STEP_S) * (now - last)
        out[i] = last
    return out


def named(
    make_lab: Any, folder: Path, answer: Callable[[np.ndarray], np.ndarray]
) -> tuple[set[str], set[str]]:
    """What is sure, and what is sure or possible, of one chamber that is held for ten seconds each, before a line that
    was fitted; it answers a history of pressures by another.
    """
    lab = make_lab(chambers=1, force=True, bent=0.0, captures=40, rows_s=ROWS_S, repeats=False)
    clock = np.arange(0.0, lab.time_s.max() + 1.0, STEP_S)
    event = np.searchsorted(lab.event_s, clock, side="right") - 1
    seen = answer(lab.commanded[event, 0])[np.searchsorted(clock, lab.time_s)]
    (folder / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    found = diagnose(
        lab.dataset(lab.predict(seen[:, :, None]) + lab.noise()), Model.load(folder / "model.yaml")
    ).summary
    return set(found["effects"]), {*found["effects"], *found["rivals"]}


@pytest.mark.parametrize("tau_s", [1.5, 3.5])
def test_creep_within_seconds_is_no_delay(make_lab: Any, tmp_path: Path, tau_s: float) -> None:
    """What yields by an eighth more within seconds (two elements side by side) is never a delay, surely: such a lag
    has no share in the change that a delay has.
    """
    sure, possible = named(
        make_lab, tmp_path, lambda p: p + 0.07 * behind(p, 0.8 * tau_s) + 0.05 * behind(p, 1.4 * tau_s)
    )
    assert "delay" not in sure
    assert "creep" in possible


def test_a_chamber_that_fills_slowly_does_not_creep(make_lab: Any, tmp_path: Path) -> None:
    """All of the change comes late, within seconds, through two volumes in a row: no rubber yields by so much."""
    sure, possible = named(make_lab, tmp_path, lambda p: behind(behind(p, 3.2), 0.6))
    assert "creep" not in sure
    assert "delay" in possible


def test_what_relaxes_within_seconds_may_be_creep(tmp_path: Path) -> None:
    """A stretched rubber whose force falls in each hold (two Maxwell elements beside a spring) is no lag of what is
    ahead: that is taken back, and creep, whose formula fits as well, is possible in its place.
    """
    random = np.random.default_rng(4)
    stage_mm = np.repeat(random.permutation(np.repeat(np.arange(0.0, 11.0, 2.0), 5)), round(10.0 / STEP_S))
    yields = 0.12 * (stage_mm - behind(stage_mm, 2.0)) + 0.06 * (stage_mm - behind(stage_mm, 3.5))
    every = slice(None, None, 25)
    frame = pd.DataFrame(
        {
            "t [s]": (STEP_S * np.arange(len(stage_mm)))[every],
            "stage [mm]": stage_mm[every],
            "force [N]": (stage_mm + yields)[every] + random.normal(0, 0.1, len(stage_mm[every])),
        }
    )
    run = labrig.import_table(frame, tmp_path / "run")
    (tmp_path / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    found = labrig.diagnose(run, tmp_path / "model.yaml")
    assert "creep" in {*found.sure, *found.possible}
    assert "delay" not in {*found.sure, *found.possible}
