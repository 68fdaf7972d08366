"""Runs one labrig command for the workbench and writes down how it ended, also when the server has gone by then.

python -m labrig.workbench._child JOB_FOLDER WORD...
"""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

from labrig.workbench._locked import hold

ALIVE, CANCELLED, ENDED, PID = "alive", "cancelled", "ended.json", "pid"
INTERRUPTED = 130
"""How a command ends that somebody ended: by Ctrl-C, or by the End of a run."""


def main() -> None:
    """Hold the job's lock while its command runs; a signal to the group is for the command."""
    folder, words = Path(sys.argv[1]), sys.argv[2:]
    asked: list[int] = []
    for name in ("SIGINT", "SIGTERM", "SIGBREAK"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), lambda number, _: asked.append(number))
    with hold(folder / ALIVE) as alive:
        alive.write(b"held")  # an empty file is one that is not held yet
        alive.flush()
        # What was asked before there was a handler may have met nobody: whoever asks writes it down first.
        code = INTERRUPTED if (folder / CANCELLED).exists() else _run(words, asked)
        write_ended(folder, code)


def _run(words: list[str], asked: list[int]) -> int:
    # A handler, unlike SIG_IGN, is not handed down: the command meets these signals as if it were typed.
    with subprocess.Popen([sys.executable, "-m", "labrig", *words], stdin=subprocess.DEVNULL) as command:
        if asked:  # before there was a command that it could reach
            command.terminate()
        return command.wait()


def write_ended(folder: Path, code: int) -> None:
    """Write down that a job's command ended now."""
    partial = folder / f"{ENDED}.part"
    partial.write_text(json.dumps({"code": code, "ended_s": time.time()}), encoding="utf-8")
    partial.replace(folder / ENDED)


if __name__ == "__main__":
    main()
