"""What is hidden in a campaign: effects and laws by chance, on a rig that can have them, as large as they should be."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats
from labrig.bench._classes import CONFOUNDED, DELETED, FAMILIES, STATIC_SAFE, Kind
from labrig.bench._halves import half_of, make_rig
from labrig.bench._in_one import InOneChamber, acts_in_chambers
from labrig.bench._nature import (
    EFFECTS,
    Half,
    Law,
    Path,
    Rig,
    Setting,
    simulate,
)
from labrig.bench._size import strength_for
from labrig.bench.records import RigRecipe

LONG_S = 15.0
STRONGEST = 8.0
"""Laws keep their character up to several times their natural size; what needs more is drawn again."""
_CURVED = 0.05
_SENSED = {"angle": "deg", "force": "N"}
_OF_RIGS = frozenset({"markers", "marker", "several", "curved", *_SENSED})
FEW = 3  # observables: so few that their pattern tells nothing


def has(rig: Rig, path: Path | None = None) -> frozenset[str]:
    """What a rig, and the path that it is taken along, have of the things that laws may need."""
    axes = np.bincount([o.marker for o in rig.observables if o.marker >= 0], minlength=1)
    found = {"markers"} if np.sum(axes >= 2) >= 3 else set()
    if rig.marker_names:
        found.add("marker")
    sensed = {o.unit for o in rig.observables if o.marker < 0}
    found |= {name for name, unit in _SENSED.items() if unit in sensed}
    if len(rig.chambers) > 1:
        found.add("several")
    if _bend(rig) > _CURVED:
        found.add("curved")
    if path is not None:
        if path.hold_s[path.row].max() > LONG_S:
            found.add("holds")
        if np.ptp(path.tilt_deg) > 0:
            found.add("tilt")
        if np.ptp(path.payload_kg) > 0:
            found.add("payload")
    return frozenset(found)


def _bend(rig: Rig) -> float:
    """How far the deflection of any chamber alone is from a straight line, as a share of its largest."""
    level = np.linspace(0.0, 1.0, 11)
    out = 0.0
    for c, high in enumerate(rig.high_kpa):
        kpa = np.zeros((level.size, len(rig.chambers)))
        kpa[:, c] = level * high
        own = rig.deflection(kpa)[:, c]
        out = max(out, float(np.max(np.abs(own / own[-1] - level)))) if own[-1] else out
    return out


def pick_effects(kind: Kind, half: Half, design: str, random: np.random.Generator) -> list[str]:
    """The names of what is to be hidden: every effect of the library is as likely as the others."""
    able = [e for e in EFFECTS if half.laws.get(e)]
    if kind.in_one:
        able = [e for e in able if any(acts_in_chambers(law) for law in half.laws[e])]
    if kind.outside or not kind.effects:
        return [""] * kind.effects
    if kind.confounded:
        able = [e for e in able if e in CONFOUNDED[design]]
    if kind.static:
        able = [e for e in able if e in STATIC_SAFE]
    if kind.deleted:
        able = [e for e in able if e in DELETED]
    first = str(random.choice(able))
    if kind.effects == 1:
        return [first]
    own = next(f for f in FAMILIES.values() if first in f)
    return [first, str(random.choice([e for e in able if e not in own]))]


def pick_laws(kind: Kind, effects: Sequence[str], half: Half, random: np.random.Generator) -> list[type[Law]]:
    """A law for each name, uniformly among the effect's laws; of those outside the library where the name is empty."""
    each = [half.laws[name] if name else half.outside for name in effects]
    if kind.in_one:
        each = [[law for law in laws if acts_in_chambers(law)] for laws in each]
    return [_one(laws, random) for laws in each]


def _one(laws: Sequence[type[Law]], random: np.random.Generator) -> type[Law]:
    return laws[int(random.integers(len(laws)))]


def pick_rig(
    half: str, needs: frozenset[str], static: bool, few: bool, random: np.random.Generator
) -> RigRecipe | None:
    """The recipe of a rig of a half that has what is needed; None if chance finds none.

    `static`: made linear. `few`: one of at most three observables, if the half has such rigs.
    """
    kinds = list(half_of(half).rigs)
    for attempt in range(60):
        recipe: RigRecipe = {
            "half": half,
            "rig": str(random.choice(kinds)),
            "rig_seed": int(random.integers(2**31)),
            "linear": static,
        }
        rig = make_rig(recipe)
        if few and attempt < 40 and len(rig.observables) > FEW:
            continue
        if needs & _OF_RIGS <= has(rig):
            return recipe
    return None


@dataclass(frozen=True)
class Hidden:
    """A law at work: its effect, its name, itself, how strong it is, and its size in floors."""

    effect: str
    name: str
    law: Law
    strength: float
    floors: float


def hide(
    laws: Sequence[type[Law]],
    wanted: Sequence[float],
    rig: Rig,
    path: Path,
    floor: float,
    static: bool,
    random: np.random.Generator,
    chamber: int | None = None,
) -> list[Hidden] | None:
    """Laws with parameters by chance, each alone as large as wanted (in floors) on this very path, if they can be.

    With `static` the size is that of what a map of degree 1 leaves; with a `chamber` they hold in that one only.
    """
    clean = simulate(rig, [], path)
    left = _beside_a_map(path) if static else None
    out = []
    for of_law, floors in zip(laws, wanted, strict=True):
        for _ in range(3):
            law = of_law(Setting(rig, path, np.random.default_rng(random.integers(2**63))))
            law = law if chamber is None else InOneChamber(law, chamber)

            def size(strength: float, law: Law = law) -> float:
                change = simulate(rig, [(law, strength)], path) - clean
                change = (left(change) if left else change) / rig.noisier
                return float(np.sqrt(np.mean(np.square(change))))

            strength = strength_for(size, floors * floor, STRONGEST)
            if strength is not None:
                floors = size(strength) / floor
                out.append(Hidden(of_law.effect, of_law.__name__, law, strength, floors))
                break
        else:
            return None
    return out


def _beside_a_map(path: Path) -> Callable[[Floats], Floats]:
    """Takes out of a change (R, K) what is linear in the pressures that were commanded."""
    kpa = path.commanded_kpa[path.row]
    basis = np.linalg.svd(np.column_stack([np.ones(len(kpa)), kpa]), full_matrices=False)[0]
    return lambda change: change - basis @ (basis.T @ change)
