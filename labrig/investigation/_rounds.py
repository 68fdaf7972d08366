"""A round: a programme is measured, and all runs are diagnosed; what is found is fitted, and checked on fresh ones."""

from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig.campaign import Actuate, Plan, Procedure, dry_run
from labrig.investigation._bench import complete, procedure_of, started
from labrig.investigation._programmes import CONFIRMED, names_left
from labrig.investigation._work import Work

if TYPE_CHECKING:
    from labrig.diagnosis import Result

_ROUNDED_KPA = 1e-3
"""To this procedures round set-points."""


def given_round(work: Work) -> "Result":
    """The first round where runs are given: nothing is measured, and they are diagnosed."""
    from labrig.log import read_notes, summarise

    runs = work.state.settings.runs
    work.reporter.round_started(1, "given", 0.0)
    captures = sum(summarise(run).captures for run in runs)
    work.state.doing("diagnosing", "given", runs[0].as_posix(), 0.0, captures)
    _note(work, "given", runs[0].name, 0.0, captures)
    work.state.rounds[-1]["given"] = [run.as_posix() for run in runs]
    for run in runs:
        if run.is_dir() and (without := read_notes(run).ruled_out_in_words):
            work.state.warnings.append(
                f"{run.as_posix()} was measured without {without}, and what is measured here counts as with it: put it "
                "back before"
            )
    return diagnosed(work)


def measured_round(work: Work, programme: str, procedure: Procedure) -> "Result":
    """Measure one programme, diagnose with all runs, and note it down."""
    from labrig.log import summarise

    state = work.state
    number = len(state.rounds) + 1
    name = f"run-{number}"
    folder = state.folder / name
    seed = state.settings.seed + number
    if started(folder):  # cut short the last time: the same programme goes on
        procedure, seed = procedure_of(folder)
    plan, whole = dry_run(procedure, work.bench.config, seed), complete(folder)
    if not whole:
        _check_highest(plan, work)
    minutes = plan.duration_s / 60
    work.reporter.round_started(number, programme, minutes)
    state.doing("measuring", programme, name, minutes, plan.captures)
    if not whole:
        with work.reporter.watching() as watching:
            work.bench.measure(procedure, folder, seed, watching)
    captures = summarise(folder).captures
    state.doing("diagnosing", programme, name, minutes, captures + sum(r["captures"] for r in state.rounds))
    _note(work, programme, name, minutes, captures)
    return diagnosed(work)


def _check_highest(plan: Plan, work: Work) -> None:
    """Raise `LabrigError` for a set-point that is farther from vented than the settings allow."""
    from labrig.experiment import limits_of

    allowed = limits_of(work.bench.config).up_to(work.state.settings.highest)
    for step in plan.steps:
        if not isinstance(step, Actuate):
            continue
        kept = np.clip(step.pressure_kpa, allowed.low, allowed.high)
        if (over := np.flatnonzero(np.abs(kept - step.pressure_kpa) > _ROUNDED_KPA)).size:
            c = int(over[0])
            raise LabrigError(
                f"nothing was moved: the programme goes to {step.pressure_kpa[c]:g} kPa in "
                f"{work.bench.config.chambers[c].name}, and {kept[c]:g} kPa is allowed there "
                f"(highest {work.state.settings.highest:g})"
            )


def _note(work: Work, programme: str, run: str, minutes: float, captures: int) -> None:
    work.state.rounds.append(
        {
            "round": len(work.state.rounds) + 1,
            "programme": programme,
            "run": run,
            "minutes": minutes,
            "captures": captures,
            "verdict": "",
            "effects": [],
            "rivals": [],
            "probability": None,
            "error": {"model": None, "floor": None},
        }
    )


def diagnosed(work: Work) -> "Result":
    """Diagnose all runs, write the report of the last round, and note the verdict down."""
    from labrig.diagnosis import diagnose
    from labrig.view import write_report

    state = work.state
    last = state.rounds[-1]
    work.reporter.diagnosing(last["round"], sum(r["captures"] for r in state.rounds))
    result = diagnose(state.opened(), work.model)
    folder = state.folder / f"diagnosis-{last['round']}"
    folder.mkdir(exist_ok=True)
    result.write(folder / "diagnosis.json")
    write_report(result, folder)
    summary = result.summary
    last["verdict"], last["probability"] = summary["verdict"], summary["probability"]
    last["effects"], last["rivals"] = summary["effects"], summary["rivals"]
    last["error"], last["report"] = summary["error"], f"{folder.name}/report.html"
    state.units = result.summary["units"]
    state.waterfall = list(result.waterfall)
    state.write()
    work.reporter.diagnosed(last["round"], result.summary)
    return result


def confirmed(work: Work, found: "Result", procedure: Procedure) -> "tuple[bool, Result]":
    """Measure a fresh programme, and see whether the error falls there with what was fitted to the runs before."""
    from labrig.diagnosis import compare

    state, better = work.state, found.improved
    assert better is not None
    again = measured_round(work, "confirmation", procedure)
    runs = state.opened()
    before, after = (compare(runs, model, only_last=True).summary["error"] for model in (work.model, better))
    floor = max(float(again.summary["error"]["floor"]), 1e-12)
    above = before["model"] - floor  # not above it: these captures show nothing that could fall
    drop = (before["model"] - after["model"]) / above if above > 0 else 0.0
    state.confirmation = {
        "effects": found.summary["effects"],
        "before": float(before["model"]),
        "after": float(after["model"]),
        "floor": floor,
        "drop": float(drop),
        "run": state.rounds[-1]["run"],
    }
    return bool(drop >= CONFIRMED), again


def fitted(work: Work, result: "Result") -> "Result | None":
    """The model with what was found, fitted to all runs; None, with a note that says why, where it can't be."""
    from labrig.diagnosis import improve

    work.state.doing("fitting", "")
    try:
        return improve(work.state.opened(), work.model, names_left(result.summary), force=True)
    except LabrigError as error:
        work.state.warnings.append(str(error))
        return None
