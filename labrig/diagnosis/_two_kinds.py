"""Two static effects of different kinds behind one that took a part of each.

A form with a coefficient for every chamber can follow the sum of two effects so closely that the second one's gain
looks like a misfit of form. But the misfit of one kind is not of another kind: what an effect of each chamber's own
pressure gets wrong does not look like a product of two pressures. So two effects that show in different things take
the place of one, however little they gain, where that is clear and each is large in itself.
"""

from collections.abc import Mapping
from itertools import combinations, product

import numpy as np

from labrig.diagnosis._candidates import Candidate, Fit, fit, square_of, stays_plausible
from labrig.diagnosis._gate import Ground, cosine, fits_form

CLEARLY_SE = 2.0
WORSE_BLOCKS = 0.17
OWN_OF_FLOOR = 0.55
OPPOSED_COSINE = -0.6
BEYOND_LEARNER = 1.3
"""How much more than a smooth map of the pressures the two must explain of what one leaves."""
FORMS = 3


def two_kinds(
    ground: Ground,
    chosen: Fit,
    found: Mapping[str, list[Candidate]],
    fixed: int,
    beyond_learner: float = BEYOND_LEARNER,
) -> Fit:
    """The best two effects of different kinds in the place of the one after the `fixed` parts, if any earn it."""
    kept = chosen.parts[:fixed]
    taken = {part.effect.name for part in kept}
    static = [
        forms[:FORMS]
        for name, forms in found.items()
        if name not in taken and forms[0].effect.beyond_static == "no" and not forms[0].effect.scans
    ]
    best = chosen
    for one, other in combinations(static, 2):
        if one[0].effect.shows_in == other[0].effect.shows_in:
            continue
        for pair in product(one, other):
            option = fit([*kept, *pair])
            if option.score.gain > best.score.gain and _earn(ground, chosen, option, fixed):
                best = option
    return best if best is chosen or fits_form(ground.streams, chosen, best, beyond_learner) else chosen


def _earn(ground: Ground, chosen: Fit, option: Fit, fixed: int) -> bool:
    """Whether the two are clearly ahead in nearly every block, large each and not merely each other's opposite."""
    ahead = option.score.gains - chosen.score.gains
    n = len(ahead)
    if n < 3 or ahead.sum() <= CLEARLY_SE * np.sqrt(n) * ahead.std(ddof=1):
        return False
    if (ahead <= 0).sum() > WORSE_BLOCKS * n or not stays_plausible(option, fixed):
        return False
    streams = ground.streams
    one, other = (option.parts[i].columns.field(option.own(i)) for i in (fixed, fixed + 1))
    least = OWN_OF_FLOOR**2 * ground.gate.floor_square
    if min(square_of(streams, one), square_of(streams, other)) < least:
        return False
    return cosine(streams, one, other) > OPPOSED_COSINE
