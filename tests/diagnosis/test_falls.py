"""What is said of the error that is left beside the names."""

import pytest

from labrig.diagnosis._falls import much_left


def test_what_is_left_beside_a_name_is_said() -> None:
    """A softening with the largest load so far, called a loop, leaves a third of the error: the line says so."""
    (line,) = much_left(["hysteresis"], base=4.3, model=1.4, floor=0.21, units="px")
    assert line == (
        "with hysteresis added, 1.4 of 4.3 px are left on captures that were left out, 6.7 times the noise: the law is "
        "another one of its kind, or more is missing than was named"
    )


@pytest.mark.parametrize(
    ("names", "model", "floor"), [((), 1.4, 0.2), (("leak",), 0.8, 0.2), (("leak",), 1.4, 0.8)]
)
def test_little_is_not_said(names: tuple[str, ...], model: float, floor: float) -> None:
    """Nothing where nothing was named, where a fifth is left, and where the noise is as large."""
    assert much_left(names, base=4.3, model=model, floor=floor, units="px") == []
