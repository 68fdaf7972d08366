"""What a diagnosis gives back."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from labrig._json import write_json
from labrig.arrays import Floats
from labrig.contents import Considered as Told
from labrig.contents import Place, PlaceGap, Summary, Versus
from labrig.diagnosis._track_record import times_there
from labrig.diagnosis._verdict import Considered

if TYPE_CHECKING:
    from xarray import Dataset

    from labrig.model import Model


@dataclass(frozen=True)
class Signature:
    """What gives an effect away, as the points of a plot, with the model's other effects removed.

    `says` is what to look for. `x`, `measured`, `fitted`, `weight` (N,): where the points lie, what was measured, what
    the fitted effect says, how much each point tells; `group` (N,) names what is drawn apart. A unit of `1` is none.
    """

    effect: str
    says: str
    x_name: str
    x_unit: str
    y_name: str
    y_unit: str
    x: Floats
    measured: Floats
    fitted: Floats
    weight: Floats
    group: NDArray[np.str_]
    chambers: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Where it changes pressures: by how much each chamber's, as a share of it, and root mean square in its unit."""


_Content = TypeVar("_Content", Summary, Versus)
_Place = TypeVar("_Place", Place, PlaceGap)


@dataclass(frozen=True)
class _Findings(Generic[_Content, _Place]):
    """What measurements say, with everything that a report of it shows.

    `summary` is the content of the JSON file; `fields` a Dataset (capture, observable) of `measured`,
    `base` and `model`, means over the hold; `waterfall` the error from the base down to the floor.
    """

    summary: _Content
    fields: "Dataset"
    waterfall: list[tuple[str, float]]
    signatures: list[Signature]
    where: list[_Place]
    improved: "Model | None" = field(default=None, compare=False)

    def write(self, path: Path) -> None:
        """Write the summary as JSON, in one piece or not at all."""
        write_json(self.summary, path)


class Result(_Findings[Summary, Place]):
    """What a diagnosis, a comparison with one model, or an improvement says; as diagnosis.json has it."""


class VersusResult(_Findings[Versus, PlaceGap]):
    """Two models on the same measurements; as comparison.json has it."""


def told(c: Considered, unit_size: float) -> Told:
    """What diagnosis.json says of one effect."""
    said: Told = {
        "effect": c.effect,
        "probability": c.probability,
        "call": c.call,
        "by_evidence": c.by_evidence,
        "share": c.share,
        "size": c.size_floors * unit_size,
        "size_sd": c.size_sd_floors * unit_size,
        "size_floors": c.size_floors,
        "size_sd_floors": c.size_sd_floors,
        "track_record": times_there(c.effect) if c.call == "sure" else None,
    }
    if c.gone != 0.5:
        said["gone"] = c.gone
    if not c.seen:
        said["seen"] = False
    return said
