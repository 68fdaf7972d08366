"""Noise within holds where some rows are much larger than most: means of captures have them, too."""

import numpy as np
import pytest

from labrig.diagnosis._within import _with_tails
from tests.naming import verdict_of

RANDOM = np.random.default_rng(3)
MANY = 40_000


@pytest.mark.parametrize(
    ("rows", "least", "most"),
    [
        (RANDOM.normal(size=MANY), 0.98, 1.02),
        (RANDOM.standard_t(3, MANY) / np.sqrt(3), 0.74, 0.95),
        (RANDOM.standard_t(5, MANY) / np.sqrt(5 / 3), 0.9, 1.0),
        (np.where(RANDOM.random(MANY) < 0.01, 1e3, RANDOM.normal(size=MANY)), 1.0, 1.08),
    ],
    ids=["normal", "t of three", "t of five", "one of a hundred is lost"],
)
def test_large_rows_count_and_wild_ones_do_not_decide(rows: np.ndarray, least: float, most: float) -> None:
    """Of true size one each: normal rows exactly, heavy tails for more than their median says, mistakes hardly."""
    assert least < _with_tails(rows) < most


def test_heavy_tails_are_no_missing_effect(make_lab) -> None:
    """A force whose four rows a hold have the noise of a Student's t of three: nothing is missing."""
    lab = make_lab(force=True, chambers=2, captures=60, rows_s=(1.0, 3.0, 5.0, 8.0), repeats=False)
    clean = lab.predict(lab.u)
    rows = np.random.default_rng(0).standard_t(3, clean.shape) / np.sqrt(3)
    assert verdict_of(lab.dataset(clean + 0.3 * rows), lab.model()).verdict == "nothing_missing"
