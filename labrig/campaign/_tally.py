"""How many captures of a run count, and how many were left out since pressures did not follow."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from labrig.campaign._steps import Completed, Record, Scan


@dataclass
class Tally:
    """Recordings and scans that count, of what was left out (`on_miss: skip`) how much, and because of which chambers.

    As text it is one line for a person, empty where nothing was left out.
    """

    captures: int = 0
    scans: int = 0
    left_out: int = 0
    missed: Counter[str] = field(default_factory=Counter)

    @classmethod
    def of(cls, completed: Iterable[Completed]) -> "Tally":
        """That of so many steps."""
        tally = cls()
        for done in completed:
            tally.add(done)
        return tally

    def add(self, done: Completed) -> None:
        """Count a step that is done, if it is a recording or a scan."""
        if not isinstance(done.step, Record | Scan):
            return
        if names := getattr(done.result, "missed", ()):
            self.left_out += 1
            self.missed.update(names)
        elif isinstance(done.step, Record):
            self.captures += 1
        else:
            self.scans += 1

    @property
    def none_kept(self) -> bool:
        """Whether there were captures, and not one of them counts."""
        return bool(self.left_out) and not self.captures + self.scans

    def __str__(self) -> str:
        """How many of how many were left out, and why."""
        if not self.left_out:
            return ""
        total = self.left_out + self.captures + self.scans
        names = ", ".join(f"{name} in {count}" for name, count in self.missed.items())
        return (
            f"{self.left_out} of {total} captures were left out, since the pressures did not follow ({names}); check "
            "tubes, valves and sensors: labrig rig check"
        )
