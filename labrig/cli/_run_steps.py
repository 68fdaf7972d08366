"""What `labrig run` does: connect, run or resume, and say in one line how it ended."""

import math
import re
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from labrig._errors import LabrigError
from labrig._fields import check_fields
from labrig._text import counted
from labrig._yaml import read_yaml
from labrig.api._procedures import find_procedure, read_procedure, source_of
from labrig.api._run import DIAGNOSED, new_folder
from labrig.campaign import (
    Adviser,
    Control,
    Interrupted,
    NotResumableError,
    Observer,
    Procedure,
    Reachable,
    Tally,
    Watching,
    check_written,
    read_completed,
)
from labrig.campaign import dry_run as plan_of
from labrig.campaign import resume as resume_run
from labrig.campaign import run as run_procedure
from labrig.cli._complaints import StoppedError
from labrig.cli._history_steps import say_if_changed
from labrig.cli._lost import markers_lost
from labrig.cli._places import check_folder
from labrig.cli._run_screen import Screen, duration_text
from labrig.log import RunSummary, goes_on, summarise
from labrig.rig import RigConfig, check_unattended, clock_of, connect, in_use, load_rig, retold
from labrig_drivers import Clock, DeviceError

if TYPE_CHECKING:
    from labrig.campaign import Plan
    from labrig.live import Settings

_SHOWN_STEPS = 12
"""What run.yaml calls the settings of a live diagnosis."""


@dataclass(frozen=True)
class Request:
    """The options of `labrig run`."""

    rig: Path | None
    out: Path | None
    seed: int
    realtime: bool
    live: bool
    serve: bool
    model: Path | None = None
    unattended: bool = False
    attended: bool = False
    follow: "Settings | None" = None
    command: str = "labrig run"
    """What goes on with the run, with --resume."""


def do_dry_run(name: str, arguments: list[str], request: Request) -> None:
    """Print the plan; exit code 2 if it would break limits."""
    procedure = read_procedure(name, arguments)
    config = load_rig(_named(request.rig))
    plan = plan_of(procedure, config, request.seed)
    print_plan(plan, config)
    if plan.broken:
        limits = counted(len(by_limit(plan.broken)), "limit")
        raise LabrigError(f"{limits} would be broken; nothing was moved")


def print_plan(plan: "Plan", config: RigConfig) -> None:
    """The steps with their times, the estimate, and every limit that would be broken."""
    shown = range(len(plan.steps))
    for index in shown:
        if _SHOWN_STEPS <= index < len(plan.steps) - 3:
            if index == _SHOWN_STEPS:
                typer.echo(f"    ... {len(plan.steps) - _SHOWN_STEPS - 3} more steps ...")
            continue
        typer.echo(f"{plan.start_s[index]:9.1f} s  {index:5d}  {_step_text(plan.steps[index].to_dict())}")
    typer.echo(
        f"{counted(len(plan.steps), 'step')}, {counted(plan.captures, 'capture')} on rig {config.name}: "
        f"{duration_text(plan.duration_s)}"
    )
    if plan.stopped is not None:
        typer.echo(f"what follows depends on measurements: {plan.stopped}")
    for first, *others in by_limit(plan.broken):
        more = f", and so {counted(len(others), 'step')} more" if others else ""
        typer.echo(f"breaks a limit: {first}{more}")
    if plan.may_refuse:
        typer.echo(f"the controller may refuse this, which it tells by its dialect: {plan.may_refuse}")


def by_limit(broken: list[str]) -> list[list[str]]:
    """What breaks a limit, as a plan says it, the lines on each limit of each chamber together, in their order."""
    limits: dict[str, list[str]] = {}
    for line in broken:
        limits.setdefault(re.sub(r"^step \d+ |\S+(?= kPa is )", "", line), []).append(line)
    return list(limits.values())


def _step_text(fields: dict[str, object]) -> str:
    kind = str(fields.pop("kind"))
    values = []
    for name, value in fields.items():
        if value in ("", None):
            continue
        text = (
            "[" + " ".join(f"{item:g}" for item in value) + "] kPa"
            if isinstance(value, tuple)
            else str(value)
        )
        values.append(text if isinstance(value, tuple) else f"{name} {text}")
    return f"{kind:8s} {', '.join(values)}".rstrip()


def do_run(name: str, arguments: list[str], request: Request) -> None:
    """Run a procedure in a new folder."""
    procedure = read_procedure(name, arguments)
    rig_file = _named(request.rig)
    config = load_rig(rig_file)
    folder = request.out or new_folder(procedure)
    compared = request.model or (Path(request.follow.model) if request.follow else None)
    if compared is not None:
        say_if_changed(config.name, compared, folder.parent)
    _check_new(folder, request)
    context: dict[str, object] = {
        "source": source_of(type(procedure)),
        "rig_file": str(rig_file.resolve()),
        "realtime": request.realtime,
    }
    if request.follow is not None:
        context[DIAGNOSED] = request.follow.to_dict()
    new = not folder.exists()
    try:
        _go(procedure, config, folder, request, context)
    finally:
        if new and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()  # it was refused before anything was measured


def _check_new(folder: Path, request: Request) -> None:
    """Raise `LabrigError` for a folder that can't be made, or that holds a run, with what to do with that one."""
    check_folder(folder)
    if not folder.is_dir() or (known := _known(folder)) is None:
        return
    _refuse_finished(folder, known)
    raise LabrigError(
        f"{folder} holds a run already ({known.state}){_go_on(folder, request)}, or choose another --out"
    )


