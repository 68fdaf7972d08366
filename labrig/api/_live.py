"""A diagnosis beside a campaign: its process, which draws as well, for as long as the campaign takes.

python -m labrig.api._live RUN MODEL is that process.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._errors import LabrigError

if TYPE_CHECKING:
    from labrig.campaign import Procedure
    from labrig.live import LiveDiagnosis, Settings
    from labrig.rig import RigConfig
    from labrig_drivers import Clock

_UNKNOWN = 10**9


@contextmanager
def followed(
    settings: "Settings | None",
    procedure: "Procedure",
    config: "RigConfig",
    folder: Path,
    seed: int,
    clock: "Clock",
) -> Iterator["LiveDiagnosis | None"]:
    """The adviser of a run with a live diagnosis, None without; its process ends with the context.

    Raises `LabrigError` for a model that cannot be read, or whose base is not there, before anything moves.
    """
    if settings is None:
        yield None
        return
    from labrig.campaign import dry_run, rig_info
    from labrig.live import LiveDiagnosis, Looker, Range
    from labrig.model import Model, check_base
    from labrig_drivers import RealClock

    check_base(Model.load(settings.model), settings.model)
    if settings.adapt and procedure.closed_loop:
        raise LabrigError(f"--adapt: {procedure.procedure_name()} chooses its own set-points")
    plan = dry_run(procedure, config, seed)
    planned = _UNKNOWN if procedure.closed_loop else plan.captures
    within = Range.of(plan, rig_info(config, seed)) if settings.adapt else None
    waits = not isinstance(clock, RealClock)
    looker = Looker([sys.executable, "-m", "labrig.api._live", str(folder.resolve()), settings.model])
    adviser = LiveDiagnosis(settings, planned, looker, waits=waits, range_kpa=within)
    try:
        yield adviser
    except BaseException:
        looker.close(None, 0.0)  # what went wrong is said at once
        raise
    looker.close(adviser.ended)


def main() -> None:
    """Answer on standard output, which nothing else may write to."""
    from labrig.live import lower_priority, serve

    lower_priority()
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())

    def say(line: str) -> None:
        answers.write(line + "\n")
        answers.flush()

    from labrig.view import write_course

    try:
        serve(Path(sys.argv[1]), Path(sys.argv[2]), sys.stdin, say, write_course)
    except (BrokenPipeError, KeyboardInterrupt):  # the run has gone
        return


if __name__ == "__main__":
    main()
