"""Drawing a blind campaign: chance picks a body, a programme, what is hidden, and what spoils the
measurement.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drivers.simulated import Programme, calibrate, run_programme
from drivers.simulated.hidden import EFFECTS, UNLISTED, Hidden, Setting
from labrig._errors import LabrigError
from labrig.bench._bodies import BenchBody, make_body, observed, own_error
from labrig.bench._classes import CLASSES, FAMILIES, Draw, pick
from labrig.bench._dataset import to_dataset
from labrig.bench._noise import Spoil, spoil
from labrig.bench._programmes import Plan, make_plan

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MAX_KPA = 60.0
PAUSE_S = 600.0


@dataclass
class Campaign:
    """A blind campaign.

    `dataset` is the campaign and `fresh` another of the same rig, with a programme of its own, recorded
    after it (both as docs/reference/dataset.md has them); `base` is the recipe of the base model (for
    `make_base`), or None where the base is a static map of degree 1; `truth` says what is hidden and what a
    right answer is.
    """

    dataset: "xr.Dataset"
    fresh: "xr.Dataset"
    base: dict[str, Any] | None
    truth: dict[str, Any] = field(default_factory=dict)
    later: "Callable[[Plan, int], xr.Dataset] | None" = field(default=None, repr=False, compare=False)
    """Measures another plan on the same rig, vented for `PAUSE_S` after the campaign; an int seeds its noise."""


def draw(name: str, seed: int, without: tuple[str, ...] = (), captures: int | None = None) -> Campaign:
    """The campaign of a class (see `CLASSES`) and a seed; the same two give the same campaign.

    `without`: effects that the library will not have; where one of them is hidden, unknown is the right
    answer. `captures`: about how many, in place of what chance says.
    """
    if name not in CLASSES:
        raise LabrigError(f"bench: there is no class '{name}' (known: {', '.join(CLASSES)})")
    random = np.random.default_rng([seed, *name.encode()])
    what = pick(name, random)
    what.captures = captures or what.captures
    body = make_body(what.body)
    max_kpa = np.full(len(body.chamber_names), MAX_KPA)
    plan = make_plan(what.design, random, max_kpa, what.captures, what.repeats, what.tilted, what.long_share)
    programme = _programme(plan)
    rows = float(np.mean([len(r) for r in plan.capture_rows_s]))
    floor = what.spoil.floor(rows)
    hidden, sizes = _hide(what, body, max_kpa, programme, floor, random)
    base = _base(what, body, programme, floor, random)

    dataset = _measure(body, hidden, plan, programme, what.spoil, random)
    dataset.attrs["start_s"] = 0.0
    again = make_plan("holds", random, max_kpa, 120, repeats=False, long_share=0.15)
    clean = Spoil(row=what.spoil.row, capture=what.spoil.capture)
    fresh = _measure(body, hidden, again, _programme(again), clean, random)

    effects = [effect.name for effect in hidden]
    truth = {
        "class": name,
        "seed": seed,
        "effects": effects,
        "verdict": _right_verdict(name, effects, without),
        "also": _also(base),
        "without": sorted({*without, *what.without}),
        "amplitudes": dict(zip(effects, sizes, strict=True)),
        "strengths": {effect.name: float(effect.strength) for effect in hidden},
        "floor": floor,
        "structural": what.structural * floor,
        "unit": body.unit,
        "body": what.body,
        "design": what.design,
        "captures": plan.captures,
        "spoil": what.spoil.as_dict(),
        "base": base,
    }
    if truth["without"] and truth["verdict"] == "identified":
        truth["verdict"] = "unknown" if set(effects) & set(truth["without"]) else "identified"

    def later(after: Plan, seed: int) -> "xr.Dataset":
        return _later(body, hidden, plan, after, clean, np.random.default_rng([seed, 13]))

    return Campaign(dataset, fresh, None if what.static else base, truth, later)


def _right_verdict(name: str, effects: list[str], without: tuple[str, ...]) -> str:
    if not effects:
        return "nothing_missing"
    if CLASSES[name].confounded:
        return "confounded"
    if set(effects) & ({*UNLISTED} | set(without)):
        return "unknown"
    return "identified" if len(effects) == 1 else "multiple"


def _also(base: dict[str, Any]) -> list[str]:
    """Names that a wrong law of the base's chambers may rightly go by: it is an error of compliance."""
    wrong_law = base["error"] and base["error"]["form"] == "law"
    return sorted({*FAMILIES["pressure"], *FAMILIES["limit"]}) if wrong_law else []


