"""A base that is fitted to the run takes some of its noise: what is left to explain is counted without that."""

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._observations import observe
from tests.laws import orifice
from tests.naming import calls_of
from tests.polynomials import fitted


@pytest.mark.parametrize("degree", [1, 3])
def test_noise_beside_a_fit_is_noise(make_lab, degree: int) -> None:
    """Of noise alone, what is left in the mean is what the fit did not take: 4 or 20 of 60 in each coordinate."""
    lab = make_lab(bent=0.0, markers=40, repeats=False)
    data = lab.dataset(lab.predict(lab.u) + lab.noise(row=0.1, capture=1.0))
    ready = prepared(rows_from(data), fitted(lab, degree))
    observations = observe(ready.context, ready.residual, ready.floor, ready.declared)
    means = observations.values[: lab.captures] * observations.unit
    left = observations.left[: lab.captures]
    assert left.mean() == pytest.approx(1 - {1: 4, 3: 20}[degree] / 60, abs=1e-6)
    assert np.mean(means**2) == pytest.approx(left.mean() * (1 + 0.1**2 / 3), rel=0.1)
    assert observations.left[lab.captures :] == pytest.approx(1.0)
    assert observations.to_explain < 0.2


def test_a_leak_beside_a_cubic_base_is_named(make_lab) -> None:
    """A third of the noise goes into the fit, as much as there is of the leak within holds, and it is seen still."""
    lab = make_lab(chambers=2)
    data = lab.dataset(lab.predict(orifice(lab)) + lab.noise())
    assert calls_of(data, fitted(lab, 3))["leak"] == "sure"
