"""The passport of an effect: fitted on one rig or day it is a prior on another, unless the runs there contradict it."""

from labrig.passport._carry import MOST_Z, SPREAD, carry
from labrig.passport._combine import Carried, combined
from labrig.passport._pool import Pool, pooled

__all__ = [
    "MOST_Z",
    "SPREAD",
    "Carried",
    "Pool",
    "carry",
    "combined",
    "pooled",
]
