"""One marker that slipped, on rigs with few markers and with many."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from labrig.age import _places
from labrig.age._places import _rigid, place_readings

NOISE_MM = 0.05


def drawn(seed: int, markers: int, slipped: int) -> tuple[np.ndarray, np.ndarray]:
    """Places on a flat rig, mm, and offsets of noise, of which the first few markers slipped by 3 mm anywhere."""
    random = np.random.default_rng(seed)
    place = random.uniform(-60, 60, (markers, 3)) * [1.0, 1.0, 0.2]
    off, way = NOISE_MM * random.normal(size=(markers, 3)), random.normal(size=(slipped, 3))
    off[:slipped] += 3.0 * way / np.linalg.norm(way, axis=1, keepdims=True)
    return place, off


@pytest.mark.parametrize(("markers", "slipped"), [(5, 1), (6, 1), (7, 2), (9, 3), (12, 4), (34, 12)])
@pytest.mark.parametrize("seed", range(5))
def test_markers_that_slipped_carry_nothing_along(markers: int, slipped: int, seed: int) -> None:
    """They have moved by what they slipped, and neither the others nor the cameras have."""
    place, off = drawn(seed, markers, slipped)
    motion, _, left = _rigid(place, off, np.full(markers, NOISE_MM), np.ones(markers, dtype=bool))
    moved = np.linalg.norm(left, axis=1)
    assert moved[:slipped] == pytest.approx(3.0, abs=0.5)
    assert moved[slipped:].max() < 0.5
    assert np.linalg.norm(motion[:3]) < 0.3


@pytest.mark.parametrize(("markers", "groups"), [(4, {"marker"}), (5, {"marker", "frame"})])
def test_too_few_markers_are_shown_as_they_are(
    markers: int, groups: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a slip can't be told from the cameras, nothing of the cameras is said, and each marker has its offset."""
    place, off = drawn(0, markers, 1)
    monkeypatch.setattr(_places, "_offsets", lambda _: (off, np.full(markers, NOISE_MM)))
    rows = SimpleNamespace(
        rest_mm=place, unit=("mm",), marker=np.arange(markers), markers=[f"m{i}" for i in range(markers)]
    )
    beside: Any = SimpleNamespace(context=SimpleNamespace(rows=rows))
    read = [each for each in place_readings(beside) if each]
    assert {each.group for each in read} == groups
    (first,) = [each for each in read if each.key == ("marker", "m0")]
    assert np.linalg.norm(first.value) == pytest.approx(3.0, abs=0.5)
