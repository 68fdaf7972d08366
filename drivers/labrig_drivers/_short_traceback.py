"""An error as a notebook shows it: where in the reader's own code, and the one line that says what to do."""

import os
import site
import sys
import sysconfig
import traceback
from collections.abc import Iterator
from types import FrameType
from typing import Any

_OURS = {"labrig", "labrig_drivers", "labrig_procedures", "labrig_schema", "IPython", "ipykernel"}
_BELOW = {"base": sys.base_prefix, "platbase": sys.base_exec_prefix}
"""Where the Python lies that a virtual environment was made of."""
_INSTALLED = tuple(
    os.path.normcase(path)
    for paths in (sysconfig.get_paths(), sysconfig.get_paths(vars=_BELOW))
    for path in [
        *(paths[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")),
        site.getusersitepackages(),
    ]
)
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
    """An error behind those that it was raised from, or while they were looked after."""
    chain = [error]
    while (before := _before(chain[0])) is not None and before not in chain:
        chain.insert(0, before)
    return chain


def _before(error: BaseException) -> BaseException | None:
    return error.__cause__ or (None if error.__suppress_context__ else error.__context__)


def _own(error: BaseException) -> Iterator[tuple[FrameType, int]]:
    """The calls of an error's traceback that are in neither labrig nor an installed library."""
    for frame, line in traceback.walk_tb(error.__traceback__):
        file, package = (
            os.path.normcase(frame.f_code.co_filename),
            str(frame.f_globals.get("__name__")).partition(".")[0],
        )
        if package not in _OURS and not file.startswith(("<frozen ", *_INSTALLED)):
            yield frame, line


def _lines(texts: Any) -> list[str]:
    return [line for text in texts for line in text.rstrip("\n").split("\n")]
