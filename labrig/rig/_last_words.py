"""What is said at the end, of a run or of whatever else used a rig: always whether the chambers are vented."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from labrig._errors import LabrigError
from labrig_drivers import DeviceError, VentNotConfirmedError

BY_HAND = "relieve the pressure by hand"
VENTED = "the chambers are vented"

SLOW_S = 5.0
"""A vent that takes longer than this is spoken of before it has failed, s."""


def by_hand(text: str) -> str:
    """What is said of a vent that was not confirmed, with what a person has to do now."""
    return text if BY_HAND in text else f"{text}; {BY_HAND}"


def and_vented(error: BaseException) -> BaseException:
    """The same error, which now says that the chambers are vented; `error` itself where it can only be noted."""
    text = str(error)
    if VENTED in text or VENTED in getattr(error, "__notes__", ()):
        return error
    if isinstance(error, VentNotConfirmedError):
        earlier = text.replace(f"; {BY_HAND}", "")
        return DeviceError(f"{earlier}; a later vent was confirmed: {VENTED}")
    if isinstance(error, LabrigError | DeviceError):
        return retold(error, f"{text}; {VENTED}")
    error.add_note(VENTED)
    return error


def retold(error: Exception, text: str) -> Exception:
    """The same kind of error that says `text`; `error` itself where its kind is made of more than its text."""
    try:
        return type(error)(text)
    except TypeError:
        error.args = (text, *error.args[1:])
        return error


def not_vented(
    problem: BaseException, error: BaseException | None, reason: str = ""
) -> VentNotConfirmedError:
    """A vent that was not confirmed, and what had ended the run (`error`, or in other words `reason`) before it."""
    text = str(problem) or type(problem).__name__
    if not isinstance(problem, VentNotConfirmedError):
        text = f"{text}; the vent is not confirmed"
    known = error is None or str(error) == str(problem)
    because = "" if known else f"; the run had ended because: {reason or error}"
    return VentNotConfirmedError(f"{by_hand(text)}{because}")


@contextmanager
def impatient(tell: Callable[[str], None]) -> Iterator[threading.Timer]:
    """Say that the pressure is to be relieved by hand when what happens inside takes longer than `SLOW_S`.

    `tell` is called on another thread; `cancel` what this gives where it was said already.
    """
    text = f"the vent is not confirmed after {SLOW_S:g} s; {BY_HAND} if you can: it is being tried on"
    timer = threading.Timer(SLOW_S, tell, (text,))
    timer.daemon = True
    timer.start()
    try:
        yield timer
    finally:
        timer.cancel()
