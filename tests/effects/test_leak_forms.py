"""The formula of a leak: which chamber, and by what law of the pressure."""

import numpy as np
import pytest

from labrig.diagnosis import improve
from labrig.effects import TRANSIENT_S

HOLD_S = (1.5, 4.0, 8.0, 15.0)


@pytest.mark.parametrize("chamber", [0, 2])
def test_a_hole_in_one_chamber_is_one_chambers(make_lab, chamber: int) -> None:
    """Through an orifice the root of the pressure falls evenly: one chamber is named, by the root, and how fast it
    loses its pressure at first is right within a tenth.
    """
    lab = make_lab(captures=60, rows_s=HOLD_S)
    assert HOLD_S[0] > TRANSIENT_S
    u, rate = lab.u, 0.02  # of the root of the pressure, root kPa a second
    u[..., chamber] = np.maximum(np.sqrt(u[..., chamber]) - rate * lab.hold_s, 0.0) ** 2
    result = improve(lab.dataset(lab.predict(u) + 0.3 * lab.noise()), lab.model(), ["leak"])
    (entry,) = result.improved.file.effects
    assert entry.form == "one chamber, by the root"
    assert entry.parameters["chamber"].per == [f"c{chamber + 1}"]
    loss, tau_s = (float(np.ravel(entry.parameters[n].value)[0]) for n in ("loss", "tau_s"))
    assert loss / tau_s == pytest.approx(2 * rate / np.sqrt(60.0), rel=0.1)


def test_chambers_that_leak_alike_leak_alike(make_lab) -> None:
    """Through long fine cracks, laminar and compressible (dp/dt = -k p (p + 2 p0)), all lose nearly in proportion to
    what they hold: the plainest formula says so.
    """
    lab = make_lab(captures=60, rows_s=HOLD_S)
    twice_kpa = 2 * 101.3
    left = lab.u / (lab.u + twice_kpa) * np.exp(-lab.hold_s[:, :, None] / 400.0)
    u = twice_kpa * left / (1 - left)
    result = improve(lab.dataset(lab.predict(u) + 0.3 * lab.noise()), lab.model(), ["leak"])
    (entry,) = result.improved.file.effects
    assert entry.form == "exponential"