def _programme(plan: Plan) -> Programme:
    start = np.repeat(plan.capture_s, [len(r) for r in plan.capture_rows_s])
    tilt = np.repeat(
        np.array(plan.session_tilt_deg)[plan.capture_session], [len(r) for r in plan.capture_rows_s]
    )
    return Programme(
        command_s=np.array([t for t, _ in plan.commands]),
        command_kpa=np.array([p for _, p in plan.commands]),
        row_s=start + np.concatenate(plan.capture_rows_s),
        tilt_deg=tilt,
    )


def _hide(
    what: Draw,
    body: BenchBody,
    max_kpa: Array,
    programme: Programme,
    floor: float,
    random: np.random.Generator,
) -> tuple[list[Hidden], list[float]]:
    """The hidden effects, each of its size on this very programme; one that cannot reach it is drawn again."""
    hidden, sizes = [], []
    for name, floors in zip(what.effects, what.floors, strict=True):
        for attempt in range(8):
            child = np.random.default_rng(random.integers(2**63))
            effect = EFFECTS[name](Setting(body, max_kpa, float(programme.row_s[-1]), child))
            wanted = floors * floor
            reached = calibrate(body, effect, wanted, programme, lambda position: observed(body, position))
            if abs(reached / wanted - 1.0) < 0.05:
                break
            if attempt == 7:
                raise LabrigError(f"bench: {name} cannot reach {wanted:.3g} {body.unit} in this campaign")
        hidden.append(effect)
        sizes.append(reached / floor)
    return hidden, sizes


def _base(
    what: Draw, body: BenchBody, programme: Programme, floor: float, random: np.random.Generator
) -> dict[str, Any]:
    """The base's recipe; a structural error is scaled to `what.structural` floors over this programme."""
    if not what.structural:
        return {"body": what.body, "error": None}
    form = "spread" if what.body["kind"] == "surface" and random.random() < 0.5 else "law"
    error = {"form": form, "seed": int(random.integers(10_000)), "scale": 1.0}
    recipe = {"body": what.body, "error": error}
    error["scale"] = float(what.structural * floor / own_error(recipe, programme.command_kpa))
    return recipe


def _later(
    body: BenchBody, hidden: list[Hidden], before: Plan, after: Plan, how: Spoil, random: np.random.Generator
) -> "xr.Dataset":
    """The dataset of a plan that follows another one after a pause; its own clock starts at zero."""
    start_s = before.time_s + PAUSE_S
    programme = _programme(after)
    zeros = np.zeros_like(programme.command_kpa[:1])
    first = np.array([p for _, p in before.commands])
    whole = Programme(
        command_s=np.concatenate(
            [[t for t, _ in before.commands], [before.time_s], programme.command_s + start_s]
        ),
        command_kpa=np.concatenate([first, zeros, programme.command_kpa]),
        row_s=programme.row_s + start_s,
        tilt_deg=programme.tilt_deg,
    )
    measured = _measure(body, hidden, after, whole, how, random)
    measured.attrs["start_s"] = start_s
    return measured


def _measure(
    body: BenchBody,
    hidden: list[Hidden],
    plan: Plan,
    programme: Programme,
    how: Spoil,
    random: np.random.Generator,
) -> "xr.Dataset":
    _, position = run_programme(body, hidden, programme)
    capture = np.repeat(np.arange(plan.captures), [len(r) for r in plan.capture_rows_s])
    measured = spoil(position[..., list(body.axes)], capture, how, random)
    return to_dataset(body, plan, measured, MAX_KPA, random)
