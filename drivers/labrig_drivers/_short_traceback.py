"""An error as a notebook shows it: where in the reader's own code, and the one line that says what to do."""

import sysconfig
import traceback
from collections.abc import Iterator
from types import FrameType
from typing import Any

_OURS = {"labrig", "labrig_drivers", "labrig_procedures", "labrig_schema"}
_INSTALLED = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")})
_HEAD = "Traceback (most recent call last; your own code only, all of it: traceback.print_last())"


def short_traceback(error: BaseException) -> list[str]:
    """The lines of an error with the calls in the reader's own code alone, not those in labrig and in libraries.

    Before it comes what it was raised from, where that passed through the reader's own code, too: a model's function,
    an effect or a procedure of their own.
    """
    lines: list[str] = []
    for one in _causes(error):
        frames = traceback.StackSummary.extract(_own(one))
        if frames:
            lines += [_HEAD, *_lines(frames.format())]
        elif one is not error:
            continue
        lines += _lines(traceback.format_exception_only(one))
    return lines


def _causes(error: BaseException) -> list[BaseException]:
    """An error behind those that it was raised from."""
    chain = [error]
    while (cause := chain[0].__cause__) is not None and cause not in chain:
        chain.insert(0, cause)
    return chain


def _own(error: BaseException) -> Iterator[tuple[FrameType, int]]:
    """The calls of an error's traceback that are in neither labrig nor an installed library."""
    for frame, line in traceback.walk_tb(error.__traceback__):
        file, package = frame.f_code.co_filename, str(frame.f_globals.get("__name__")).partition(".")[0]
        if package not in _OURS and not file.startswith(("<frozen ", *_INSTALLED)):
            yield frame, line


def _lines(texts: Any) -> list[str]:
    return [line for text in texts for line in text.rstrip("\n").split("\n")]
