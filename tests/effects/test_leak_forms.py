"""The formula of a leak: which chamber, and by what law of the pressure."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.diagnosis import improve
from labrig.effects import TRANSIENT_S, rows_of

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


def test_a_hold_that_goes_on_at_one_set_point_has_one_beginning(make_lab) -> None:
    """What has leaked from a chamber that is commanded the same once more is not filled again, and is gone since it was
    filled: a leak as it was measured says so, and an error of the regulator is as it was at first.
    """
    lab = make_lab(chambers=2, captures=20, rows_s=(1.0, 3.0, 6.0), repeats=False, sessions=4)
    lab.commanded[11] = lab.commanded[10]
    lab.commanded[5] = lab.commanded[4]  # of another session, which begins anew
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    lost = 0.1 * np.nan_to_num(lab.hold_s)
    lost[[5, 11]] += 0.6
    measured = lab.u - lost[:, :, None] + 0.5
    rows = replace(rows_of(data), measured=measured.reshape(-1, 2))
    context = lab.model().context(rows)
    fall, error = (v.reshape(20, 3, 2) for v in (context.measured_fall, context.measured_error))
    assert fall[11] == pytest.approx(np.array([[-0.6], [-0.8], [-1.1]]).repeat(2, axis=1))
    assert fall[12] == pytest.approx(np.array([[0.0], [-0.2], [-0.5]]).repeat(2, axis=1))
    assert error[11] == pytest.approx(error[10])
    assert fall[5] == pytest.approx(fall[12])
