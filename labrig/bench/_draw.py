"""Drawing a blind campaign: chance picks a rig, a programme, what is hidden, and what spoils the measurement."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.bench._bases import chambers_own_law, draw_base
from labrig.bench._classes import CLASSES, CONFOUNDED, FAMILIES, Kind, family_of
from labrig.bench._dataset import to_dataset
from labrig.bench._halves import half_of, make_rig
from labrig.bench._hide import FEW, Hidden, has, hide, pick_effects, pick_laws, pick_rig
from labrig.bench._in_one import FEWEST
from labrig.bench._nature import Path, Rig, simulate
from labrig.bench._noise import Spoil, spoil
from labrig.bench._path import PAUSE_S, make_path
from labrig.bench._programmes import DESIGNS, Plan, make_plan
from labrig.bench.records import BaseRecipe, RigRecipe, WholeTruth

if TYPE_CHECKING:
    import xarray as xr

_SAME_EFFECTS, _OTHER_EFFECTS = 12, 20  # how often laws, rig and programme are drawn again, and then effects
_TILTED, _LOADED = 0.15, 0.1  # campaigns with a base that is turned, with weights, whatever is hidden


@dataclass
class Campaign:
    """A blind campaign.

    `dataset` is the campaign and `fresh` another of the same rig, with a programme of its own (both as
    docs/reference/dataset.md has them); `base` is the recipe of the base model (for `make_base`), or None where the
    base is a static map of degree 1; `truth` says what is hidden and what a right answer is.
    """

    dataset: "xr.Dataset"
    fresh: "xr.Dataset"
    base: BaseRecipe | None
    truth: WholeTruth
    later: "Callable[..., xr.Dataset] | None" = field(default=None, repr=False, compare=False)
    """Measures another plan on the same rig, vented for `PAUSE_S` after the campaign; an int seeds its noise. Effects
    that are `ruled_out` do not act then.
    """
    parts: dict[str, Floats] = field(default_factory=dict, repr=False, compare=False)
    """By effect, what it alone changes (R, K) at the rows of `dataset`, capture by capture, without noise."""

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: all but what only the process that drew it needs."""
        return {**self.__dict__, "later": None, "parts": {}}


@dataclass(frozen=True)
class Drawn:
    """What chance picked for one campaign, apart from noise and base."""

    recipe: RigRecipe
    rig: Rig
    design: str
    plan: Plan
    path: Path
    hidden: list[Hidden]
    how: Spoil
    floor: float
    tilted: bool
    loaded: bool

    @property
    def laws(self) -> list[tuple[Any, float]]:
        """The laws and their strengths, as `simulate` wants them."""
        return [(h.law, h.strength) for h in self.hidden]


def draw(
    name: str,
    seed: int,
    half: str = "development",
    without: tuple[str, ...] = (),
    captures: int | None = None,
) -> Campaign:
    """The campaign of a class (see `CLASSES`), a seed and a half; the same three give the same campaign.

    `without`: effects that the library will not have; where one of them is hidden, unknown is the right
    answer. `captures`: about how many, in place of what chance says.
    """
    if name not in CLASSES:
        raise LabrigError(f"bench: there is no class '{name}' (known: {', '.join(CLASSES)})")
    random = np.random.default_rng([seed, *f"{half}/{name}".encode()])
    what = _pick(name, half, captures, random)
    kind, rig, plan, floor = CLASSES[name], what.rig, what.plan, what.floor
    pressure = np.array([p for _, p in plan.commands])
    structural = float(random.uniform(*kind.structural))
    if kind.static:
        base: BaseRecipe = {**what.recipe, "kind": "exact", "seed": 0}
    else:
        base = draw_base(what.recipe, pressure, floor, random, structural)
    dataset = _measure(what, plan, what.path, what.how, random)
    dataset.attrs["start_s"] = 0.0
    again = make_plan(
        "holds",
        random,
        rig.high_kpa,
        120,
        False,
        what.tilted,
        long_share=0.15,
        loaded=what.loaded,
        min_kpa=rig.low_kpa,
    )
    clean = Spoil(row=what.how.row, capture=what.how.capture)
    fresh = _measure(what, again, make_path(again), clean, random)

    effects = [h.effect for h in what.hidden]
    deleted = {*without, *(family_of(effects[0]) if kind.deleted else ())}
    truth: WholeTruth = {
        "class": name,
        "half": half,
        "seed": seed,
        "effects": effects,
        "laws": [h.name for h in what.hidden],
        "rig": what.recipe["rig"],
        "base_kind": "static" if kind.static else base["kind"],
        "verdict": _right_verdict(kind, effects, deleted),
        "also": _also(base, pressure) if structural else [],
        "without": sorted(deleted),
        "amplitudes": {h.effect: h.floors for h in what.hidden},
        "strengths": {h.effect: h.strength for h in what.hidden},
        "floor": floor,
        "structural": structural * floor,
        "unit": " and ".join(dict.fromkeys(o.unit for o in rig.observables)),
        "design": what.design,
        "captures": plan.captures,
        "spoil": what.how.as_dict(),
        "base": base,
    }

    def later(after: Plan, seed: int, ruled_out: Collection[str] = ()) -> "xr.Dataset":
        path = make_path(after, before=plan)
        left = replace(what, hidden=[h for h in what.hidden if h.effect not in ruled_out])
        measured = _measure(left, after, path, clean, np.random.default_rng([seed, 13]))
        measured.attrs["start_s"] = plan.time_s + PAUSE_S
        if ruled_out:
            said = np.full(after.captures, " ".join(sorted(ruled_out)))
            measured = measured.assign_coords(ruled_out=("capture", said))
        return measured

    nothing = simulate(rig, [], what.path)
    parts = {h.effect: simulate(rig, [(h.law, h.strength)], what.path) - nothing for h in what.hidden}
    return Campaign(dataset, fresh, None if kind.static else base, truth, later, parts)


