"""A model made ready for the runs of one rig: a base that is fitted to runs is fitted once, so that runs compare."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.diagnosis import Floor, Observations, clean, noise_floor, observe
from labrig.effects import Context, Rows
from labrig.model import Model, Predictor


@dataclass(frozen=True)
class Beside:
    """A run beside a model: its `context` with the model as it stands, and what that leaves.

    `residual` (F, K), NaN where not seen or mistaken; `changes`: what each of the model's effects does there, (F, K);
    `observations`: the same residual as independent numbers of unit noise, for the model as it stands.
    """

    context: Context
    residual: Floats
    changes: dict[str, Floats]
    floor: Floor
    observations: Observations

    def refitted(self, scales: Mapping[str, float]) -> "Beside":
        """The same with effects that are so many times as large as the model has them."""
        left = self.residual - sum((scale - 1.0) * self.changes[name] for name, scale in scales.items())
        floor = noise_floor(self.context, left)
        return replace(self, residual=left, floor=floor)


@dataclass
class Known:
    """A model and, where its base is fitted to runs, the rows of the run that it is fitted to."""

    model: Model
    reference: Rows | None = None
    _ready: dict[tuple[str, ...], Predictor] = field(default_factory=dict, repr=False)

    def beside(self, rows: Rows) -> Beside:
        """The model's predictions of a run; raises `LabrigError` where the two do not fit together."""
        context, changes = self._predictor(rows).parts(rows)
        residual, _ = clean(context)
        floor = noise_floor(context, residual)
        return Beside(context, residual, changes, floor, observe(context, residual, floor))

    def _predictor(self, rows: Rows) -> Predictor:
        if self.reference is not None:
            for what in ("chambers", "observables"):
                if getattr(rows, what) != getattr(self.reference, what):
                    raise LabrigError(
                        f"its {what} are not those of the run that the model's base is fitted to"
                    )
        if rows.observables not in self._ready:
            self._ready[rows.observables] = self.model.predictor(self.reference or rows)
        return self._ready[rows.observables]


def is_fitted(model: Model) -> bool:
    """Whether the model's base is fitted to each run that it is asked about."""
    base = model.file.base
    return base.kind == "static" or (base.kind == "simulator" and bool(base.calibrated))
