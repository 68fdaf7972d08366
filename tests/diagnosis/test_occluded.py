"""Markers out of sight, as cameras lose them."""

import numpy as np

from tests.laws import orifice
from tests.naming import verdict_of
from tests.polynomials import fitted

LONG_S = (3.0, 4.0, 6.0, 10.0, 20.0, 40.0)


def test_a_leak_keeps_its_name_where_markers_are_out_of_sight(make_lab) -> None:
    """Each of six markers is unseen in some fifteen of a hundred captures: a leak far above the noise is named all the
    same beside a polynomial that was fitted to what was seen.
    """
    lab = make_lab(chambers=2, captures=60, long_s=LONG_S)
    values = lab.predict(orifice(lab)) + lab.noise(0.02, 0.03)
    away = np.random.default_rng(1).random((60, 6)) < 0.15
    values[np.broadcast_to(np.repeat(away, 3, axis=1)[:, None], values.shape)] = np.nan
    found = verdict_of(lab.dataset(values), fitted(lab, 3))
    assert (found.verdict, found.effects) == ("identified", ("leak",))
