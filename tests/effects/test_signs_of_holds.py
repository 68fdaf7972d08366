"""What creep and a delay are drawn against on runs whose holds are all alike long."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import forms_of, prepared, rows_from
from labrig.diagnosis._present import signatures_of
from labrig.effects import library


def _slow(lab: Any) -> np.ndarray:
    """What a rig does whose every move goes on by a power of the time since it (Findley 1976), (n, T, K)."""
    moves = np.diff(lab.commanded, axis=0, prepend=0.0)
    since = np.clip(lab.time_s[:, :, None] - lab.event_s, 0.0, None)
    left = (1 + since / 2.0) ** -0.4
    return lab.predict(lab.u) - 0.12 * np.einsum("ntm,mc,kc->ntk", left, moves, lab.reach) / 60.0


@pytest.mark.parametrize("rows_s", [(3.0, 3.5, 4.0), (4.0,)])
@pytest.mark.parametrize("name", ["creep", "delay"])
def test_holds_that_are_alike_long_leave_no_picture_empty(
    make_lab: Callable[..., Any], name: str, rows_s: tuple[float, ...]
) -> None:
    """Each form, a family's weights too, is drawn along something that varies: times in the hold, where there are
    several, else pressures before; and the best form goes with it.
    """
    lab = make_lab(captures=40, rows_s=rows_s)
    ready = prepared(rows_from(lab.dataset(_slow(lab) + lab.noise())), lab.model())
    forms = forms_of(ready.regression, ready.context, library()[name])
    first = {candidate.variant.form: candidate for candidate in reversed(forms)}
    assert len(first) > 2
    for form, candidate in first.items():
        (sign,) = signatures_of(ready.context, ready.residual, ready.floor.row, {name: candidate.alone})
        assert np.ptp(sign.x) > 0.05 * np.abs(sign.x).max(), form
        if candidate is forms[0] and sign.x_name != "time in hold":
            each = [sign.group == chamber for chamber in np.unique(sign.group)]
            assert max(abs(np.corrcoef(sign.x[own], sign.fitted[own])[0, 1]) for own in each) > 0.6, form
