"""Markers out of sight, as cameras lose them."""

import numpy as np
import pytest

from labrig.diagnosis import diagnose
from labrig.model import Model
from tests.laws import orifice

LONG_S = (3.0, 4.0, 6.0, 10.0, 20.0, 40.0)


@pytest.mark.parametrize("base", ["known", "fitted"])
def test_a_leak_keeps_its_name_where_markers_are_out_of_sight(make_lab, base: str) -> None:
    """Each of six markers is unseen in some fifteen of a hundred captures: a leak far above the noise is named all the
    same, beside a known model and beside a polynomial that was fitted to what was seen.
    """
    lab = make_lab(captures=60, long_s=LONG_S)
    values = lab.predict(orifice(lab)) + lab.noise(0.02, 0.03)
    away = np.random.default_rng(1).random((60, 6)) < 0.15
    values[np.broadcast_to(np.repeat(away, 3, axis=1)[:, None], values.shape)] = np.nan
    model = lab.model()
    if base == "fitted":
        (lab.folder / "fitted.yaml").write_text("base: {kind: static, degree: 3}\n")
        model = Model.load(lab.folder / "fitted.yaml")
    found = diagnose(lab.dataset(values), model).summary
    assert (found["verdict"], found["effects"]) == ("identified", ["leak"])
