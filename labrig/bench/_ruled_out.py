"""What it is worth to rule a suspect out and to measure again: drawn campaigns, each before and after that."""

import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.bench._calibrate import planned
from labrig.bench._draw import Campaign, draw
from labrig.bench._files import write_model
from labrig.bench._intervals import share_text
from labrig.bench._lines import each_once
from labrig.bench._programmes import Plan
from labrig.bench._report import markdown, write_section
from labrig.diagnosis import POSSIBLE, SURE, considered, prepared, rows_from
from labrig.experiment import Again, Limits, again
from labrig.model import Model

if TYPE_CHECKING:
    import xarray as xr

    from labrig.diagnosis import Considered

MIX = ("single", "pair", "single", "structural", "single", "outside", "single")
"""The classes of campaigns, one after another and again from the first."""
SUSPECTED = 0.02
"""By evidence, for somebody to take the trouble: less than what is called possible, so that innocents are tried too."""
MINUTES = 6.0
RECORDS = "ruled_out.jsonl"
_LONG_S, _PAUSE_S = 15.0, 60.0


@dataclass(frozen=True)
class Tried:
    """The likeliest suspect of a campaign that somebody can rule out: whether it was there, and what was said of it
    `before` that and `after` (probabilities); by evidence, for its share, and for what is gone, afterwards. `back`:
    after it was put back, where it was gone and still in doubt; else as after.
    """

    half: str
    effect: str
    there: bool
    before: float
    after: float
    by_evidence: float
    share: float
    gone: float
    back: float


def ruled_out_plan(count: int, seed: int, halves: Sequence[str]) -> list[tuple[str, int, str]]:
    """(class, seed, half) of `count` campaigns of each half."""
    return planned(MIX, count, seed, halves)


def run_ruled_out(
    todo: Sequence[tuple[str, int, str]], folder: Path, jobs: int = 2
) -> Iterator[Tried | None]:
    """Try each campaign, `jobs` at a time; None where nothing in it is to be ruled out.

    Each is written as it is done; what is there already is yielded first, as it was.
    """
    for said in each_once(todo, folder / RECORDS, _as_kept, jobs):
        yield said and Tried(**said)


def _as_kept(task: tuple[str, int, str]) -> dict[str, Any] | None:
    tried = tried_of(task)
    return tried and asdict(tried)


def tried_of(task: tuple[str, int, str]) -> Tried | None:
    """Diagnose a campaign, rule its likeliest suspect out, measure again, and diagnose both together; None where there
    is no suspect, or where the base's own error may go by its name.
    """
    campaign = draw(*task)
    truth = campaign.truth
    with tempfile.TemporaryDirectory(prefix="labrig-bench-", ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        effects, without = model.library(), truth["without"]
        suspect = next(
            (
                c
                for c in considered(campaign.dataset, model, without)
                if effects[c.effect].ruled_out_by and c.by_evidence >= SUSPECTED
            ),
            None,
        )
        if suspect is None or suspect.effect in (truth.get("also") or ()):
            return None
        name, rows = suspect.effect, rows_from([campaign.dataset])
        limits = Limits.of(rows)
        asked = again(prepared(rows, model), effects[name], limits, MINUTES)
        if not asked.tells:
            return None
        runs = [campaign.dataset, _measured(campaign, asked, limits, task[1])]
        after = back = _of(name, considered(runs, model, without))
        if after.call == "possible" and after.gone >= SURE:
            runs.append(_measured(campaign, asked, limits, task[1] + 1, there=True))
            back = _of(name, considered(runs, model, without))
    there = name in truth["effects"]
    said = (after.by_evidence, after.share, after.gone, back.probability)
    return Tried(task[2], name, there, suspect.probability, after.probability, *said)


def _of(name: str, found: "Sequence[Considered]") -> "Considered":
    return next(c for c in found if c.effect == name)


def _measured(
    campaign: Campaign, asked: Again, limits: Limits, seed: int, there: bool = False
) -> "xr.Dataset":
    """The set-points without the suspect, or with it once more if it was `there`, all else as it was: turned and loaded
    as the campaign was, one after the other, each for its share of them.
    """
    plan = Plan(np.random.default_rng(seed), campaign.dataset["chamber_max"].values)
    states = _states(campaign.dataset)
    plan.session_tilt_deg[0], plan.session_payload_kg[0] = states[0]
    for k, (tilt_deg, payload_kg) in enumerate(states):
        if k:
            plan.next_session(_PAUSE_S, True, tilt_deg, payload_kg)
        for point in asked.points[k :: len(states)]:
            plan.capture(limits.actuation(point.share), point.hold_s, 6 if point.hold_s > _LONG_S else 4)
    assert campaign.later is not None
    return campaign.later(plan, seed, () if there else (asked.effect,))


def _states(dataset: "xr.Dataset") -> list[tuple[float, float]]:
    """How a campaign was turned (deg) and loaded (kg), each way once."""
    names = [str(name) for name in dataset["covariate"].values] if "covariates" in dataset else []
    columns = [
        dataset["covariates"].values[:, 0, names.index(name)]
        if name in names
        else np.zeros(dataset.sizes["capture"])
        for name in ("tilt", "payload")
    ]
    return list(dict.fromkeys(zip(*(column.tolist() for column in columns), strict=True)))


def ruled_out_rows(tried: Sequence[Tried]) -> tuple[list[str], list[list[str]]]:
    """A table: of the suspects that were there and of the others, how many were sure before, after, and put back."""
    head = [
        "suspect",
        "was it there",
        "sure before",
        "sure after",
        "sure once it was put back",
        f"not it after (below {POSSIBLE})",
    ]
    count = Counter(t.effect for t in tried)
    groups = [
        ("all", list(tried)),
        *((name, [t for t in tried if t.effect == name]) for name in sorted(count)),
    ]
    rows = []
    for name, own in groups:
        for there in (True, False):
            some = [t for t in own if t.there == there]
            if some:
                rows.append([name, "yes" if there else "no", *(_share(some, test) for test in range(4))])
    return head, rows


def _share(some: Sequence[Tried], test: int) -> str:
    passed = sum((t.before >= SURE, t.after >= SURE, t.back >= SURE, t.after < POSSIBLE)[test] for t in some)
    return share_text(passed, len(some))


def write_ruled_out(tried: Sequence[Tried], path: Path, how: str) -> None:
    """Write the section "A suspect taken away" of the measured results."""
    write_section(path, "## A suspect taken away", [how, "", *markdown(*ruled_out_rows(tried))])
