"""The other side of `_aside`: takes tasks from stdin and gives answers on stdout until stdin ends."""

import os
import pickle
import signal
import sys
from collections.abc import Callable
from typing import Any

from labrig._errors import LabrigError
from labrig.surface import _align, _tidy

TASKS: dict[str, Callable[..., Any]] = {
    "tidy_mesh": _tidy.tidy_mesh,
    "tidy_cloud": _tidy.tidy_cloud,
    "cloud_frame": _tidy.cloud_frame,
    "place": _align.place,
}


def main() -> None:
    """Serve. Ctrl-C is the parent's to deal with; what Open3D prints must not come between the answers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    while True:
        try:
            task, given = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        pickle.dump(_answered(task, given), answers, protocol=pickle.HIGHEST_PROTOCOL)
        answers.flush()


def _answered(task: str, given: tuple[Any, ...]) -> tuple[bool, Any]:
    try:
        return True, TASKS[task](*given)
    except LabrigError as error:
        return False, str(error)
    except ImportError as error:
        return False, (
            f"Open3D is installed and cannot be loaded: {error}; on Debian type: "
            "apt-get install libegl1 libgl1 libx11-6 libudev1 libusb-1.0-0"
        )
    except Exception as error:  # whatever Open3D makes of it
        why = " ".join(str(error).split())[:200]
        return False, f"Open3D could not do it ({task.replace('_', ' ')}): {type(error).__name__}: {why}"


if __name__ == "__main__":
    main()
