"""What a live diagnosis was asked for: kept in run.yaml, so that a resumed run is asked for the same."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

from labrig._errors import LabrigError
from labrig.live._rule import Rule

EVERY = 4


class Diagnosed(TypedDict, total=False):
    """What run.yaml keeps of a live diagnosis."""

    model: str
    every: int
    until: str
    budget: str
    adapt: bool
    model_sha256: str


@dataclass(frozen=True)
class Settings:
    """The model that is questioned, after how many captures again and again, and what ends the campaign.

    `until` and `budget` are as `Rule.parse` takes them; with `adapt` the set-points follow the verdict. Raises
    `LabrigError` for a rule that cannot be read.
    """

    model: str
    every: int = EVERY
    until: str = ""
    budget: str = ""
    adapt: bool = False

    def __post_init__(self) -> None:
        if self.every < 1:
            raise LabrigError(f"--every {self.every}: give it at least one capture")
        self.rule()

    def rule(self) -> Rule:
        """What ends the campaign."""
        return Rule.parse(self.until, self.budget)

    def to_dict(self) -> Diagnosed:
        """Plain values for run.yaml, with the model file's hash."""
        return {
            "model": self.model,
            "every": self.every,
            "until": self.until,
            "budget": self.budget,
            "adapt": self.adapt,
            "model_sha256": sha256_of(Path(self.model)),
        }

    @classmethod
    def from_dict(cls, plain: Diagnosed, where: str) -> "Settings":
        """The inverse of `to_dict`; raises `LabrigError` that names `where` if the model file is another one now."""
        asked: dict[str, Any] = {name: value for name, value in plain.items() if name != "model_sha256"}
        settings = cls(**asked)
        if sha256_of(Path(settings.model)) != plain.get("model_sha256"):
            raise LabrigError(
                f"{where}: {settings.model} is no longer the model that this run is diagnosed with; start a new run"
            )
        return settings


def sha256_of(path: Path) -> str:
    """The hash of a file; raises `LabrigError` if it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise LabrigError(f"cannot read {path}: {error.strerror or error}") from None
