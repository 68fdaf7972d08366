"""Creep that never comes back, a flow, is creep too: under a load of one sign it goes on much as the clock does."""

import numpy as np
import pytest

from labrig.effects import rows_of
from tests.conftest import HIGH_KPA
from tests.laws import dashpot, power_law
from tests.naming import calls_of

LONG_S = (3.0, 10.0, 30.0, 60.0)


def test_a_flow_under_load_is_no_drift_for_sure(make_lab) -> None:
    """Beside a little that comes back: the load, which was not always the same, is what it goes by."""
    lab = make_lab(chambers=3, captures=80, long_s=LONG_S, seed=2)
    crept = 0.3 * (power_law(lab) - lab.u) + dashpot(lab)
    calls = calls_of(lab.dataset(lab.predict(crept) + lab.noise()), lab.model())
    assert calls["creep"] in {"sure", "possible"}
    assert calls["drift"] != "sure"


def test_a_zero_that_drifts_is_no_flow_for_sure(make_lab) -> None:
    """Nor the other way round: a gauge whose zero goes on with the logarithm of time, as one that settles does."""
    lab = make_lab(chambers=1, captures=80, long_s=LONG_S, seed=2)
    zero = 0.02 * HIGH_KPA * np.log1p(lab.time_s / 600.0)[:, :, None]
    calls = calls_of(lab.dataset(lab.predict(lab.u + zero) + lab.noise()), lab.model())
    assert calls["drift"] in {"sure", "possible"}
    assert calls["creep"] != "sure"


def test_the_integral_begins_anew_where_the_history_does(make_lab) -> None:
    """Set-points times how long they were held, and no more of the session before: what rest did to it is not known."""
    lab = make_lab(force=True, chambers=1, captures=10, sessions=2, rows_s=(2.0, 5.0))
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    expected = []
    for i, hold_s in enumerate(lab.hold_s):
        earlier = [j for j in range(i) if lab.session[j] == lab.session[i]]
        took = np.diff(lab.event_s[[*earlier, i]])
        expected += [float(took @ lab.commanded[earlier, 0] + s * lab.commanded[i, 0]) for s in hold_s]
    assert context.integrated()[:, 0] == pytest.approx(np.array(expected))
