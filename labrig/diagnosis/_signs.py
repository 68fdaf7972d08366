"""What can act one way only: a stop holds back, and never drives on.

A Gaussian knows no sign. But where a law is given only one of two, its evidence is what it is without, times how
probable that sign is after the data over how probable it is before, which is a half: p(y | s > 0) = p(y) p(s > 0 | y) /
p(s > 0), by Bayes. A part with the wrong sign loses by that what it has gained by its fit.
"""

import numpy as np
from scipy.special import log_ndtr

from labrig.arrays import Floats


def log_gain(mean: Floats, sd: Floats) -> Floats:
    """By how many nats a part gains where it may act one way only: it acts by `mean` with `sd` that way."""
    return np.log(2.0) + log_ndtr(mean / np.maximum(sd, 1e-300))
