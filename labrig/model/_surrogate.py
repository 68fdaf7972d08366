"""The base that labrig learned: a forward model, or one with a sim-to-real correction."""

from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.effects import Rows
from labrig.model._kpa import in_kpa


class SurrogateModel:
    """A learned model from a file of `labrig train`; observables are matched by marker and axis, chambers by name.

    `known` are the lowest and the highest pressures that it learned from, (C,) each, in the run's unit.
    """

    kind = "surrogate"

    def __init__(self, path: Path, rows: Rows) -> None:
        from labrig.surrogate import load_model

        self._model = load_model(path)
        names = set(self._model.marker_names)
        unknown = [m for m in rows.markers if m not in names]
        if unknown or (rows.marker < 0).any() or (rows.axis < 0).any():
            what = f"marker {unknown[0]!r}" if unknown else "an observable that is no marker coordinate"
            raise LabrigError(f"{path}: the learned model knows nothing of {what}, which the run has")
        have = tuple(self._model.chamber_names)
        if sorted(have) != sorted(rows.chambers):
            raise LabrigError(
                f"{path}: its chambers ({', '.join(have)}) are not the run's ({', '.join(rows.chambers)})"
            )
        self._kpa = in_kpa(rows, path)
        self._order = [rows.chambers.index(name) for name in have]
        own = [have.index(name) for name in rows.chambers]
        self.known = self._model.low_kpa[own] / self._kpa, self._model.high_kpa[own] / self._kpa
        self._uv = self._model.markers(rows.markers)
        self._marker, self._axis = rows.marker, rows.axis

    def predict(self, actuation: Floats) -> Floats:
        """The markers on the learned surface."""
        kpa = self._kpa * actuation[:, self._order]
        return self._model.points(kpa, self._uv)[:, self._marker, self._axis]

    def slope(self, actuation: Floats) -> Floats:
        """Change of the prediction per unit of the run's actuation, (F, K, C)."""
        kpa = self._kpa * actuation[:, self._order]
        J = self._model.jacobian(kpa, self._uv)[:, self._marker, self._axis]
        result = np.empty_like(J)
        result[..., self._order] = self._kpa * J
        return result

    def declared(self, actuation: Floats) -> Floats | None:
        """None: what was learned is not fitted again."""
        return None
