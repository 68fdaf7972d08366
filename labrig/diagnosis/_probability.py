"""How often a verdict like this one was right, in blind campaigns.

Scores say which name does best, not whether the right name is among those known: a wrong one can be as clear. What
tells is how much of what could be explained is left above the noise floor. The figures were read off 260 campaigns of
the blind benchmark (seeds from 200000 to 220000).
"""

import numpy as np

AT_THE_FLOOR = 2.4
PER_SHARE_LEFT = 3.6
UNKNOWN = 0.87
CONFOUNDED_BY_DESIGN = 0.95
CONFOUNDED = 0.15
NOTHING = 0.97
UNDERPOWERED = 0.9


def of_names(model_square: float, base_square: float, floor_square: float) -> float:
    """Probability that the names are right: a logistic function of the share of the error's amplitude that is left.

    Mean squares of what the model leaves, what its base leaves, and the floor.
    """
    explainable = max(base_square - floor_square, 1e-12 * floor_square)
    left = np.sqrt(min(max(model_square - floor_square, 0.0) / explainable, 1.0))
    return float(1.0 / (1.0 + np.exp(PER_SHARE_LEFT * left - AT_THE_FLOOR)))


def of_confounded(by_design: bool) -> float:
    """Probability that a tie is one: nearly sure where what was done cannot tell them apart whatever comes out."""
    return CONFOUNDED_BY_DESIGN if by_design else CONFOUNDED
