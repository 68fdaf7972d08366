"""The base of every procedure, and what a procedure knows of the rig."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from labrig._errors import LabrigError
from labrig.campaign._steps import Step
from labrig_drivers import Channel

Steps = Generator[Step, Any, None]
"""What `Procedure.steps` returns: steps go out, each one's result comes back from its `yield`."""


@dataclass(frozen=True)
class RigInfo:
    """What a procedure may know of the rig: names, limits (kPa), and the seed of this run."""

    name: str
    channels: tuple[Channel, ...]
    marker_names: tuple[str, ...] = ()
    has_scanner: bool = False
    seed: int = 0

    @property
    def chamber_names(self) -> tuple[str, ...]:
        """The chambers in the order of every set-point."""
        return tuple(channel.name for channel in self.channels)

    @property
    def min_kpa(self) -> NDArray[np.float64]:
        """The lowest pressure allowed, (C,)."""
        return np.array([channel.min_kpa for channel in self.channels])

    @property
    def max_kpa(self) -> NDArray[np.float64]:
        """The highest pressure allowed, (C,)."""
        return np.array([channel.max_kpa for channel in self.channels])

    def rng(self) -> np.random.Generator:
        """A fresh random generator; the same seed gives the same numbers."""
        return np.random.default_rng(self.seed)

    def chamber(self, name: str) -> int:
        """The place of a chamber in a set-point; raises `LabrigError` if there is none of that name."""
        if name not in self.chamber_names:
            raise LabrigError(
                f"rig {self.name} has no chamber {name}; it has {', '.join(self.chamber_names)}"
            )
        return self.chamber_names.index(name)

    def setpoint(self, **pressure_kpa: float) -> tuple[float, ...]:
        """A set-point with the named chambers at these pressures, kPa, and the others vented."""
        values = [0.0] * len(self.channels)
        for name, value in pressure_kpa.items():
            values[self.chamber(name)] = float(value)
        return tuple(values)


class Procedure(BaseModel):
    """A procedure: its fields are its parameters, `steps` is what it does.

    Give every field a default and a description that names its unit: they become the options of `labrig run`.
    `steps` must depend on nothing but the parameters, the `RigInfo` and the results that it receives: a run that
    was interrupted is resumed by running `steps` again and handing it the logged results.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, coerce_numbers_to_str=True)

    closed_loop: ClassVar[bool] = False
    """True when the steps depend on what was measured: the plan is then checked step by step only."""

    def set_points(self, rig: RigInfo) -> float:
        """About how many set-points the parameters ask for, where that is known before the steps are made, else 0.

        What asks for more than a plan may have is refused at once, and not after its steps have filled the memory.
        """
        return 0.0

    @classmethod
    def procedure_name(cls) -> str:
        """The name that `labrig run` knows it by: the class name in small letters."""
        return cls.__name__.lower()

    def steps(self, rig: RigInfo) -> Steps:
        """Yield steps; each `yield` gives back the step's result."""
        raise LabrigError(f"procedure {self.procedure_name()} has no steps for rig {rig.name}: write `steps`")
        yield
