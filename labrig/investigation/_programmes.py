"""What an investigation measures: a first campaign, experiments that settle a doubt, and a fresh programme."""

import math
from typing import TYPE_CHECKING

from labrig._errors import LabrigError
from labrig.campaign import Procedure
from labrig.contents import Summary
from labrig.investigation._work import Work
from labrig.investigation_contents import Round

if TYPE_CHECKING:
    from labrig.diagnosis import Result

FIRST_SHARE, FEWEST, MOST = 0.4, 14, 60
CONFIRM_SHARE, CONFIRM_FEWEST, CONFIRM_MOST = 0.12, 8, 24
LONGEST_MIN, SHORTEST_MIN = 10.0, 0.75
UNKNOWN_ROUNDS = 2
CONFIRMED = 0.8
"""The share of what is above the floor that must go on fresh captures, for a name to hold."""
CLEAR = {"nothing_missing", "identified", "multiple"}


def names_left(said: Summary | Round) -> list[str]:
    """What the model can be improved with: what is sure, or the only name that the evidence leaves.

    Whether that one is there, or a law that labrig does not know, no experiment tells.
    """
    only = said["verdict"] == "confounded" and not said["effects"] and len(said["rivals"]) == 1
    return [str(name) for name in (said["rivals"] if only else said["effects"])]


def is_clear(said: Summary | Round) -> bool:
    """Whether no names are left to tell apart."""
    return said["verdict"] in CLEAR or (not said["effects"] and bool(names_left(said)))


def first_campaign(work: Work, reserve_min: float) -> Procedure:
    """The first campaign, sized to the budget less what is kept; raises `LabrigError` where that is too little."""
    from labrig_procedures import Capture

    settings = work.state.settings
    few = Capture.model_validate({"captures": FEWEST, "highest": settings.highest})
    one = work.bench.minutes(few, settings.seed) / FEWEST
    captures = int(min(MOST, FIRST_SHARE * (settings.budget_min - reserve_min) / one))
    if captures < FEWEST:
        least = (FEWEST * one) / FIRST_SHARE + reserve_min
        raise LabrigError(
            f"a budget of {settings.budget_min:g} min is too little to begin with; give it {math.ceil(least)} or more"
        )
    return Capture.model_validate({"captures": captures, "highest": settings.highest})


def fresh_programme(work: Work) -> Procedure:
    """What confirms a name: other set-points, another order, longer holds."""
    from labrig_procedures import Capture

    settings = work.state.settings

    def of(captures: int) -> Capture:
        fresh = {
            "pattern": "random",
            "repeated": 1,
            "repeats": 2,
            "settle_s": 5.0,
            "highest": settings.highest,
        }
        return Capture.model_validate({"captures": captures, **fresh})

    one = work.bench.minutes(of(CONFIRM_FEWEST)) / CONFIRM_FEWEST
    return of(int(max(CONFIRM_FEWEST, min(CONFIRM_MOST, CONFIRM_SHARE * settings.budget_min / one))))


def experiment(work: Work, result: "Result", left_min: float) -> Procedure | None:
    """The programme that would settle what is open; None where nothing is, nothing would, time is short,
    or somebody has to rule an effect out first.
    """
    from labrig._json import write_json
    from labrig.experiment import limits_of, on_rig, propose_experiment
    from labrig.view import write_experiment
    from labrig_procedures import Programme

    state, config = work.state, work.bench.config
    summary = _asked(work, result.summary)
    if left_min < SHORTEST_MIN or summary is None:
        return None
    try:
        found = propose_experiment(
            state.opened(),
            work.model,
            summary=summary,
            limits=limits_of(config).up_to(state.settings.highest),
            minutes=min(LONGEST_MIN, left_min - 0.1),
        )
    except LabrigError as error:
        if not is_clear(summary):
            state.warnings.append(str(error))
        return None
    if found.attended:
        return None
    found = on_rig(found, config)
    folder = state.folder / f"next-{len(state.rounds)}"
    folder.mkdir(exist_ok=True)
    write_json(dict(found.summary), folder / "next.json")
    write_experiment(found.summary, found.programme(), folder)
    work.reporter.proposed(found.summary)
    return Programme.model_validate({"points": found.programme()})


def _asked(work: Work, summary: Summary) -> Summary | None:
    """The diagnosis that the next programme is to settle; None where one more would be of no use."""
    before = [r for r in work.state.rounds if r["programme"] == "experiment"]
    if _doubted(work, summary):  # its name does not hold: look where least is known
        summary = {**summary, "verdict": "unknown", "carried_by": None}
    elif is_clear(summary) and any(is_clear(r) for r in before):
        return None  # one look at what is possible beside what is sure is enough
    if summary["verdict"] in {"unknown", "underpowered"} and len(before) >= UNKNOWN_ROUNDS:
        return None
    return summary


def _doubted(work: Work, summary: Summary) -> bool:
    """Whether the last round was a confirmation that what is still found did not stand."""
    found = work.state.confirmation
    if found is None or work.state.rounds[-1]["programme"] != "confirmation":
        return False
    return found["drop"] < CONFIRMED and set(found["effects"]) == set(names_left(summary))
