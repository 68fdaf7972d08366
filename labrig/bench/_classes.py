"""The classes of blind campaigns: what may be hidden in each, how large, and under which circumstances."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drivers.simulated.hidden import LISTED, UNLISTED
from labrig.bench._noise import Spoil

FAMILIES: dict[str, tuple[str, ...]] = {
    "history": ("hysteresis", "friction"),
    "hold": ("creep", "leak", "delay"),
    "pressure": ("regulator", "tension", "stiffening"),
    "limit": ("contact",),
    "pair": ("coupling",),
    "shape": ("frame", "rest_shape", "gravity"),
    "session": ("drift", "marker_slip"),
}
"""Effects that can stand in for each other, to a degree."""

STATIC_SAFE = ("hysteresis", "creep", "leak", "stiffening", "contact", "friction", "drift", "coupling")
"""Effects that a static map of degree 1, fitted to the campaign, cannot swallow."""

_NEED_MARKERS = ("frame", "rest_shape", "gravity", "marker_slip", "lens", "mount")
_NEED_CURVATURE = ("gravity", "tension")
_NEED_PAIRS = ("coupling", "kink")

_CONFOUNDED = {
    "one_hold": (
        "creep",
        "drift",
        "leak",
    ),  # one force against time: nothing but the curve's form tells them apart
    "one_level": ("regulator", "stiffening", "tension", "hysteresis", "friction"),  # two states in all
}


@dataclass(frozen=True)
class Kind:
    """One class: how many effects of how many floors, and what else is particular to it."""

    effects: int
    floors: tuple[float, float] = (1.0, 1.0)
    slow: float = 0.0  # common-mode AR(0.9) noise, in floors
    structural: bool = False
    static: bool = False
    confounded: bool = False
    unlisted: bool = False
    deleted: bool = False
    bodies: str = "any"  # any, markers (no forces), or force
    usual: int = 100  # campaigns of a full benchmark


CLASSES: dict[str, Kind] = {
    "null": Kind(0, usual=200),
    "null-slow": Kind(0, slow=0.5),
    "null-static": Kind(0, static=True, usual=50),
    "single-1": Kind(1, (1.0, 1.0), bodies="markers"),
    "single-2": Kind(1, (2.0, 2.0), bodies="markers"),
    "force": Kind(1, (2.0, 4.0), bodies="force", usual=50),
    "static": Kind(1, (2.0, 4.0), static=True),
    "pair": Kind(2, (1.0, 2.0), bodies="markers"),
    "structural": Kind(1, (2.0, 4.0), structural=True, bodies="markers"),
    "confounded": Kind(1, (2.0, 4.0), confounded=True, usual=50),
    "unlisted": Kind(1, (2.0, 4.0), unlisted=True, bodies="markers", usual=50),
    "deleted": Kind(1, (2.0, 4.0), deleted=True, bodies="markers", usual=50),
}


@dataclass
class Draw:
    """What chance picked for one campaign."""

    body: dict[str, Any]
    design: str
    captures: int
    repeats: bool
    long_share: float
    tilted: bool
    static: bool
    structural: float
    spoil: Spoil
    effects: list[str] = field(default_factory=list)
    floors: list[float] = field(default_factory=list)
    without: tuple[str, ...] = ()


def available(body: dict[str, Any], static: bool) -> list[str]:
    """Listed and unlisted effects that such a body can have, and that a static base (if it is one) leaves
    over.
    """
    chambers = body.get("chambers") or len(body["active"])
    out = []
    for name in (*LISTED, *UNLISTED):
        if body["kind"] == "cylinder" and name in _NEED_MARKERS:
            continue
        if chambers < 2 and name in _NEED_PAIRS:
            continue
        if body["linear"] and name in _NEED_CURVATURE:
            continue
        if static and name in LISTED and name not in STATIC_SAFE:
            continue
        out.append(name)
    return out


def _body(random: np.random.Generator, kind: Kind) -> dict[str, Any]:
    chance, linear = random.random(), kind.static
    whole = {"kind": "surface", "surface": "mannequin", "active": list(range(9)), "linear": linear}
    if kind.confounded and chance < 0.5:
        return {"kind": "cylinder", "chambers": 1, "linear": linear}
    if kind.bodies == "force":
        return {"kind": "cylinder", "chambers": int(random.integers(1, 3)), "linear": linear}
    if chance < 0.6:
        return whole
    if chance < 0.75:
        active = sorted(int(c) for c in random.permutation(9)[: int(random.integers(2, 5))])
        return {"kind": "surface", "surface": "mannequin", "active": active, "linear": linear}
    if chance < 0.88:
        active = sorted(int(c) for c in random.permutation(4)[: int(random.integers(1, 5))])
        return {"kind": "surface", "surface": "membrane", "active": active, "linear": linear}
    chambers = int(random.integers(1, 3))
    return whole if kind.bodies == "markers" else {"kind": "cylinder", "chambers": chambers, "linear": linear}


def _spoil(random: np.random.Generator, unit: float) -> Spoil:
    return Spoil(
        row=unit,
        capture=unit * float(random.uniform(0.6, 1.2)),
        uneven=float(random.choice([0.0, 0.4])),
        occlusion=float(random.choice([0.0, 0.03, 0.08])),
        outliers=float(random.choice([0.0, 0.002, 0.005])),
    )


def pick(name: str, random: np.random.Generator) -> Draw:
    """Everything that chance decides about a campaign of class `name`, apart from noise and set-points."""
    kind = CLASSES[name]
    body = _body(random, kind)
    unit = 0.25 if body["kind"] == "cylinder" else 0.1
    what = Draw(
        body=body,
        design=str(random.choice(["holds", "walk", "sweeps", "sessions"])),
        captures=int(random.integers(60, 301)),
        repeats=bool(random.random() < 0.75),
        long_share=float(random.uniform(0.05, 0.2)),
        tilted=False,
        static=kind.static,
        structural=float(random.uniform(1.0, 2.0)) if kind.structural else 0.0,
        spoil=_spoil(random, unit),
    )
    if kind.slow:
        floor = what.spoil.floor(4.0)
        what.spoil = Spoil(**{**what.spoil.as_dict(), "common": kind.slow * floor})
    able = available(body, kind.static)
    if kind.confounded:
        what.design = "one_hold" if body["kind"] == "cylinder" else "one_level"
        what.effects = [str(random.choice([e for e in _CONFOUNDED[what.design] if e in able]))]
        what.captures, what.repeats = min(what.captures, 120), False
    elif kind.unlisted:
        what.effects = [str(random.choice([e for e in UNLISTED if e in able]))]
    elif kind.deleted:
        families = [f for f in ("history", "hold", "pair") if set(FAMILIES[f]) & set(able)]
        family = FAMILIES[str(random.choice(families))]
        what.effects = [str(random.choice([e for e in family if e in able and e != "delay"]))]
        what.without = family
    else:
        what.effects = _several(kind.effects, [e for e in able if e in LISTED], random)
    what.floors = [float(random.uniform(*kind.floors)) for _ in what.effects]
    what.tilted = "gravity" in what.effects and bool(random.random() < 0.7)
    return what


def _several(count: int, able: list[str], random: np.random.Generator) -> list[str]:
    """`count` effects of different families."""
    families = [f for f in FAMILIES if set(FAMILIES[f]) & set(able)]
    if count == 1:
        return [str(random.choice(able))]
    chosen = random.permutation(families)[:count]
    return [str(random.choice([e for e in FAMILIES[f] if e in able])) for f in chosen]
