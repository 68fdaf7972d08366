"""What every step of an investigation needs."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from labrig.investigation._bench import Bench
from labrig.investigation._reporter import Reporter
from labrig.investigation._state import State

if TYPE_CHECKING:
    from labrig.model import Model


@dataclass(frozen=True)
class Work:
    """What is known, where it is measured, the model that is questioned, and who is told."""

    state: State
    bench: Bench
    model: "Model"
    reporter: Reporter

    def check(self) -> None:
        """Raise `labrig.campaign.Interrupted` where somebody asked for the end, between two runs."""
        if self.bench.endable is not None:
            self.bench.endable.check()
