"""How scatter may hang together from run to run: what follows the room is today much as it was yesterday.

So many runs say less than as many independent ones (G. V. Bayley, J. M. Hammersley, Supplement to the Journal of the
Royal Statistical Society 8, 1946, 184-197: at a lag-1 correlation r as (1 - r) / (1 + r) of them). The test takes the
likeliest way to wander from the runs themselves. That is an estimate: that the chance of a false change is alpha at
most is proven for scatter that does not wander; for scatter that does it is measured (benchmarks/ageing.py --wander).
"""

from functools import lru_cache
from itertools import product

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from labrig.arrays import Floats

SHARES = (0.5, 0.95)
"""Of the variance: what wanders, half or nearly all; not all, since two runs in the same minute differ too."""
DAYS = (1.0, 3.0, 10.0)
"""After how many days it is forgotten, to 1/e: from a day to the spells of the weather. The seasons are a change."""
WANDERS = ((0.0, 1.0), *product(SHARES, DAYS))
"""Share and days of each way to wander; the first is none."""


def whitener(day: Floats, wander: int) -> Floats:
    """The lower triangular matrix (n, n) that makes scatter of unit size independent from run to run.

    Scatter is the sum of an Ornstein-Uhlenbeck process (G. E. Uhlenbeck, L. S. Ornstein, Physical Review 36, 1930,
    823-841), which for runs at equal distances is an autoregression of first order, and of what is new in every run.
    """
    return _whitener(day.tobytes(), wander)


@lru_cache(maxsize=2 * len(WANDERS))
def _whitener(day: bytes, wander: int) -> Floats:
    at = np.frombuffer(day)
    share, days = WANDERS[wander]
    alike = share * np.exp(-np.abs(at[:, None] - at[None, :]) / days)
    np.fill_diagonal(alike, 1.0)
    return np.asarray(solve_triangular(cholesky(alike, lower=True), np.eye(len(at)), lower=True))