def _pick(name: str, half: str, captures: int | None, random: np.random.Generator) -> Drawn:
    kind = CLASSES[name]
    for _ in range(_OTHER_EFFECTS):
        design = str(random.choice(list(CONFOUNDED) if kind.confounded else list(DESIGNS)))
        effects = pick_effects(kind, half_of(half), design, random)
        for _ in range(_SAME_EFFECTS):
            drawn = _attempt(kind, half, effects, design, captures, random)
            if drawn is not None:
                return drawn
    raise LabrigError(f"bench: chance finds no campaign of class '{name}' in the half '{half}'")


def _attempt(
    kind: Kind, half: str, effects: list[str], design: str, captures: int | None, random: np.random.Generator
) -> Drawn | None:
    """Laws, a rig, a programme and parameters for effects; None where they do not go together."""
    laws = pick_laws(kind, effects, half_of(half), random)
    needs = frozenset().union(*(law.needs for law in laws))
    recipe = pick_rig(half, needs, kind.static, design == "one_hold", random)
    if recipe is None:
        return None
    rig = make_rig(recipe)
    chambers = len(rig.chambers)
    if kind.in_one and chambers < FEWEST:
        return None
    if design == "one_hold" and "drift" in effects and len(rig.observables) > FEW:
        return None  # many markers show that it is not the chambers that drift
    tilted = "tilt" in needs or bool(random.random() < (0.5 if "gravity" in effects else _TILTED))
    loaded = "payload" in needs or bool(random.random() < _LOADED)
    count, repeats = int(random.integers(60, 301)), bool(random.random() < 0.75)
    if kind.confounded:
        count, repeats, tilted, loaded = min(count, 120), False, False, False
    long_share = float(random.uniform(0.05, 0.2))
    plan = make_plan(
        design,
        random,
        rig.high_kpa,
        captures or count,
        repeats,
        tilted,
        long_share,
        loaded,
        rig.low_kpa,
    )
    path = make_path(plan)
    if not needs <= has(rig, path):
        return None
    how = Spoil(
        row=rig.noise,
        capture=rig.noise * float(random.uniform(0.6, 1.2)),
        uneven=float(random.choice([0.0, 0.4])),
        occlusion=float(random.choice([0.0, 0.03, 0.08])),
        outliers=float(random.choice([0.0, 0.002, 0.005])),
    )
    floor = how.floor(float(np.mean([len(r) for r in plan.capture_rows_s])))
    if kind.slow:
        how = Spoil(**{**how.as_dict(), "common": kind.slow * floor})
    wanted = [float(random.uniform(*kind.floors)) for _ in laws]
    chamber = int(random.integers(chambers)) if kind.in_one else None
    hidden = hide(laws, wanted, rig, path, floor, kind.static, random, chamber)
    if hidden is None:
        return None
    return Drawn(recipe, rig, design, plan, path, hidden, how, floor, tilted, loaded)


def _right_verdict(kind: Kind, effects: list[str], deleted: set[str]) -> str:
    if not effects:
        return "nothing_missing"
    if kind.outside or set(effects) & deleted:
        return "unknown"
    if kind.confounded:
        return "confounded"
    return "identified" if len(effects) == 1 else "multiple"


def _also(base: BaseRecipe, pressure: Floats) -> list[str]:
    """Names that a wrong law of the base's chambers may rightly go by: it is an error of compliance."""
    wrong_law = chambers_own_law(base, pressure)
    return sorted({*FAMILIES["pressure"], *FAMILIES["limit"]}) if wrong_law else []


def _measure(what: Drawn, plan: Plan, path: Path, how: Spoil, random: np.random.Generator) -> "xr.Dataset":
    true = simulate(what.rig, what.laws, path)
    capture = np.repeat(np.arange(plan.captures), [len(r) for r in plan.capture_rows_s])
    return to_dataset(what.rig, plan, spoil(true, what.rig, capture, how, random), random)
