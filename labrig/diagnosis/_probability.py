"""How often a verdict like this one was right, in blind campaigns.

Scores say which name does best, not whether the right name is among those known: a wrong one can be as clear. Names
that live in history or time had to show beside any static map, and are seldom wrong. With a static name among them what
tells a little is how much of what could be explained is left above the noise floor: a static name follows another one's
field nearly, seldom down to the floor. The figures were read off 473 campaigns of the blind benchmark (all classes,
seeds from 310000 to 330024), diagnosed while the rules were still being written; 661 fresh ones agree (RESULTS.md).
"""

import numpy as np

MOVING = 0.93
AT_THE_FLOOR = 2.3
PER_SHARE_LEFT = 4.0
LARGEST_SHARE_LEFT = 0.25
UNKNOWN = 0.9
CONFOUNDED_BY_DESIGN = 0.95
CONFOUNDED = 0.1
NOTHING = 0.97
UNDERPOWERED = 0.9


def of_names(model_square: float, base_square: float, floor_square: float, moving: bool) -> float:
    """Probability that the names are right: with a static one among them (not all `moving`) a logistic function of the
    share of the error's amplitude that is left.

    Mean squares of what the names and the base's own error of form leave, what the base leaves, and the floor.
    """
    if moving:
        return MOVING
    explainable = max(base_square - floor_square, 1e-12 * floor_square)
    left = np.sqrt(max(model_square - floor_square, 0.0) / explainable)
    return float(1.0 / (1.0 + np.exp(PER_SHARE_LEFT * min(left, LARGEST_SHARE_LEFT) - AT_THE_FLOOR)))


def of_confounded(by_design: bool) -> float:
    """Probability that a tie is one: nearly sure where what was done cannot tell them apart whatever comes out."""
    return CONFOUNDED_BY_DESIGN if by_design else CONFOUNDED
