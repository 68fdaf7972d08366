"""A process that outlives whoever began it is no leak."""

import gc
import subprocess
import sys
import warnings

from labrig import _outliving
from labrig._outliving import outlives


def test_a_process_that_goes_on_is_kept_until_it_has_ended() -> None:
    """Nobody else holds it, and no warning says that it still runs; once it has ended it is let go."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
        outlives(process)
        number, stdin = process.pid, process.stdin
        del process
        gc.collect()
    (kept,) = [each for each in _outliving._GOING if each.pid == number]
    assert stdin is not None
    stdin.close()
    kept.wait(60)
    outlives(kept)
    assert kept not in _outliving._GOING
