"""Who is told what an investigation does, while it does it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from labrig._text import counted
from labrig.campaign import Watching
from labrig.contents import Proposed, Summary

if TYPE_CHECKING:
    from labrig.investigation._state import Settings


class Reporter:
    """Base of everything that reports an investigation; override what you need. By itself it is silent.

    The methods are called in the investigation's own thread: what they raise ends it.
    """

    def round_started(self, number: int, programme: str, minutes: float) -> None:
        """A round begins: `programme` is capture, experiment, confirmation or given; `minutes` are those on the rig."""

    def diagnosing(self, number: int, captures: int) -> None:
        """All runs so far are about to be diagnosed, `captures` of them together."""

    def diagnosed(self, number: int, summary: Summary) -> None:
        """All runs so far were diagnosed; `summary` is the content of diagnosis.json."""

    def proposed(self, summary: Proposed) -> None:
        """The next experiment was found, and will be measured; `summary` is the content of next.json."""

    @contextmanager
    def watching(self) -> Iterator[Watching]:
        """Who watches the run of a round, and may pause it."""
        yield Watching()

    def how_to_resume(self, settings: "Settings") -> str:
        """What a person does to go on with an investigation that was interrupted."""
        return f"labrig.investigate(..., out={str(settings.out)!r}, resume=True)"


class Lines(Reporter):
    """Says each thing that happens in a line of text, to a function such as `print`."""

    def __init__(self, say: Callable[[str], object]) -> None:
        self.say = say

    def round_started(self, number: int, programme: str, minutes: float) -> None:
        """The round, and how long it takes."""
        took = f", {minutes:.1f} min on the rig" if minutes else ""
        self.say(f"round {number}: {programme}{took}")

    def diagnosing(self, number: int, captures: int) -> None:
        """That it takes a moment."""
        self.say(f"  diagnosing {counted(captures, 'capture')}")

    def diagnosed(self, number: int, summary: Summary) -> None:
        """The verdict, and its names."""
        self.say(f"  {summary['verdict']}: {names_in(summary)}")

    def proposed(self, summary: Proposed) -> None:
        """What is measured next, and why."""
        separates = ", ".join(summary["separates"]) or "what is open"
        self.say(f"next: {counted(summary['captures'], 'capture')} to separate {separates}: {summary['why']}")


def names_in(summary: Summary) -> str:
    """The effects that a diagnosis names, and those that are possible besides."""
    sure, possible = ", ".join(summary["effects"]), ", ".join(summary["rivals"])
    if possible:
        return f"{sure}, or {possible}" if sure else f"perhaps {possible}"
    return sure or str(summary.get("carried_by") or "no effect")
