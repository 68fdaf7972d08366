"""What swings in a record whatever the inputs do is no noise: it is told with its frequency."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared
from labrig.diagnosis._observations import observe
from labrig.diagnosis._tone import tones
from labrig.effects import Space, rows_of
from tests.diagnosis.test_records import DT_S, ROWS, model_of, record, slipped, swept

T = np.arange(ROWS) * DT_S


def pump(hz: float, seed: int) -> np.ndarray:
    """What a diaphragm pump leaves in the air: a saw tooth whose strength hunts by a fifth, (ROWS,)."""
    random = np.random.default_rng(seed)
    hunting = 1 + 0.2 * np.interp(T, np.linspace(0, T[-1], 12), random.normal(size=12))
    return hunting * (2 * ((hz * T + random.uniform()) % 1) - 1)


@pytest.mark.parametrize("hz", [0.37, 1.31])
def test_a_pump_is_told_by_its_frequency(tmp_path: Any, hz: float) -> None:
    """A straight line is right but for a pump's swing: unknown, carried by a swing of that frequency, which
    is no noise."""
    y = 0.3 * 40 * swept(3) + 0.4 * pump(hz, 4) + 0.15 * np.random.default_rng(5).normal(size=ROWS)
    found = diagnose(record(40 * swept(3), y, "kPa", "mm"), model_of(tmp_path)).summary
    assert found["verdict"] == "unknown"
    assert found["carried_by"] == f"a swing of {hz} Hz that no input has"
    assert found["error"]["floor"] < 0.85 * found["error"]["base"]


def tones_of(tmp_path: Any, u: np.ndarray, y: np.ndarray) -> list[Space]:
    """The spaces of tones that are laid out for a record."""
    ready = prepared(rows_of(record(u, y, "kPa", "mm")), model_of(tmp_path))
    return list(tones(observe(ready.context, ready.residual, ready.floor, ready.declared)))


def test_only_lines_that_no_input_has_are_laid_out(tmp_path: Any) -> None:
    """A pump under random strokes is, as one of as many frequencies as were looked at; a tendon that sticks under one
    slow sine has lines at that sine's harmonics, and none is; nor is one of noise, white or shared by neighbours.
    """
    white = np.random.default_rng(6).normal(size=ROWS + 20)
    shared = np.convolve(white, np.exp(-np.arange(20) / 4.0), mode="valid")[:ROWS]
    noise = 0.02 * np.random.default_rng(7).normal(size=ROWS)
    pull = 5 + 4 * np.sin(2 * np.pi * T / 14.0)
    (space,) = tones_of(tmp_path, 40 * swept(3), 12 * swept(3) + 0.1 * pump(1.31, 4) + noise)
    assert space.key == "a swing of 1.31 Hz that no input has"
    assert space.scanned == ROWS // 2
    assert tones_of(tmp_path, pull, slipped(pull) + noise) == []
    for alone in (noise, 0.1 * shared):
        assert tones_of(tmp_path, 40 * swept(3), 12 * swept(3) + alone) == []


def test_an_effect_beside_a_tone_is_named(tmp_path: Any) -> None:
    """A dead time beside a pump: the delay is sure, and once it is in the model, what is left is the pump's swing."""
    u = 40 * swept(7)
    late = np.concatenate([np.zeros(9), u])[:ROWS]
    y = 0.3 * late + 0.3 * pump(1.31, 8) + 0.05 * np.random.default_rng(8).normal(size=ROWS)
    found = diagnose(record(u, y, "kPa", "mm"), model_of(tmp_path))
    assert found.summary["effects"] == ["delay"]
    assert found.improved is not None
    then = diagnose(record(u, y, "kPa", "mm"), found.improved).summary
    assert then["verdict"] == "unknown"
    assert then["carried_by"] == "a swing of 1.31 Hz that no input has"
