"""A rig that changes at one moment, for good or for a while: no effect of the library, and said to come suddenly."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._sudden import changed
from tests.naming import verdict_of

BROKEN, LAID, TAKEN = 21, 17, 34


def seam_opens(lab: Any) -> np.ndarray:
    """From one capture on the wall of the first chamber strains by a power of its pressure, further than before."""
    values = lab.predict(lab.u)
    x = lab.u[BROKEN:, :, :1] / lab.u.max()
    values[BROKEN:] += 0.25 * x**1.3 * lab.reach[:, 0]
    return values


def lies_on_it(lab: Any) -> np.ndarray:
    """A weight lies on the body for a while: what is below its middle sinks, and less where it is blown up hard."""
    values = lab.predict(lab.u)
    points = values.reshape(*values.shape[:-1], -1, 3)
    far = np.linalg.norm(lab.rest_mm - lab.rest_mm.mean(axis=0), axis=1)
    sag = 4.0 * np.exp(-((far / 20.0) ** 2)) / (1 + lab.u.mean(axis=2, keepdims=True) / lab.u.max())
    points[LAID:TAKEN, :, :, 2] -= sag[LAID:TAKEN]
    return points.reshape(values.shape)


@pytest.mark.parametrize(
    ("happens", "when"),
    [
        (seam_opens, f"a sudden change before capture {BROKEN}"),
        (lies_on_it, f"a sudden change from capture {LAID} to {TAKEN - 1}"),
    ],
)
def test_what_happens_at_one_moment_has_no_name_but_a_time(make_lab, happens, when) -> None:
    """A seam that opens, and a thing that lies there for a while, are unknown; the captures are said to the number."""
    lab = make_lab(chambers=2, markers=8, captures=60)
    found = verdict_of(lab.dataset(happens(lab) + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("unknown", ())
    assert found.carried_by == when


def test_a_slow_warm_up_is_no_sudden_change(make_lab) -> None:
    """What grows with the clock is drift before all other names, and nothing that happened at one moment carries it."""
    lab = make_lab(markers=12, captures=60)
    t = lab.time_s / np.nanmax(lab.time_s)
    warm = lab.u * (1 + 0.12 * np.sqrt(t)[:, :, None])
    found = verdict_of(lab.dataset(lab.predict(warm) + lab.noise()), lab.model())
    first = found.considered[0]
    assert first.effect == "drift"
    assert first.call != "not it"
    assert all(c.call != "sure" for c in found.considered[1:])
    assert "sudden" not in (found.carried_by or "")


@pytest.mark.parametrize("captures", [40, 150, 700])
def test_the_moments_are_found_to_the_capture(make_lab, captures) -> None:
    """However many captures there are, begin and end of a stretch are found exactly."""
    lab = make_lab(markers=6, captures=captures, rows_s=(3.0,))
    first, end = captures // 3 + 1, captures // 2 + 5
    values = lab.predict(lab.u)
    values[first:end] += 0.2 * (lab.predict(lab.u) - lab.rest)[first:end]
    ready = prepared(rows_from(lab.dataset(values + lab.noise())), lab.model())
    found = changed(ready.context)
    assert found is not None
    assert (found.first, found.end) == (first, end)


def test_too_few_captures_have_no_sudden_change(make_lab) -> None:
    """With fewer captures than two stretches need nothing is looked for."""
    lab = make_lab(markers=6, captures=7, repeats=False)
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
    assert changed(ready.context) is None
