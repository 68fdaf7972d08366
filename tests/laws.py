"""Laws that labrig does not have: pressures (n, T, C) of a laboratory's rows, as each law changes them."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from tests.conftest import HIGH_KPA

if TYPE_CHECKING:
    from tests.conftest import Lab

Law = Callable[["Lab"], np.ndarray]


def power_law(lab: "Lab") -> np.ndarray:
    """What has crept on after each step of a chamber's pressure: a share that grows with a root of the time.

    P. G. Nutting, Proc. ASTM 21 (1921) 1162.
    """
    out, steps = lab.u, np.diff(lab.commanded, axis=0, prepend=0.0)
    for i in range(len(out)):
        since = (lab.event_s[i] + lab.hold_s[i])[:, None] - lab.event_s[: i + 1]
        out[i] += 0.15 * (np.maximum(since, 1e-3) / 100) ** 0.2 @ steps[: i + 1]
    return out


def dashpot(lab: "Lab") -> np.ndarray:
    """What flows under load and never comes back, the faster the higher the load is.

    F. H. Norton, The Creep of Steel at High Temperatures, 1929.
    """
    speed = 0.02 * HIGH_KPA * (lab.commanded / HIGH_KPA) ** 1.5 / 60.0
    took = np.diff(lab.event_s, append=lab.event_s[-1])[:, None]
    before = np.cumsum(speed * took, axis=0) - speed * took
    return lab.u + before[:, None] + speed[:, None] * lab.hold_s[:, :, None]


def orifice(lab: "Lab") -> np.ndarray:
    """The root of the pressure falls in a straight line: a pinhole."""
    return np.maximum(np.sqrt(lab.u) - 0.05 * lab.hold_s[:, :, None], 0.0) ** 2


def strut(lab: "Lab", share: float = 0.3) -> np.ndarray:
    """From a share of the range on something resists, ever more, as a rough surface does."""
    x = lab.u / HIGH_KPA
    over = np.maximum(x - share, 0.0)
    return lab.u - 0.8 * HIGH_KPA * over**1.5 / (0.3 + np.sqrt(over))


def sliding(lab: "Lab") -> np.ndarray:
    """Less Dahl's friction: full after some way, as an exponential of it, and larger under load.

    P. R. Dahl, A solid friction model, Aerospace Corporation TOR-0158(3107-18)-1, 1968.
    """
    u, last, held = lab.u, np.zeros(lab.chambers), np.zeros(lab.chambers)
    for i, now in enumerate(lab.commanded):
        way = np.sign(now - last)
        held = way + (held - way) * np.exp(-np.abs(now - last) / 3.0)
        u[i] -= 3.0 * held * (1 + np.sqrt(now / HIGH_KPA))
        last = now
    return u


def stretched(lab: "Lab") -> np.ndarray:
    """A pressure that is late by a stretched exponential.

    G. Williams and D. C. Watts, Trans. Faraday Soc. 66 (1970) 80.
    """
    left = np.exp(-((lab.hold_s / 1.2) ** 0.8))[:, :, None]
    before = np.vstack([np.zeros(lab.chambers), lab.commanded[:-1]])[:, None]
    return lab.u * (1 - left) + before * left


def bowed(lab: "Lab") -> np.ndarray:
    """A sensor whose line is bowed between its two points of calibration, more so below."""
    x = lab.u / HIGH_KPA
    return lab.u + 0.12 * HIGH_KPA * np.sin(np.pi * x) * (1 - 0.4 * x)


def limited(lab: "Lab") -> np.ndarray:
    """A wall whose chains are nearly straight, in the manner of A. N. Gent, Rubber Chem. Technol. 69 (1996) 59."""
    x = lab.u / HIGH_KPA
    return lab.u * (1 - 0.25 * x**2 / (1 + 0.5 * x))


def of_one(lab: "Lab", law: Law, c: int) -> np.ndarray:
    """What is seen where the law holds in chamber c alone, of three times the noise, (n, T, K)."""
    u = lab.u
    u[..., c] = law(lab)[..., c]
    clean, noise = lab.predict(u), lab.noise()
    size = np.sqrt(np.mean((clean - lab.predict(lab.u)) ** 2))
    return clean + noise * size / (3.0 * np.sqrt(np.mean(noise**2)))
