"""What is said of the error that is left beside the names."""

import pytest

from labrig.diagnosis._falls import Fall, much_left


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


def test_what_a_fall_lacks_is_said() -> None:
    """How much is needed, where it is too small; how uncertain it is, where that is the matter."""
    little = Fall("creep", fall=0.01**2, se=0.001**2, least=0.03**2, units="mm")
    unsure = Fall("creep", fall=0.09**2, se=0.1**2, least=0.03**2, units="mm")
    assert (little.helps, little.words) == (False, "by 0.01 mm, needed 0.03 mm")
    assert (unsure.helps, unsure.words) == (False, "by 0.09 mm, with a standard error of 0.1 mm")
