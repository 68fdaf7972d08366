"""Plain laws of one input and one output, in textbook form, for records without holds."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats

Motion = Callable[[Floats, float], Floats]
"""Input (n,) from 0 to 1 and the time between samples in s, to the output (n,)."""


def curved(u: Floats) -> Floats:
    """A rig's curve at rest, from 0 to 1."""
    return 0.7 * u + 0.3 * u**2


def lag(u: Floats, share: float) -> Floats:
    """A first-order lag that does this share of its way from sample to sample, from rest at the first."""
    out, state = np.empty_like(u), u[0]
    for i, x in enumerate(u):
        out[i] = state
        state = state + share * (x - state)
    return out


def backlash(u: Floats, half: float) -> Floats:
    """What follows once its input has crossed a gap."""
    out, state = np.empty_like(u), u[0]
    for i, x in enumerate(u):
        state = max(x - half, min(x + half, state))
        out[i] = state
    return out


def bouc_wen(u: Floats) -> Floats:
    """An elastic and a hysteretic spring side by side, in small steps of the input.

    Y.-K. Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249.
    """
    out, z, last = np.empty_like(u), 0.0, u[0]
    for i, x in enumerate(u):
        for du in np.full(50, (x - last) / 50):
            z += du * (8 - abs(z) * (np.sign(z * du) + 1) * 8)
        out[i], last = 0.8 * x + 0.12 * z, x
    return out


def slow(n: int) -> Floats:
    """A change over the whole record."""
    t = np.arange(n) / n
    return 0.1 * t + 0.075 * np.sin(2.2 * t)


def late(u: Floats, samples: int) -> Floats:
    """A pure dead time."""
    return np.concatenate([np.full(samples, u[0]), u[:-samples]])


@dataclass(frozen=True)
class Law:
    """A rig: its output, in which units, sampled how often; `right` names what its base lacks, `all_of` all of it."""

    name: str
    output: Motion
    units: tuple[str, str]
    sample_s: float
    degree: int
    right: frozenset[str]
    all_of: bool = False


MEMORY = frozenset({"delay", "creep"})
LOOP = frozenset({"hysteresis", "friction"})
LAWS = (
    Law("first order", lambda u, dt: lag(u, 0.1), ("V", "V"), 1e-3, 1, MEMORY),
    Law("slow first order, curved", lambda u, dt: curved(lag(u, 0.04)), ("V", "V"), 0.5, 2, MEMORY),
    Law(
        "dead time and first order",
        lambda u, dt: lag(late(u, 6), 0.3),
        ("kPa", "mm"),
        0.05,
        1,
        frozenset({"delay"}),
    ),
    Law("Hammerstein", lambda u, dt: lag(np.tanh(2 * u), 0.08), ("V", "V"), 0.02, 3, MEMORY),
    Law("two poles", lambda u, dt: lag(lag(u, 0.1), 0.05), ("V", "V"), 0.1, 1, MEMORY),
    Law("Bouc-Wen", lambda u, dt: bouc_wen(u), ("mm", "N"), 0.02, 1, LOOP),
    Law("Bouc-Wen, curved", lambda u, dt: curved(bouc_wen(u)), ("kPa", "mm"), 0.1, 2, LOOP),
    Law(
        "two Maxwell elements",
        lambda u, dt: curved(u) - 0.3 * lag(u, dt / 5) - 0.2 * lag(u, dt / 40),
        ("mm", "N"),
        0.1,
        2,
        frozenset({"creep"}),
    ),
    Law(
        "two Kelvin elements",
        lambda u, dt: curved(u) + 0.15 * lag(u, dt / 8) + 0.15 * lag(u, dt / 60),
        ("kPa", "mm"),
        0.1,
        2,
        frozenset({"creep"}),
    ),
    Law("slow change", lambda u, dt: curved(u) + slow(len(u)), ("kPa", "mm"), 0.1, 2, frozenset({"drift"})),
    Law("nothing", lambda u, dt: curved(u), ("kPa", "mm"), 0.1, 2, frozenset()),
    Law("backlash", lambda u, dt: backlash(u, 0.08), ("mm", "mm"), 0.05, 1, LOOP),
    Law(
        "backlash and Kelvin element",
        lambda u, dt: backlash(u, 0.08) + u + 0.4 * lag(u, dt / 30),
        ("kPa", "mm"),
        0.1,
        1,
        frozenset({"hysteresis", "creep"}),
        all_of=True,
    ),
    Law(
        "stop",
        lambda u, dt: np.minimum(u, 0.65),
        ("kPa", "mm"),
        0.1,
        1,
        frozenset({"contact", "regulator", "stiffening"}),
    ),
)


def driven(kind: str, n: int, random: np.random.Generator) -> Floats:
    """An input (n,) from 0 to 1: a growing sine, some sines, steps, ramps, or a smoothed random walk."""
    t = np.arange(n) / n
    if kind == "sine":
        return (0.5 - 0.5 * np.cos(24 * np.pi * t)) * (0.4 + 0.6 * t)
    if kind == "steps":
        return np.repeat(random.uniform(0, 1, n // 40 + 1), 40)[:n]
    if kind == "ramps":
        return np.interp(np.linspace(0, 24, n), np.arange(25), [0.0, *random.uniform(0, 1, 24)])
    if kind == "sines":
        u = np.sum([np.sin(2 * np.pi * (f * t + random.uniform())) for f in (3, 5, 8, 13, 21, 34)], axis=0)
    else:
        u = np.convolve(np.cumsum(random.normal(size=n)), np.ones(15) / 15, "same")
    return (u - u.min()) / np.ptp(u)


KINDS = ("sine", "sines", "steps", "ramps", "walk")
