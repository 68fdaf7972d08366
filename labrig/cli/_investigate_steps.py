"""What `labrig investigate` does: measure, diagnose, settle the doubt, improve, and confirm, in a loop."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from drivers import DeviceError
from labrig._errors import LabrigError
from labrig.campaign import Procedure
from labrig.cli._investigate_runs import Bench, complete, procedure_of, started
from labrig.cli._investigate_state import Investigation, Settings, begun, command, print_closing
from labrig.rig import load_rig

if TYPE_CHECKING:
    from labrig.diagnosis import Result
    from labrig.model import Model

NEW_MODEL = "model.new.yaml"
FIRST_SHARE, FEWEST, MOST = 0.4, 14, 60
CONFIRM_SHARE, CONFIRM_FEWEST, CONFIRM_MOST = 0.12, 8, 24
LONGEST_MIN, SHORTEST_MIN = 10.0, 0.75
MOST_ROUNDS = 8
UNKNOWN_ROUNDS = 2
CONFIRMED, MOST_CONFIRMATIONS = 0.8, 2
CLEAR = {"nothing_missing", "identified", "multiple"}


def do_investigate(settings: Settings, resume: bool) -> None:
    """The whole investigation, with what it does printed."""
    from labrig.model import Model

    model, config = Model.load(settings.model), load_rig(settings.rig)
    _check_base(model, settings.model)
    there = settings.out.exists()
    investigation = begun(settings, resume)
    settings = investigation.settings
    bench = Bench(config, settings.rig, settings.realtime)
    console = Console(highlight=False)
    try:
        with bench.opened():
            _loop(investigation, bench, model, console)
    except (KeyboardInterrupt, LabrigError, DeviceError) as error:
        if not any(settings.out.iterdir()):  # nothing was measured
            if not there:
                settings.out.rmdir()
            raise
        what = str(error) or "interrupted"
        investigation.end("interrupted", f"Interrupted: {what}.")
        where = f"{len(investigation.rounds)} rounds are in {settings.out}; go on with: {command(settings)}"
        if not isinstance(error, KeyboardInterrupt):
            raise type(error)(f"{what}; {where}") from error
        typer.echo(f"labrig: {what}; {where}", err=True)
        raise typer.Exit(130) from None
    print_closing(console, investigation)


def _check_base(model: "Model", path: Path) -> None:
    """Raise `LabrigError` for a model whose base could not be evaluated, before anything is measured for it."""
    for field in ("file", "rig"):
        name = getattr(model.file.base, field, None)
        if name is not None and not (model.folder / name).is_file():
            raise LabrigError(f"{path}: base: {field}: there is no file {model.folder / name}")


def _loop(investigation: Investigation, bench: Bench, model: "Model", console: Console) -> None:
    budget = investigation.settings.budget
    confirming = _confirming(investigation, bench)
    reserve = bench.minutes(confirming)
    if investigation.rounds:
        result = _diagnosis(investigation, model)
    else:
        first = _first(investigation, bench, reserve)
        result = _round(investigation, bench, model, console, "capture", first)
    while True:
        verdict, left = result.summary["verdict"], budget - investigation.minutes
        if len(investigation.rounds) >= MOST_ROUNDS:
            return investigation.end("open", f"Not settled after {MOST_ROUNDS} rounds: {_open(result)}.")
        programme = _experiment(investigation, bench, model, result, left - reserve, console)
        if programme is not None:
            result = _round(investigation, bench, model, console, "experiment", programme)
            continue
        if verdict not in CLEAR:
            short = left - reserve < SHORTEST_MIN
            return investigation.end(
                "out of budget" if short else "open",
                f"{'Out of budget' if short else 'Not settled'}: {_open(result)}.",
            )
        if not result.summary["effects"]:
            return investigation.end(
                "settled", "Nothing is missing: the model is as good as the measurements."
            )
        if left < reserve * 0.999:
            return _improved(investigation, model, result, confirmed=None)
        better = _fitted(investigation, model, result)
        if better is None:
            return investigation.end("open", f"Not settled: {_open(result)}; it can't be fitted.")
        confirmed, again = _confirmed(investigation, bench, model, better, confirming, console)
        same = again.summary["effects"] == result.summary["effects"]
        looked = sum(r["programme"] == "confirmation" for r in investigation.rounds)
        over = looked >= MOST_CONFIRMATIONS or budget - investigation.minutes < reserve
        if same and (confirmed or over):
            return _improved(investigation, model, again, confirmed)
        result = again  # another name now, or the same one does not hold


def _first(investigation: Investigation, bench: Bench, reserve: float) -> Procedure:
    """The first campaign, sized to the budget."""
    from procedures import Capture

    settings = investigation.settings
    few = Capture.model_validate({"captures": FEWEST, "highest": settings.highest})
    one = bench.minutes(few, settings.seed) / FEWEST
    captures = int(min(MOST, FIRST_SHARE * (settings.budget - reserve) / one))
    if captures < FEWEST:
        least = (FEWEST * one) / FIRST_SHARE + reserve
        raise LabrigError(
            f"--budget {settings.budget:g} min is too little to begin with; give it {math.ceil(least)} or more"
        )
    return Capture.model_validate({"captures": captures, "highest": settings.highest})


def _confirming(investigation: Investigation, bench: Bench) -> Procedure:
    """A fresh programme: other set-points, another order, longer holds."""
    from procedures import Capture

    settings = investigation.settings

    def of(captures: int) -> Capture:
        fresh = {
            "pattern": "random",
            "repeated": 1,
            "repeats": 2,
            "settle_s": 5.0,
            "highest": settings.highest,
        }
        return Capture.model_validate({"captures": captures, **fresh})

    one = bench.minutes(of(CONFIRM_FEWEST)) / CONFIRM_FEWEST
    return of(int(max(CONFIRM_FEWEST, min(CONFIRM_MOST, CONFIRM_SHARE * settings.budget / one))))


def _experiment(
    investigation: Investigation,
    bench: Bench,
    model: "Model",
    result: "Result",
    left_min: float,
    console: Console,
) -> Procedure | None:
    """The programme that would settle what is open; None where nothing is, or nothing would, or time is short."""
    from labrig.cli._next_steps import checked_plan, limits_of, print_experiment
    from labrig.diagnosis import write_json
    from labrig.experiment import propose_experiment
    from labrig.view import write_experiment
    from procedures import Programme

    summary = result.summary
    before = [r for r in investigation.rounds if r["programme"] == "experiment"]
    if left_min < SHORTEST_MIN:
        return None
    if _doubted(investigation, summary):  # its name does not hold: look where least is known
        summary = {**summary, "verdict": "unknown", "carried_by": None}
    elif summary["verdict"] in CLEAR and any(r["verdict"] in CLEAR for r in before):
        return None  # one look at what is possible beside what is sure is enough
    if summary["verdict"] in {"unknown", "underpowered"} and len(before) >= UNKNOWN_ROUNDS:
        return None
    try:
        experiment = propose_experiment(
            investigation.opened(),
            model,
            summary=summary,
            limits=limits_of(bench.config),
            minutes=min(LONGEST_MIN, left_min - 0.1),
        )
    except LabrigError as error:
        if summary["verdict"] not in CLEAR:
            investigation.warnings.append(str(error))
        return None
    plan = checked_plan(experiment, bench.config)
    folder = investigation.folder / f"next-{len(investigation.rounds)}"
    folder.mkdir(exist_ok=True)
    report = {**experiment.summary, "minutes": plan.duration_s / 60, "rig": bench.config.name}
    write_json(report, folder / "next.json")
    write_experiment(report, experiment.programme(), folder)
    print_experiment(report)
    return Programme.model_validate({"points": experiment.programme()})


def _doubted(investigation: Investigation, summary: Mapping[str, Any]) -> bool:
    """Whether the last round was a confirmation that what is still found did not stand."""
    found = investigation.confirmation
    if found is None or investigation.rounds[-1]["programme"] != "confirmation":
        return False
    return found["drop"] < CONFIRMED and found["effects"] == summary["effects"]


def _round(
    investigation: Investigation,
    bench: Bench,
    model: "Model",
    console: Console,
    what: str,
    procedure: Procedure,
) -> "Result":
    """Measure one programme, diagnose with all runs, and note it down."""
    number = len(investigation.rounds) + 1
    name = f"run-{number}"
    folder = investigation.folder / name
    seed = investigation.settings.seed + number
    if started(folder):  # cut short the last time: the same programme goes on
        procedure, seed = procedure_of(folder)
    minutes = bench.minutes(procedure, seed)
    console.print(f"round {number}: {what}, {minutes:.1f} min on the rig")
    if not complete(folder):
        bench.measure(procedure, folder, seed)
    entry = {
        "round": number,
        "programme": what,
        "run": name,
        "minutes": minutes,
        "captures": _captures(folder),
    }
    investigation.rounds.append(
        {
            **entry,
            "verdict": "",
            "effects": [],
            "rivals": [],
            "probability": None,
            "error": {"model": None, "floor": None},
        }
    )
    result = _diagnosis(investigation, model)
    console.print(f"  {result.summary['verdict']}: {_names(result)}")
    return result


def _captures(folder: Path) -> int:
    from labrig.log import summarise

    return summarise(folder).captures


def _diagnosis(investigation: Investigation, model: "Model") -> "Result":
    """Diagnose all runs, write the report of the last round, and note the verdict down."""
    from labrig.diagnosis import diagnose
    from labrig.view import write_report

    result = diagnose(investigation.opened(), model)
    last = investigation.rounds[-1]
    folder = investigation.folder / f"diagnosis-{last['round']}"
    folder.mkdir(exist_ok=True)
    result.write(folder / "diagnosis.json")
    write_report(result, folder)
    kept = {k: result.summary[k] for k in ("verdict", "effects", "rivals", "probability", "error")}
    last |= {**kept, "report": f"{folder.name}/report.html"}
    investigation.units = result.summary["units"]
    investigation.waterfall = list(result.waterfall)
    investigation.write()
    return result


def _confirmed(
    investigation: Investigation,
    bench: Bench,
    model: "Model",
    fitted: "Result",
    procedure: Procedure,
    console: Console,
) -> "tuple[bool, Result]":
    """Measure a fresh programme, and see whether the error falls there with what was fitted to the runs before."""
    from labrig.diagnosis import compare

    effects, better = fitted.summary["effects"], fitted.improved
    assert better is not None
    again = _round(investigation, bench, model, console, "confirmation", procedure)
    fresh = investigation.opened()[-1]
    before, after = compare(fresh, model).summary["error"], compare(fresh, better).summary["error"]
    floor = max(float(again.summary["error"]["floor"]), 1e-12)
    drop = (before["model"] - after["model"]) / max(before["model"] - floor, 1e-12)
    investigation.confirmation = {
        "effects": effects,
        "before": float(before["model"]),
        "after": float(after["model"]),
        "floor": floor,
        "drop": float(drop),
        "run": investigation.rounds[-1]["run"],
    }
    return bool(drop >= CONFIRMED), again


def _fitted(investigation: Investigation, model: "Model", result: "Result") -> "Result | None":
    """The model with what was found, fitted to all runs; None, with a note that says why, where it can't be."""
    from labrig.diagnosis import improve

    try:
        return improve(investigation.opened(), model, result.summary["effects"], force=True)
    except LabrigError as error:
        investigation.warnings.append(str(error))
        return None


