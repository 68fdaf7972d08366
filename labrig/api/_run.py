"""run: a procedure on a rig, from Python."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import path_of, wrong
from labrig.api._inputs import AnyPath, rig_of

if TYPE_CHECKING:
    from labrig.campaign import Procedure, Progress
    from labrig.live import Settings

DIAGNOSED = "live_diagnosis"
"""Where run.yaml keeps what a live diagnosis was asked for."""


def run(
    procedure: "str | Procedure",
    rig: Any,
    *,
    out: AnyPath | None = None,
    seed: int = 0,
    realtime: bool = False,
    progress: "Callable[[Progress], None] | None" = None,
    diagnose: AnyPath | None = None,
    until: str = "",
    budget: str = "",
    adapt: bool = False,
    resume: bool = False,
    **parameters: Any,
) -> Path:
    """Run a procedure on a rig and log it; returns the run's folder.

    Every limit is checked before anything moves. However the run ends, the chambers are vented, and the vent is
    confirmed by reading, before this returns or raises. A capture whose pressures did not follow is taken again;
    after that the run ends here, where the command line waits for a person.

    Args:
        procedure: the name of one that comes with labrig (capture, check, hold, idle, pairs, programme, repeatability,
            survey, sweep, validate), a file ("my_procedure.py"), or one that is made already.
        rig: a rig.yaml's path, or what `labrig.load_rig` gives.
        out: the run's folder; by default a new one in ./runs.
        seed: of everything that is random.
        realtime: let a rig that is simulated here take as long as a real one.
        progress: called with a `Progress` about twice a second, in a thread of its own. KeyboardInterrupt that is
            raised in it ends the run, as Ctrl-C does; any other error is warned of, and the run goes on without it.
        diagnose: a model.yaml that is questioned beside the campaign every few captures.
        until: ends the campaign by what that says: ``"settled"`` or ``"error=0.2mm"``.
        budget: ends it after so long: ``"45min"``.
        adapt: take the set-points that tell apart what is possible, in place of the procedure's.
        resume: go on with the run in `out` that was interrupted, after its last completed step; procedure, parameters
            and rig are given as they were; parameters that are left out are what they were.
        parameters: the procedure's, by name: `captures=20`.

    Raises:
        LabrigError: a limit would be broken, the procedure or its parameters are wrong, the log cannot be written.
        DeviceError: a device failed, or the rig is no longer safe; it says how the run goes on, if it began.
        KeyboardInterrupt: it was stopped; its message says after what, and how the run goes on.

    Example:
        >>> folder = labrig.run("capture", "rig.yaml", out="runs/night", captures=20)
        >>> labrig.open_run(folder).sizes["capture"]
        20
    """
    from labrig import campaign
    from labrig.api._live import followed
    from labrig.rig import clock_of, connect, in_use, retold
    from labrig_drivers import DeviceError

    config = rig_of(rig)
    if resume and (out is None or not Path(out).is_dir()):
        raise LabrigError("resume: name the folder of the run to go on with: out='runs/night'")
    if out is not None and Path(out).is_file():
        raise LabrigError(f"out: {out} is a file, where a run's folder is needed; choose another name")
    chosen = made(procedure, _as_begun(Path(out), procedure, parameters) if resume and out else parameters)
    folder = Path(out) if out is not None else new_folder(chosen)
    goes_on = resume or not _go_on(folder)  # a run that lies there is another one
    clock = clock_of(config, realtime)
    context: dict[str, Any] = {"rig_file": str(Path(rig).resolve())} if isinstance(rig, str | Path) else {}
    settings = _live(diagnose, until, budget, adapt)
    if settings is not None:
        context[DIAGNOSED] = settings.to_dict()
    with (
        in_use(config, f"run {folder}", folder),
        followed(settings, chosen, config, folder, seed, clock) as adviser,
    ):
        watching = campaign.Watching(context=context, adviser=adviser)
        with connect(config, clock, guard_log=folder / "guard.log") as connected:
            try:
                if resume:
                    return campaign.resume(chosen, connected, folder, progress=progress, watching=watching)
                return campaign.run(
                    chosen, connected, folder, seed=seed, progress=progress, watching=watching
                )
            except campaign.Interrupted as error:
                raise campaign.Interrupted(f"{error}{_go_on(folder)}") from None
            except campaign.NotResumableError:
                raise
            except (LabrigError, DeviceError) as error:
                said = retold(error, f"{error}{_go_on(folder) if goes_on else ''}")
                raise said from (error.__cause__ if said is error else error)


def _as_begun(folder: Path, procedure: "str | Procedure", given: dict[str, Any]) -> dict[str, Any]:
    """The parameters that are given of a run's procedure, and those that it was begun with."""
    from labrig._yaml import read_yaml
    from labrig.api._procedures import find_procedure

    written = folder / "run.yaml"
    if not isinstance(procedure, str | Path) or not written.is_file():
        return given
    facts, kind = read_yaml(written, "run", begins="procedure: ..."), find_procedure(str(procedure))
    begun = facts.get("parameters")
    if facts.get("procedure") != kind.procedure_name() or not isinstance(begun, dict):
        return given
    if gone := sorted(set(begun) - set(kind.model_fields)):
        raise LabrigError(
            f"cannot resume {folder}: it was begun with {gone[0]}, which procedure {procedure} does not have now; "
            "start a new run"
        )
    return {**begun, **given}


def _go_on(folder: Path) -> str:
    """How a run goes on that was interrupted, if something of it is done."""
    from labrig.log import summarise

    try:
        known = summarise(folder)
    except LabrigError:
        return ""
    left = known.steps_done and known.state != "completed"
    return (
        f"; labrig.run with resume=True, out={str(folder)!r} and the same arguments goes on" if left else ""
    )


def _live(model: AnyPath | None, until: str, budget: str, adapt: bool) -> "Settings | None":
    """What a live diagnosis is asked for; None without a model."""
    from labrig.live import Settings

    if model is None:
        if until or budget or adapt:
            raise LabrigError("until, budget and adapt need a model to question: diagnose='model.yaml'")
        return None
    path = path_of(model, "a model", "a model.yaml's path")
    return Settings(str(path.resolve()), until=until, budget=budget, adapt=adapt)


def made(given: "str | Procedure", parameters: dict[str, Any]) -> "Procedure":
    """A procedure that is named, or made already, with its parameters; raises `LabrigError` where one is wrong."""
    from labrig._fields import check_fields
    from labrig.api._procedures import find_procedure
    from labrig.campaign import Procedure

    if isinstance(given, Procedure):
        if parameters:
            raise LabrigError(
                f"{next(iter(parameters))}: a procedure that is made already takes no parameters"
            )
        return given
    if not isinstance(given, str | Path):
        raise wrong("a procedure", given, "its name, such as capture, a file, or one that is made already")
    kind = find_procedure(str(given))
    return check_fields(kind, parameters, f"procedure {given}")


def new_folder(procedure: "Procedure", runs: Path = Path("runs")) -> Path:
    """runs/20261120-031259-capture, or with a number behind it where that exists."""
    base = runs / f"{datetime.now():%Y%m%d-%H%M%S}-{procedure.procedure_name()}"
    folder, number = base, 1
    while folder.exists():
        number += 1
        folder = base.with_name(f"{base.name}-{number}")
    return folder