def _refuse_finished(folder: Path, known: RunSummary) -> None:
    """Raise `LabrigError` for a run of which no step is left, with what can be done with it."""
    if _is_finished(known):
        if known.missed and not known.captures:
            raise LabrigError(
                f"{folder} is finished, and none of its captures counts, since the pressures did not follow; measure "
                "again into another --out"
            )
        raise LabrigError(
            f"{folder} is finished: all its {known.captures} captures are there; compare a model with them "
            f"(labrig compare {folder} --model MODEL.yaml), or measure again into another --out"
        )


def _is_finished(known: RunSummary) -> bool:
    facts = known.run
    open_end = facts.get("closed_loop") or DIAGNOSED in facts
    done = not open_end and known.steps_done >= facts.get("steps", math.inf)
    return bool(done or known.state == "completed")


def do_resume(folder: Path, request: Request) -> None:
    """Go on with a run; procedure, parameters and rig are those that run.yaml names."""
    if not folder.is_dir():
        raise LabrigError(f"{folder} is no run folder; `labrig runs` lists those in ./runs")
    if known := _known(folder):
        _refuse_finished(folder, known)
    written = folder / "run.yaml"
    facts = read_yaml(written, "run", begins="procedure: ...") if written.exists() else {}
    if "source" not in facts or "rig_file" not in facts:
        if "procedure" in facts:
            raise LabrigError(f"{folder} was begun from Python: {goes_on(folder, facts)} goes on with it")
        raise LabrigError(f"{folder} cannot be resumed: it has no run.yaml of `labrig run`")
    check_written(folder, facts)
    parameters = {} if facts.get("parameters") is None else facts["parameters"]
    procedure = check_fields(find_procedure(str(facts["source"])), parameters, f"{written}: parameters")
    config = load_rig(request.rig or Path(str(facts["rig_file"])))
    request = replace(
        request, out=folder, seed=int(facts.get("seed", 0)), realtime=bool(facts.get("realtime"))
    )
    if DIAGNOSED in facts:
        from labrig.live import Settings

        request = replace(request, follow=Settings.from_dict(facts[DIAGNOSED], str(folder)))
    _go(procedure, config, folder, request, None)


def _go(
    procedure: Procedure,
    config: RigConfig,
    folder: Path,
    request: Request,
    context: dict[str, object] | None,
) -> None:
    """Connect, run (or resume, if there is no context), and report; then a live diagnosis draws its last picture.

    Raises `DeviceError` where captures were taken and none of them counts: a script of many runs must notice.
    """
    from labrig.api._live import followed

    clock = clock_of(config, request.realtime)
    with (
        in_use(config, f"run {folder}", folder),
        followed(request.follow, procedure, config, folder, request.seed, clock) as adviser,
    ):
        _run_it(procedure, config, folder, request, context, clock, adviser)
        summary = summarise(folder)
        typer.echo(
            f"{folder}: {counted(summary.captures, 'capture')} in {duration_text(summary.duration_s)}, vented"
        )
        for line in markers_lost(folder):
            typer.echo(f"labrig: {line}", err=True)
        if not summary.captures and (tally := Tally.of(read_completed(folder))).none_kept:
            raise DeviceError(f"{folder}: no capture counts; {tally}")


def _run_it(
    procedure: Procedure,
    config: RigConfig,
    folder: Path,
    request: Request,
    context: dict[str, object] | None,
    clock: Clock,
    adviser: Adviser | None,
) -> None:
    control = Control(attended=request.attended or (not request.unattended and sys.stdin.isatty()))
    with Screen(control) as screen, Reachable(procedure, config, folder, clock, control) as reachable:
        observers: list[Observer] = [screen, reachable, *_viewers(request, config)]
        watching = Watching(observers, control, dict(context or {}), adviser)
        guard_log = folder / "guard.log"
        try:
            with connect(config, clock, guard_log=guard_log) as rig:
                if request.unattended:
                    what = check_unattended(rig)
                    typer.echo(f"labrig: unattended: {what}", err=True)
                if context is None:
                    resume_run(procedure, rig, folder, watching=watching)
                else:
                    run_procedure(procedure, rig, folder, seed=request.seed, watching=watching)
        except Interrupted as error:
            raise StoppedError(f"{error}{_go_on(folder, request)}") from None
        except KeyboardInterrupt as error:
            if isinstance(
                first := error.__context__, Interrupted
            ):  # once more, when the run had ended, vented
                raise StoppedError(f"{first}{_go_on(folder, request)}") from None
            raise
        except NotResumableError:
            raise
        except (LabrigError, DeviceError) as error:
            said = retold(error, f"{error}{_go_on(folder, request)}")
            raise said from (error.__cause__ if said is error else error)


def _go_on(folder: Path, request: Request) -> str:
    """The command to resume a run, if something of it is done, and something left."""
    known = _known(folder)
    left = known is not None and known.steps_done and not _is_finished(known)
    return f"; to resume: {request.command} --resume {folder}" if left else ""


def _known(folder: Path) -> RunSummary | None:
    """What a folder holds; None where that is no run."""
    try:
        return summarise(folder)
    except LabrigError:
        return None


def _viewers(request: Request, config: RigConfig) -> list[Observer]:
    if not (request.live or request.serve):
        return []
    from labrig.view import live_observers, live_predict

    predict = None if request.model is None else live_predict(request.model, config.markers)
    return live_observers(
        request.live, request.serve, lambda line: typer.echo(f"labrig: {line}", err=True), predict
    )


def _named(rig: Path | None) -> Path:
    if rig is None:
        raise LabrigError("name the rig with --rig RIG.yaml")
    return rig
