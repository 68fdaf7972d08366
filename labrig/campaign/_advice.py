"""Who may change the course of a run: it asks between its steps, and never waits for more than an answer."""

from typing import Protocol

from labrig.campaign._procedure import RigInfo, Steps
from labrig.campaign._steps import Ask
from labrig.run_contents import Advice


class Adviser(Protocol):
    """Follows a run from one `Ask` to the next."""

    def follow(self, plan: Steps, rig: RigInfo) -> Steps:
        """The steps of a plan with questions between them, and what follows from the answers.

        As with a procedure, nothing but the plan and the results may decide what is yielded: a run is resumed by
        following it again with the results that were logged. Where nobody answers, as in a dry run, it is the plan.
        """
        ...

    def advise(self, ask: Ask, spent_s: float) -> Advice:
        """The answer, as plain values, at once; `spent_s` is the time that the steps so far took, s.

        Its `say` becomes an event of the log, its `trouble` a warning.
        """
        ...
