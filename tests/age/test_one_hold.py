"""What a morning's check shows in one hold only is a change too: each check has that hold."""

import numpy as np

from labrig.age._age import summary_of
from labrig.age._known import Known
from labrig.age._read import RunReadings, readings_of
from tests.conftest import Lab

DAY_S = 86_400.0


def checks(make_lab, leaks_from: int, days: int) -> list[RunReadings]:
    """Checks of a rig of four chambers, each the same set-points; from some morning on one chamber leaks, which its own
    sensor behind the leak does not see, and one long hold alone shows it: the air that is left falls in a line.
    """
    out = []
    for day in range(days):
        lab: Lab = make_lab(chambers=4, captures=16, seed=0, rows_s=(1.0, 2.0, 3.0), long_s=(1.0, 5.0, 10.0))
        u = lab.u
        if day >= leaks_from:
            u[15, :, 1] *= 1 - 0.03 * np.nan_to_num(lab.hold_s[15])
        lab.random = np.random.default_rng(day)
        values = lab.predict(u) + lab.noise(row=0.01, capture=0.02)
        known = Known(lab.model())
        readings = tuple(r for r in readings_of(lab.dataset(values), known) if r is not None)
        out.append(RunReadings(f"check{day}", day * DAY_S, "check", readings))
    return out


def test_a_leak_in_one_hold_is_noticed(make_lab) -> None:
    """Five quiet mornings and four with the leak: the model's error has changed, from the sixth morning on."""
    model = make_lab(chambers=4, captures=16).model()
    found = summary_of("rig", model, checks(make_lab, leaks_from=5, days=9))["changes"]
    (error,) = [each for each in found if each["group"] == "error"]
    assert error["begins"] == 5
    assert error["after"][0] > 1.5 * error["before"][0]


def test_quiet_mornings_stay_quiet(make_lab) -> None:
    """Nine mornings that differ by noise alone: nothing has changed."""
    model = make_lab(chambers=4, captures=16).model()
    assert summary_of("rig", model, checks(make_lab, leaks_from=99, days=9))["changes"] == []
