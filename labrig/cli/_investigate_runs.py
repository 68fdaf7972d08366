"""The runs of an investigation: connected, carried out, and gone on with where one was cut short."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers import Clock, RealClock, SimulatedClock
from labrig.api._procedures import shipped, source_of
from labrig.campaign import Control, Procedure, Watching, dry_run, read_completed, resume, run
from labrig.cli._run_screen import Screen
from labrig.log import read_run_yaml
from labrig.rig import RigConfig, connect

if TYPE_CHECKING:
    from labrig.rig import Rig


@dataclass
class Bench:
    """A rig and the clock of an investigation.

    A rig that is simulated in this process stays connected, so that it is one and the same rig throughout; a
    real one is let go between runs, vented, while the computer thinks.
    """

    config: RigConfig
    rig_file: Path
    realtime: bool = False
    _rig: "Rig | None" = field(default=None, repr=False)

    @property
    def simulated(self) -> bool:
        """Whether every device is simulated in this process."""
        return {d.kind for d in self.config.devices.values() if d is not None} == {"simulated"}

    @contextmanager
    def opened(self) -> Iterator["Bench"]:
        """The bench, its rig vented and let go at the end."""
        if not self.simulated:
            yield self
            return
        with connect(self.config, self._clock()) as self._rig:
            yield self

    def _clock(self) -> Clock:
        return SimulatedClock(RealClock().now_s()) if self.simulated and not self.realtime else RealClock()

    def measure(self, procedure: Procedure, folder: Path, seed: int) -> None:
        """Run a procedure in a folder, or go on with it where it was cut short; raises as `labrig.campaign.run`."""
        if self._rig is not None:
            self._measure(self._rig, procedure, folder, seed)
            return
        with connect(self.config, RealClock(), guard_log=folder / "guard.log") as rig:
            self._measure(rig, procedure, folder, seed)

    def _measure(self, rig: "Rig", procedure: Procedure, folder: Path, seed: int) -> None:
        control = Control()
        with Screen(control) as screen:
            context: dict[str, Any] = {
                "source": source_of(type(procedure)),
                "rig_file": str(self.rig_file.resolve()),
                "realtime": self.realtime,
            }
            watching = Watching([screen], control, context)
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
    """The procedure of a run that has begun, and its seed."""
    facts = read_run_yaml(folder)
    return shipped()[str(facts["procedure"])].model_validate(facts["parameters"]), int(facts["seed"])
