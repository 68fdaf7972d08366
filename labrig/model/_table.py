"""A base that is a table of predictions: of finite elements, or of any model that can't be called."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.effects import Rows
from labrig.model._file import TableBase

_EXACT = 1_000
_NEAREST = 60
"""Set-points up to which one surface goes through all of them; of more, one through so many nearest ones."""


class TableModel:
    """What a table says of its set-points, and a smooth surface through them between: the one that bends least. Over
    one chamber that is the natural cubic spline, of kernel r^3; over several a thin-plate spline, of r^2 log r
    (J. Duchon, Splines minimizing rotation-invariant semi-norms in Sobolev spaces, Springer 1977; G. Wahba, Spline
    Models for Observational Data, SIAM 1990). Beyond the set-points of one chamber it goes on straight.

    Columns are named as the run's chambers and observables, in the run's units or in those that the table says; rows of
    one set-point are averaged.
    `known` are the least and the highest of its set-points, (C,) each.
    """

    kind = "table"

    def __init__(self, spec: TableBase, folder: Path, rows: Rows) -> None:
        from scipy.interpolate import RBFInterpolator

        path = folder / spec.file
        self._low, self._span = rows.low, rows.high - rows.low
        at, values = _columns(path, rows)
        points, index = np.unique((at - self._low) / self._span, axis=0, return_inverse=True)
        count = np.bincount(index.reshape(-1))
        mean = np.stack([np.bincount(index.reshape(-1), v) / count for v in values.T], axis=1)
        self.known = at.min(axis=0), at.max(axis=0)
        C = points.shape[1]
        if np.linalg.matrix_rank(points - points.mean(axis=0), tol=1e-6) < C:
            raise LabrigError(
                f"{path}: its {len(points)} set-points do not change every chamber by itself "
                f"({', '.join(rows.chambers)}): no slopes can be read off them"
            )
        many = _NEAREST if len(points) > _EXACT else None
        kernel = "cubic" if C == 1 else "thin_plate_spline"
        self._surface = RBFInterpolator(points, mean, kernel=kernel, degree=1, neighbors=many)

    def predict(self, actuation: Floats) -> Floats:
        """The surface at pressures (F, C), (F, K); beyond the table's set-points it goes on."""
        return np.asarray(self._surface((actuation - self._low) / self._span))

    def declared(self, actuation: Floats) -> Floats | None:
        """None: a table has no parameters of its own."""
        return None


def _columns(path: Path, rows: Rows) -> tuple[Floats, Floats]:
    """Columns of a table in any of the formats that runs are imported from, in the run's units: (n, C) and (n, K)."""
    from labrig.tables import Format, conversion, kind_of, read_file, sniff

    if not path.is_file():
        raise LabrigError(f"{path}: the model's table does not exist")
    table = read_file(path, sniff(path) if kind_of(path) == "text" else Format())

    def read(names: Sequence[str], units: Sequence[str], what: str) -> Floats:
        columns = []
        for name, unit in zip(names, units, strict=True):
            numbers, own = table.numbers(name, what, required=True), table.units.get(name, unit)
            if own != unit and not {own, unit} & {"", "1"}:
                scale, offset = conversion(own, unit, f"{path}: column {name!r}")
                numbers = scale * numbers + offset
            columns.append(numbers)
        return np.stack(columns, axis=1)

    inputs = rows.own_units or (rows.actuation_unit,) * len(rows.chambers)
    return read(rows.chambers, inputs, "a chamber of the run"), read(
        rows.observables, rows.unit, "an observable of the run"
    )
