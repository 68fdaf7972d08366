"""Words of a diagnosis: numbers with their units, one or several, one pressure or several together."""

from collections import Counter
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from labrig.diagnosis._amount import amount
from labrig.diagnosis._problem import Prepared
from labrig.diagnosis._unnamed import unnamed
from labrig.effects import rows_of


@pytest.mark.parametrize(("unit", "said"), [("mm", "0.12 mm"), ("1", "0.12")])
def test_a_unit_of_one_is_none(unit: str, said: str) -> None:
    """A quaternion's part is a number."""
    assert amount(0.1234, unit) == said


@pytest.mark.parametrize(
    ("dropped", "said"), [(1, "1 outlying value was left out"), (2, "2 outlying values were left out")]
)
def test_one_value_or_several(dropped: int, said: str) -> None:
    """What was left out, and where."""
    values = np.zeros((3, 1))
    residual = values.copy()
    residual[:dropped] = np.nan
    rows = SimpleNamespace(values=values, observables=("force",), marker=np.array([-1]), markers=())
    own = SimpleNamespace(dropped=dropped, context=SimpleNamespace(rows=rows), residual=residual)
    (line,) = cast(Any, Prepared.left_out).fget(own)
    assert line == f"{said} ({dropped} of force)"


@pytest.mark.parametrize(
    ("chambers", "said"), [(1, "another curve of the pressure"), (2, "pressures together")]
)
def test_one_pressure_is_not_several_together(make_lab, chambers: int, said: str) -> None:
    """A space of what pressures do in other patterns is called by how many there are."""
    lab = make_lab(chambers=chambers, captures=30)
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    keys = Counter(space.key for space in unnamed(context))
    assert [key for key in ("another curve of the pressure", "pressures together") if keys[key]] == [said]
