"""What has no name: what goes by the history of the set-points."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.diagnosis import rows_from
from labrig.diagnosis._unnamed import unnamed
from labrig.effects import Context


def history_of(context: Context) -> dict[str, np.ndarray]:
    """The functions of the spaces that go by what was before."""
    spaces = [space for space in unnamed(context) if space.spectrum in ("through", "history")]
    return {f"{space.key}: {f.name}": f.values for space in spaces for f in space.features}


@pytest.mark.parametrize("begins_kpa", [20.0, 300.0])
def test_what_was_before_is_counted_from_where_the_range_begins(make_lab, begins_kpa: float) -> None:
    """A rig whose lowest pressure is not zero has the history of one that is counted from there."""
    lab = make_lab(captures=30, long_s=(3.0, 10.0))
    rows = rows_from(lab.dataset(lab.predict(lab.u)))
    context = lab.model().predictor(rows).context(rows)
    higher = {
        name: getattr(rows, name) + begins_kpa for name in ("actuation", "event_actuation", "low", "high")
    }
    other = replace(context, rows=replace(rows, **higher), _memo={})
    found, wanted = history_of(other), history_of(context)
    assert list(found) == list(wanted)
    for name, values in wanted.items():
        np.testing.assert_allclose(found[name], values, atol=1e-9, err_msg=name)
