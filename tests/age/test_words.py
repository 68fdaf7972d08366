"""Changes as sentences."""

from typing import Any

import pytest

from labrig.age._words import change_words


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            {"group": "leak", "name": "c3", "unit": "%/min", "before": [-0.00152], "after": [3.7712]},
            "the leak of c3 went from 0.00 to 3.77 %/min since 2026-02-01 UTC",
        ),
        (
            {"group": "effect", "name": "creep", "unit": "× model", "before": [0.674], "after": [1.132]}
            | {"shape": "slope"},
            "creep grows 1.7-fold, from 0.674 to 1.132 × model since 2026-02-01 UTC",
        ),
        (
            {
                "group": "marker",
                "name": "m07",
                "unit": "mm",
                "before": [0.0, 0.0, 0.0],
                "after": [1.2, -1.6, 0.0],
            },
            "m07 moved by 2 mm since 2026-02-01 UTC",
        ),
        (
            {
                "group": "frame",
                "name": "turn",
                "unit": "mrad",
                "before": [0.0, 0.0, 0.0],
                "after": [0.0, 3.0, 4.0],
            },
            "the cameras turned by 5 mrad since 2026-02-01 UTC",
        ),
        (
            {
                "group": "zero",
                "name": "c1",
                "unit": "kPa",
                "before": [0.5],
                "after": [0.25],
                "shape": "slope",
            },
            "the zero of c1 falls from 0.500 to 0.250 kPa since 2026-02-01 UTC",
        ),
    ],
)
def test_a_change_in_a_sentence(changed: dict[str, Any], said: str) -> None:
    """What, from what to what, and since when (which clock is said); places by how far they are apart."""
    assert change_words({"shape": "step", "date": "2026-02-01 08:00"} | changed, 34) == said


@pytest.mark.parametrize(
    ("markers", "said"),
    [
        (4, "m1 or the cameras moved by 3 mm since 2026-02-01 UTC"),
        (5, "m1 moved by 3 mm since 2026-02-01 UTC (5 markers can't tell two that slipped from the cameras)"),
        (6, "m1 moved by 3 mm since 2026-02-01 UTC (6 markers can't tell two that slipped from the cameras)"),
        (7, "m1 moved by 3 mm since 2026-02-01 UTC"),
    ],
)
def test_few_markers_say_what_they_cannot_tell(markers: int, said: str) -> None:
    """Four markers can't tell a slip from the cameras, and five or six not two slips: the sentence has it."""
    place: Any = {"group": "marker", "name": "m1", "unit": "mm", "shape": "step", "date": "2026-02-01 08:00"}
    assert change_words(place | {"before": [0.0, 0.0, 0.0], "after": [0.0, 3.0, 0.0]}, markers) == said
