"""What is named by one or two captures: said, for a mistake in these would look the same."""

import numpy as np

from labrig._text import listed
from labrig.diagnosis._candidates import Fit, change_of
from labrig.diagnosis._problem import Prepared
from labrig.diagnosis._verdict import Verdict

_FEW, _MOST, _FEWEST = 2, 0.9, 10
"""So few captures hold so much of what the named effects explain, of so many at least."""


def rests_on(ready: Prepared, chosen: Fit | None, verdict: Verdict) -> list[str]:
    """A line where nearly all that the formulas of the named effects explain is the mean of one capture or two.

    What goes on within holds, as a leak does, is borne out by many rows, and none is said of it.
    """
    regression = ready.regression
    captures = np.unique(ready.context.rows.capture)
    if chosen is None or verdict.verdict == "nothing_missing" or len(captures) < _FEWEST:
        return []
    after = regression.residual - regression.lift(change_of(ready.context, chosen))
    fallen = regression.square(regression.residual) - regression.square(after)
    of_means = fallen[: len(captures)] if regression.use_means else fallen[:0]
    first = np.argsort(-of_means)[:_FEW]
    enough = _MOST * float(fallen.sum())
    first = first[:1] if of_means[first[:1]].sum() >= enough else first
    if enough <= 0 or of_means[first].sum() < enough:
        return []
    where = listed([str(c) for c in sorted(captures[first].tolist())])
    return [
        f"nearly all that is explained by {listed(chosen.names)} lies in {'captures' if len(first) > 1 else 'capture'} "
        f"{where} of {len(captures)}: a mistake in so few looks the same, so measure set-points like "
        f"{'these' if len(first) > 1 else 'this'} again"
    ]
