"""Set-points that are measured again at the end of a run: what drifted meanwhile is no noise."""

import numpy as np
import pytest

from tests.naming import verdict_of


def again(make_lab, captures: int, repeated: int, seed: int = 3):
    """A force of two chambers, and the first set-points once more at the end."""
    lab = make_lab(
        force=True, chambers=2, captures=captures, rows_s=(1.0, 4.0, 11.0), repeats=False, seed=seed
    )
    lab.commanded[-repeated:] = lab.commanded[:repeated]
    return lab


@pytest.mark.parametrize(("captures", "repeated"), [(22, 2), (20, 6), (30, 8)])
@pytest.mark.parametrize("kind", ["zero", "gain"])
def test_a_drift_is_found_though_repeats_differ_by_it(
    make_lab, captures: int, repeated: int, kind: str
) -> None:
    """A zero that goes on with the root of time, or a gain that fades, by some five noises: that something is missing is
    seen, and with more than two repeats that it may be a drift.
    """
    lab = again(make_lab, captures, repeated)
    late = np.sqrt(lab.time_s / lab.time_s.max())[:, :, None]
    clean = lab.predict(lab.u)
    drift = 1.5 * late if kind == "zero" else -0.06 * late**2 * clean
    found = verdict_of(lab.dataset(clean + drift + lab.noise(capture=0.05)), lab.model())
    calls = {c.effect: c.call for c in found.considered}
    assert found.verdict != "nothing_missing"
    assert repeated == 2 or calls["drift"] in {"sure", "possible"}


@pytest.mark.parametrize(("captures", "repeated"), [(22, 2), (30, 8)])
def test_nothing_is_missing_where_repeats_differ_by_noise(make_lab, captures: int, repeated: int) -> None:
    """The same without a drift."""
    lab = again(make_lab, captures, repeated)
    values = lab.predict(lab.u) + lab.noise(capture=0.05)
    assert verdict_of(lab.dataset(values), lab.model()).verdict == "nothing_missing"
