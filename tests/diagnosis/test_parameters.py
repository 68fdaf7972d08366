"""Values off the search's grid."""

from types import SimpleNamespace as Made
from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import _parameters


def test_which_chamber_is_no_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of a chamber is not moved off the grid: there is no chamber between two, and nothing is fitted."""
    monkeypatch.setattr(
        _parameters, "_with_shape", lambda *_: pytest.fail("a fit for a chamber that is none")
    )
    effect = Made(parameter=lambda name: Made(given=False, per="chamber", low=0.0, high=np.inf))
    part = Made(variant=Made(shape={"chamber": 2.0}), effect=effect)
    chosen: Any = Made(parts=(part,), score=Made(gain=1.0))
    assert _parameters.refined(None, None, chosen, 0) is chosen  # type: ignore[arg-type]


@pytest.mark.parametrize("best_s", [1.2, 3.0, 5.1, 8.8])
def test_a_value_is_moved_off_the_grid(monkeypatch: pytest.MonkeyPatch, best_s: float) -> None:
    """From 3 s a time constant goes to where the score is best, within three per cent, in eleven fits."""
    asked: list[float] = []

    def fitted(value_s: float) -> Any:
        effect = Made(parameter=lambda name: Made(given=False, per="one", low=0.0, high=1000.0))
        part = Made(variant=Made(shape={"tau_s": value_s}), effect=effect)
        return Made(parts=(part,), score=Made(gain=-(float(np.log(value_s / best_s)) ** 2)))

    def moved(_regression: Any, _context: Any, _chosen: Any, _i: int, _name: str, value_s: float) -> Any:
        asked.append(value_s)
        return fitted(value_s)

    monkeypatch.setattr(_parameters, "_with_shape", moved)
    found: Any = _parameters.refined(None, None, fitted(3.0), 0)  # type: ignore[arg-type]
    assert found.parts[0].variant.shape["tau_s"] == pytest.approx(best_s, rel=0.03)
    assert len(asked) == 11