def _improved(investigation: Investigation, model: "Model", result: "Result", confirmed: bool | None) -> None:
    """Write the model with what was found, fitted to all runs."""
    effects = [str(n) for n in result.summary["effects"]]
    better = _fitted(investigation, model, result) if effects else None
    if better is None:
        return investigation.end("open", f"With the fresh captures the verdict is open: {_open(result)}.")
    assert better.improved is not None
    path = investigation.folder / NEW_MODEL
    better.improved.save(path)
    investigation.model = str(path)
    investigation.waterfall = list(better.waterfall)
    names, units = " and ".join(n.replace("_", " ") for n in effects), investigation.units
    found = investigation.confirmation or {}
    if confirmed:
        fell = f"from {found['before']:.3g} to {found['after']:.3g} {units} on captures recorded after the verdict"
        return investigation.end("settled", f"{names.capitalize()}: with it the error falls {fell}.")
    if confirmed is None:
        short = f"{names.capitalize()}, not confirmed on fresh captures: out of budget."
        return investigation.end("out of budget", short)
    fell = f"from {found['before']:.3g} only to {found['after']:.3g} {units}"
    return investigation.end(
        "open", f"{names.capitalize()} is the best name, but on fresh captures the error falls {fell}."
    )


def _open(result: "Result") -> str:
    summary = result.summary
    return f"the verdict is {summary['verdict']} ({_names(result)})"


def _names(result: "Result") -> str:
    summary = result.summary
    names = ", ".join(summary["effects"]) or str(summary.get("carried_by") or "no effect")
    return names + (f", or {', '.join(summary['rivals'])}" if summary["rivals"] else "")
