"""The runs of an investigation: carried out on one rig, and gone on with where one was cut short."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.campaign import Procedure, Reachable, Watching, dry_run, read_completed, resume, run
from labrig.investigation._endable import Endable
from labrig.log import read_run_yaml
from labrig.rig import RigConfig, clock_of, connect, is_simulated
from labrig_drivers import RealClock

if TYPE_CHECKING:
    from labrig.rig import Rig


@dataclass
class Bench:
    """A rig and the clock of an investigation; `rig_file` is noted in each run.

    A rig that is simulated in this process stays connected, so that it is one and the same rig throughout; a
    real one is let go between runs, vented, while the computer thinks. `endable` hears who asks for the end. Others
    see how its runs stand, pause and end them, as those of `labrig run`.
    """

    config: RigConfig
    rig_file: Path | None = None
    realtime: bool = False
    endable: Endable | None = None
    _rig: "Rig | None" = field(default=None, repr=False)

    @contextlib.contextmanager
    def opened(self) -> Iterator["Bench"]:
        """The bench, its rig vented and let go at the end."""
        if not is_simulated(self.config):
            yield self
            return
        with connect(self.config, clock_of(self.config, self.realtime)) as self._rig:
            yield self

    def measure(self, procedure: Procedure, folder: Path, seed: int, watching: Watching) -> None:
        """Run a procedure in a folder, or go on with it where it was cut short; raises as `labrig.campaign.run`.

        Raises `labrig.campaign.Interrupted`, before anything moves, where somebody asked for the end by now.
        """
        asked = contextlib.nullcontext() if self.endable is None else self.endable.measuring(watching.control)
        clock = RealClock() if self._rig is None else self._rig.clock
        with asked, Reachable(procedure, self.config, folder, clock, watching.control) as reachable:
            watching.observers = [*watching.observers, reachable]
            if self._rig is not None:
                self._measure(self._rig, procedure, folder, seed, watching)
                return
            with connect(self.config, clock, guard_log=folder / "guard.log") as rig:
                self._measure(rig, procedure, folder, seed, watching)

    def _measure(self, rig: "Rig", procedure: Procedure, folder: Path, seed: int, watching: Watching) -> None:
        context: dict[str, Any] = {"source": procedure.procedure_name(), "realtime": self.realtime}
        if self.rig_file is not None:
            context["rig_file"] = str(self.rig_file.resolve())
        watching.context |= context
        _make_way(folder)
        if started(folder):
            resume(procedure, rig, folder, watching=watching)
        else:
            run(procedure, rig, folder, seed=seed, watching=watching)

    def minutes(self, procedure: Procedure, seed: int = 0) -> float:
        """How long a procedure takes, by a dry run, min."""
        return dry_run(procedure, self.config, seed).duration_s / 60


def _make_way(folder: Path) -> None:
    """Put a run that ended before its first step aside, under a name of its own; nothing of it can be gone on with."""
    if not (folder / "log.000.mcap").exists() or started(folder):
        return
    for number in range(1, 1000):
        aside = folder.with_name(f"{folder.name}-not-begun-{number}")
        if not aside.exists():
            folder.rename(aside)
            return


def started(folder: Path) -> bool:
    """Whether a run has begun in a folder, and has a step to go on from."""
    return (folder / "log.000.mcap").exists() and bool(read_completed(folder))


def complete(folder: Path) -> bool:
    """Whether a run went to its end."""
    facts = read_run_yaml(folder) if (folder / "run.yaml").exists() else {}
    return bool(facts) and started(folder) and len(read_completed(folder)) >= int(facts["steps"])


def procedure_of(folder: Path) -> tuple[Procedure, int]:
    """The procedure of a run that has begun, one of those that an investigation runs, and its seed."""
    from labrig_procedures import Capture, Programme

    facts = read_run_yaml(folder)
    kind = {each.procedure_name(): each for each in (Capture, Programme)}[str(facts["procedure"])]
    return kind.model_validate(facts["parameters"]), int(facts["seed"])
