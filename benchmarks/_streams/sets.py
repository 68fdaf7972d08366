"""Streams of published models, with the parameters of their publications: no formula of labrig's library.

Each set is a record of one input and one output with white noise, made from a fixed seed, a base to begin with, and the
names that are right for what the base lacks.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats


@dataclass(frozen=True)
class Record:
    """One input and one output over time, (n,) each."""

    time_s: Floats
    input: Floats
    output: Floats


@dataclass(frozen=True)
class StreamSet:
    """A stream, what it measures, the model to begin with, and the names that are right.

    `make(random, seconds)` gives the record without noise; `noise` is the sd of its white noise.
    """

    name: str
    source: str
    make: Callable[[np.random.Generator, float], Record]
    input: tuple[str, str]
    output: tuple[str, str]
    noise: float
    model: str
    right: frozenset[str]


def sweep(random: np.random.Generator, n: int, dt: float, slow_s: float, fast_s: float) -> Floats:
    """A random walk between 0 and 1: sines of random periods and phases, as multisine experiments use."""
    t = np.arange(n) * dt
    periods = np.geomspace(slow_s, fast_s, 7)
    phases = random.uniform(0, 2 * np.pi, 7)
    u = sum(np.sin(2 * np.pi * t / p + a) * p**0.3 for p, a in zip(periods, phases, strict=True))
    u = u - u.min()
    return u / u.max() * np.minimum(1.0, t / (10 * dt))


def triangles(random: np.random.Generator, n: int, dt: float, periods_s: tuple[float, ...]) -> Floats:
    """Triangle waves of random heights, one cycle of each period in turn, from 0 to at most 1."""
    out: list[Floats] = []
    while sum(map(len, out)) < n:
        period = periods_s[len(out) % len(periods_s)]
        k = max(int(period / dt), 4)
        out.append(random.uniform(0.4, 1.0) * (1 - np.abs(np.linspace(-1, 1, k, endpoint=False))))
    return np.concatenate(out)[:n]


def muscle(random: np.random.Generator, seconds: float) -> Record:
    """McKibben muscle, isobaric pressure sweeps: contraction with the friction of its braid as Maxwell slip.

    Generalised Maxwell slip of four elements: T. Vo-Minh, T. Tjahjowidodo, H. Ramon, H. Van Brussel, A new approach to
    modeling hysteresis in a pneumatic artificial muscle using the Maxwell-slip model, IEEE/ASME Trans. Mechatronics 16
    (2011) 177. The muscle: B. Tondu, P. Lopez, IEEE Control Systems 20 (2000) 15.
    """
    dt = 0.05
    n = int(seconds / dt)
    p = 300 * triangles(random, n, dt, (12.0, 5.0, 8.0))  # kPa
    ideal = 45 * (1 - np.exp(-p / 140))  # mm at a constant load
    stiffness, most = np.array([0.9, 0.55, 0.3, 0.12]), np.array([0.55, 0.9, 1.3, 1.6])
    force, slipped, last = np.zeros(4), np.empty(n), 0.0
    for i, x in enumerate(ideal):
        force = np.clip(force + stiffness * (x - last), -most, most)
        last, slipped[i] = x, force.sum()
    return Record(np.arange(n) * dt, p, ideal - 0.9 * slipped)


def elastomer(random: np.random.Generator, seconds: float) -> Record:
    """Filled rubber in simple shear between plates: force under strain sweeps, a generalised Maxwell solid.

    R. M. Christensen, Theory of Viscoelasticity, 2nd ed., Dover 2003, ch. 1; shares and times of a three-term Prony
    series as fitted to HNBR in many finite-element manuals.
    """
    dt = 0.1
    n = int(seconds / dt)
    x = 5.0 * sweep(random, n, dt, 60.0, 4.0)  # mm
    shares, times = (0.16, 0.12, 0.10), (1.8, 14.0, 110.0)
    force, stiffness = np.zeros(n), 12.0
    branch, last = np.zeros(3), 0.0
    for i, value in enumerate(x):
        for j, tau in enumerate(times):
            branch[j] = branch[j] * np.exp(-dt / tau) + shares[j] * (value - last)
        last = value
        force[i] = stiffness * ((1 - sum(shares)) * value + branch.sum())
    return Record(np.arange(n) * dt, x, force)


def tanks(random: np.random.Generator, seconds: float) -> Record:
    """Two tanks, one above the other, free outlets: the level of the lower under the voltage of the pump.

    M. Schoukens, P. Mattsson, T. Wigren, J.-P. Noel, Cascaded tanks benchmark combining soft and hard nonlinearities,
    Workshop on Nonlinear System Identification Benchmarks, 2016, without overflow.
    """
    dt = 1.0
    n = int(seconds / dt)
    u = 1.2 + 2.2 * np.repeat(random.uniform(0, 1, n // 60 + 1), 60)[:n]  # V, steps of a minute
    out, upper, lower = np.empty(n), 0.0, 0.0
    for i, volt in enumerate(u):
        out[i] = lower
        for _ in range(4):
            upper, lower = (
                max(upper + dt / 4 * (0.054 * volt - 0.06 * np.sqrt(upper)), 0.0),
                max(lower + dt / 4 * (0.06 * np.sqrt(upper) - 0.05 * np.sqrt(lower)), 0.0),
            )
    return Record(np.arange(n) * dt, u, out)


def tendon(random: np.random.Generator, seconds: float) -> Record:
    """Tendon in a sheath: what arrives at the far end of what was pulled, capstan friction on every element.

    M. Kaneko, T. Yamashita, K. Tanie, Basic considerations on transmission characteristics for tendon drive robots,
    ICAR 1991; V. Agrawal et al., IEEE Trans. Robotics 26 (2010) 206: ten lumped elements.
    """
    dt = 0.05
    n = int(seconds / dt)
    pulled = 40 * sweep(random, n, dt, 30.0, 3.0)  # N
    loss, count = 0.07, 10
    tension = np.zeros((count + 1,))
    out = np.empty(n)
    for i, pull in enumerate(pulled):
        tension[0] = pull
        for e in range(1, count + 1):  # an element follows only outside the wedge of friction
            tension[e] = np.clip(tension[e], tension[e - 1] * np.exp(-loss), tension[e - 1] * np.exp(loss))
        out[i] = tension[-1]
    return Record(np.arange(n) * dt, pulled, out)


SETS = (
    StreamSet(
        "muscle",
        "Vo-Minh et al. 2011",
        muscle,
        ("pressure", "kPa"),
        ("contraction", "mm"),
        0.08,
        "base: {kind: static, degree: 3}\n",
        frozenset({"hysteresis", "friction"}),
    ),
    StreamSet(
        "elastomer",
        "Christensen 2003",
        elastomer,
        ("shear", "mm"),
        ("force", "N"),
        0.15,
        "base: {kind: static, degree: 3}\n",
        frozenset({"creep"}),
    ),
    StreamSet(
        "tanks",
        "Schoukens et al. 2016",
        tanks,
        ("pump", "V"),
        ("level", "V"),
        0.02,
        "base: {kind: static, degree: 2}\n",
        frozenset({"creep", "delay"}),
    ),
    StreamSet(
        "tendon",
        "Kaneko et al. 1991",
        tendon,
        ("pull", "N"),
        ("tension", "N"),
        0.1,
        "base: {kind: static, degree: 1}\n",
        frozenset({"hysteresis", "friction"}),
    ),
)
