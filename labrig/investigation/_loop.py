"""The loop: measure, diagnose, settle the doubt, improve, and confirm, until settled or out of time."""

import hashlib
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from labrig._errors import LabrigError
from labrig._text import chance, counted
from labrig.investigation._bench import Bench
from labrig.investigation._endable import Endable
from labrig.investigation._programmes import (
    SHORTEST_MIN,
    experiment,
    first_campaign,
    fresh_programme,
    is_clear,
    names_left,
)
from labrig.investigation._reporter import Reporter, names_in
from labrig.investigation._rounds import confirmed, diagnosed, fitted, given_round, measured_round
from labrig.investigation._state import Settings, State, start_or_resume
from labrig.investigation._work import Work
from labrig.rig import in_use
from labrig_drivers import DeviceError

if TYPE_CHECKING:
    from labrig.diagnosis import Result
    from labrig.model import Model
    from labrig.rig import RigConfig

NEW_MODEL = "model.new.yaml"
MOST_ROUNDS, MOST_CONFIRMATIONS = 8, 2


def investigate(
    settings: Settings,
    config: "RigConfig",
    model: "Model",
    *,
    resume: bool = False,
    reporter: Reporter | None = None,
) -> State:
    """The whole investigation in the folder `settings.out`; returns what is known in the end.

    Args:
        settings: what is asked for.
        config: the rig.
        model: the model that is questioned; it stays as it is.
        resume: go on with what the folder holds.
        reporter: who is told what happens.

    Raises:
        LabrigError: the folder is not empty or not to be gone on with, another process uses it or the rig, the model
            cannot be evaluated, the budget is too small, a run or a diagnosis failed.
        DeviceError: a device failed; the chambers are vented.
        KeyboardInterrupt: somebody ended it; the chambers are vented. As after any other error, what is known by then
            is kept, and the message says how to go on; a folder in which nothing was measured is removed again.
    """
    from labrig.model import check_base, model_text

    reporter = reporter or Reporter()
    text = model_text(model.file).encode()
    settings = replace(settings, model_sha256=hashlib.sha256(text).hexdigest())
    check_base(model, settings.model)
    with (
        in_use(config, f"investigation {settings.out}", settings.out),
        Endable(config, settings.out) as endable,
    ):
        bench = Bench(config, settings.rig_file, settings.realtime, endable)
        return _investigated(settings, bench, model, resume, reporter)


def _investigated(
    settings: Settings, bench: Bench, model: "Model", resume: bool, reporter: Reporter
) -> State:
    there = settings.out.exists()
    state = start_or_resume(settings, resume)
    work = Work(state, bench, model, reporter)
    try:
        with bench.opened():
            _loop(work)
    except (KeyboardInterrupt, LabrigError, DeviceError) as error:
        if state.discard(keep_folder=there):
            raise
        what = str(error) or "interrupted"
        with suppress(LabrigError, OSError):  # a disk that is full: how to go on is said all the same
            state.end("interrupted", f"Interrupted: {what}.")
        kind = KeyboardInterrupt if isinstance(error, KeyboardInterrupt) else type(error)
        raise kind(
            f"{what}; {_rounds_in(settings, state)}; to resume: {reporter.how_to_resume(settings)}"
        ) from error
    return state


def _loop(work: Work) -> None:
    state, budget_min = work.state, work.state.settings.budget_min
    fresh = fresh_programme(work)
    reserve_min = work.bench.minutes(fresh)
    result = _first(work, reserve_min)
    while True:
        work.check()
        left_min = budget_min - state.minutes
        if len(state.rounds) >= MOST_ROUNDS:
            return state.end("open", f"Not settled after {MOST_ROUNDS} rounds: {_open(result)}.")
        state.doing("planning", "experiment")
        programme = experiment(work, result, left_min - reserve_min)
        if programme is not None:
            result = measured_round(work, "experiment", programme)
            continue
        names = names_left(result.summary)
        if not is_clear(result.summary):
            short = left_min - reserve_min < SHORTEST_MIN
            return state.end(
                "out of budget" if short else "open",
                f"{'Out of budget' if short else 'Not settled'}: {_open(result)}.{_to_be_sure(work, result)}",
            )
        if not names:
            return state.end("settled", "Nothing is missing: the model is as good as the measurements.")
        if left_min < reserve_min * 0.999:
            return _improved(work, result, held=None)
        better = fitted(work, result)
        if better is None:
            return state.end("open", f"Not settled: {_open(result)}; it can't be fitted.")
        held, again = confirmed(work, better, fresh)
        same = set(names_left(again.summary)) == set(names)  # the likeliest comes first, which may change
        looked = sum(r["programme"] == "confirmation" for r in state.rounds)
        over = looked >= MOST_CONFIRMATIONS or budget_min - state.minutes < reserve_min
        if same and (held or over):
            return _improved(work, again, held)
        result = again  # another name now, or the same one does not hold


def _first(work: Work, reserve_min: float) -> "Result":
    """What is known to begin with: of the rounds so far, of runs that were given, or of a first campaign."""
    if work.state.rounds:
        return diagnosed(work)
    if work.state.settings.runs:
        return given_round(work)
    return measured_round(work, "capture", first_campaign(work, reserve_min))


def _improved(work: Work, result: "Result", held: bool | None) -> None:
    """Write the model with what was found, fitted to all runs."""
    state = work.state
    effects = names_left(result.summary)
    better = fitted(work, result) if effects else None
    if better is None:
        return state.end("open", f"With the fresh captures the verdict is open: {_open(result)}.")
    assert better.improved is not None
    path = state.folder / NEW_MODEL
    better.improved.save(path)
    state.model = str(path)
    state.waterfall = list(better.waterfall)
    names, units = " and ".join(n.replace("_", " ") for n in effects), state.units
    found = state.confirmation or {}
    if held:
        fell = f"from {found['before']:.3g} to {found['after']:.3g} {units} on captures recorded after the verdict"
        if not result.summary["effects"]:
            perhaps = f"{chance(result.summary['probability'])}, or an effect that labrig does not know"
            sure = _to_be_sure(work, result)
            return state.end("open", f"Perhaps {names} ({perhaps}): with it the error falls {fell}.{sure}")
        return state.end("settled", f"{names.capitalize()}: with it the error falls {fell}.")
    if held is None:
        return state.end(
            "out of budget", f"{names.capitalize()}, not confirmed on fresh captures: out of budget."
        )
    fell = f"from {found['before']:.3g} only to {found['after']:.3g} {units}"
    said = f"{names.capitalize()} is the best name, but on fresh captures the error falls {fell}."
    return state.end("open", said + _to_be_sure(work, result))


def _to_be_sure(work: Work, result: "Result") -> str:
    """What somebody can do to be sure of the first possible name that can be ruled out; empty where nobody can."""
    library, names = work.model.library(), result.summary["rivals"]
    how = next((library[n].ruled_out_by for n in names if n in library and library[n].ruled_out_by), "")
    return f" To be sure: {how}, and measure again (labrig next with all these runs)." if how else ""


def _rounds_in(settings: Settings, state: State) -> str:
    """`2 rounds are in investigation`."""
    count = len(state.rounds)
    return f"{counted(count, 'round')} {'is' if count == 1 else 'are'} in {settings.out}"


def _open(result: "Result") -> str:
    return f"the verdict is {result.summary['verdict']} ({names_in(result.summary)})"
