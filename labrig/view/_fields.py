"""What a report and a recording draw, taken out of a result's fields: residuals, marker clouds, a smooth skin."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from labrig._turns import commonest_unit
from labrig.arrays import Floats

if TYPE_CHECKING:
    import xarray as xr


FLAT = 0.03  # the second extent of a cloud, as a share of its first, below which it has no surface


@dataclass(frozen=True)
class Cloud:
    """Markers with all three axes: rest (M, 3) mm, and N captures measured and predicted (N, M, 3) mm.

    Every error is a root mean square per coordinate, as in all tables; `before_mm`, `after_mm` (M,) are those of the
    whole campaign. `reach` (M, C): how far each of the `chambers` alone moves each marker, where that is known.
    """

    names: tuple[str, ...]
    rest_mm: Floats
    measured_mm: Floats
    base_mm: Floats
    model_mm: Floats
    before_mm: Floats
    after_mm: Floats
    chambers: tuple[str, ...] = ()
    reach: Floats | None = None

    @property
    def base_error_mm(self) -> Floats:
        """Error before an effect was added, per coordinate, (N, M); NaN where unseen."""
        return per_coordinate(self.measured_mm - self.base_mm)

    @property
    def model_error_mm(self) -> Floats:
        """The same for the improved model."""
        return per_coordinate(self.measured_mm - self.model_mm)


@dataclass(frozen=True)
class Skin:
    """A smooth surface through the markers: `weight` (V, M) makes vertices of markers, `triangles` (T, 3)."""

    weight: Floats
    triangles: NDArray[np.int64]

    def vertices(self, markers: Floats) -> Floats:
        """Vertices (V, 3) for marker positions (M, 3), or values (V,) for one value a marker (M,)."""
        return self.weight @ markers


def cloud(fields: "xr.Dataset") -> Cloud | None:
    """The markers of a result, or None where it has no geometry."""
    if "rest_mm" not in fields or fields.sizes.get("marker", 0) == 0:
        return None
    marker_of = [str(name) for name in fields["marker_of"].values]
    axis_of = [str(name) for name in fields["axis_of"].values]
    column = {pair: k for k, pair in enumerate(zip(marker_of, axis_of, strict=True))}
    axes = ("x", "y", "z")
    names = [str(m) for m in fields["marker"].values if all((str(m), axis) in column for axis in axes)]
    rest = np.asarray(fields["rest_mm"].sel(marker=names).values, dtype=float)
    known = np.isfinite(rest).all(axis=1)
    names = [name for name, is_known in zip(names, np.atleast_1d(known).tolist(), strict=True) if is_known]
    if not names:
        return None
    index = np.array([[column[name, axis] for axis in axes] for name in names])

    def pick(variable: str) -> Floats:
        return np.asarray(fields[variable].values, dtype=float)[:, index]

    base, model = (
        ("base_everywhere", "model_everywhere") if "base_everywhere" in fields else ("base", "model")
    )
    measured, before, after = pick("measured"), pick(base), pick(model)

    def error(variable: str, predicted: Floats) -> Floats:
        if variable in fields:
            return np.asarray(fields[variable].sel(marker=names).values, dtype=float)
        return rms(per_coordinate(measured - predicted), axis=0)

    reach = np.asarray(fields["reach"].sel(marker=names).values, dtype=float) if "reach" in fields else None
    return Cloud(
        tuple(names),
        rest[known],
        measured,
        before,
        after,
        error("error_before", before),
        error("error_after", after),
        tuple(str(name) for name in fields["chamber"].values) if reach is not None else (),
        reach,
    )


def most_moved_by(fields: "xr.Dataset") -> dict[str, str]:
    """The chamber that moves each marker most, by the marker's name; empty where that is not known."""
    if "reach" not in fields:
        return {}
    reach = np.nan_to_num(np.asarray(fields["reach"].values, dtype=float))
    chambers = [str(name) for name in fields["chamber"].values]
    markers = [str(name) for name in fields["marker"].values]
    return {name: chambers[c] for name, c in zip(markers, reach.argmax(axis=1), strict=True)}


def per_coordinate(residual: Floats) -> Floats:
    """Root mean square over the three coordinates (..., 3); NaN where one was not seen."""
    return np.sqrt((residual**2).mean(axis=-1))


def skin(rest_mm: Floats, subdivisions: int = 2) -> Skin | None:
    """A smooth skin over markers at rest (M, 3), or None where they span no surface."""
    from scipy.interpolate import RBFInterpolator
    from scipy.spatial import Delaunay, QhullError

    if len(rest_mm) < 6:
        return None
    centred = rest_mm - rest_mm.mean(axis=0)
    _, extent, axes = np.linalg.svd(centred, full_matrices=False)
    if extent[1] < FLAT * extent[0]:
        return None
    uv = centred @ axes[:2].T
    try:
        triangles = np.asarray(Delaunay(uv).simplices, dtype=np.int64)
        triangles = _facing_out(uv, triangles)
        points = uv
        for _ in range(subdivisions):
            points, triangles = _subdivide(points, triangles)
        weight = RBFInterpolator(uv, np.eye(len(uv)), kernel="thin_plate_spline")(points)
    except (QhullError, np.linalg.LinAlgError, ValueError):
        return None
    return Skin(np.asarray(weight, dtype=float), triangles)


def _facing_out(uv: Floats, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    a, b, c = (uv[triangles[:, k]] for k in range(3))
    clockwise = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    turned = triangles.copy()
    turned[clockwise] = turned[clockwise][:, [0, 2, 1]]
    return turned


def _subdivide(points: Floats, triangles: NDArray[np.int64]) -> tuple[Floats, NDArray[np.int64]]:
    """Each triangle into four, by the middles of its edges; neighbours share them."""
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    middle = len(points) + inverse.reshape(3, -1)
    ab, bc, ca = middle
    a, b, c = triangles.T
    split = np.concatenate(
        [np.stack(corner, axis=1) for corner in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )
    return np.concatenate([points, points[unique].mean(axis=1)]), split


def filled(measured: Floats, predicted: Floats) -> Floats:
    """Measured positions, with the prediction where a marker was not seen."""
    return np.where(np.isfinite(measured), measured, predicted)


def rms(values: Floats, axis: int | tuple[int, ...] | None = None) -> Floats:
    """Root mean square of what is finite along `axis`; NaN where nothing is."""
    finite = np.isfinite(values)
    total = np.where(finite, values**2, 0.0).sum(axis=axis)
    count = finite.sum(axis=axis)
    return np.sqrt(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def counted(fields: "xr.Dataset") -> NDArray[np.int64]:
    """The observables that errors are quoted for: those of the commonest unit, without parts of quaternions."""
    if "unit" not in fields.coords:
        return np.arange(fields.sizes["observable"])
    told = (np.asarray(fields[name].values, dtype=float) for name in ("measured", "base") if name in fields)
    return commonest_unit([str(unit) for unit in fields["unit"].values], *told)


def residuals(fields: "xr.Dataset") -> tuple[Floats, Floats]:
    """Measured minus predicted by the base and by the model, (N, K), of the observables that are counted."""
    own = counted(fields)
    measured, base, model = (
        np.asarray(fields[name].values, dtype=float)[:, own] for name in ("measured", "base", "model")
    )
    return measured - base, measured - model


@dataclass(frozen=True)
class WorstCapture:
    """One capture that the model gets wrong: which, with what pressures, by how much, and where most."""

    capture: str
    session: str
    commanded: str
    base: float
    model: float
    where: str


def worst_captures(fields: "xr.Dataset", count: int = 8) -> list[WorstCapture]:
    """The captures with the largest error of the base, worst first."""
    before, after = residuals(fields)
    error, improved = rms(before, axis=1), rms(after, axis=1)
    order = [int(i) for i in np.argsort(-np.nan_to_num(error, nan=-1.0)) if np.isfinite(error[i])][:count]
    names, markers = [str(name) for name in fields["observable"].values], _marker_of(fields)
    owners = [markers[k] or names[k] for k in counted(fields)]
    captures = fields["capture"].values
    sessions = fields["session"].values if "session" in fields.coords else None
    result = []
    for i in order:
        size = np.nan_to_num(np.abs(before[i]), nan=0.0)
        by_owner = dict.fromkeys(owners, 0.0)
        for owner, value in zip(owners, size, strict=True):
            by_owner[owner] += float(value) ** 2
        worst = max(by_owner, key=lambda owner: by_owner[owner])
        result.append(
            WorstCapture(
                str(captures[i]),
                "" if sessions is None else str(sessions[i]),
                _pressures(fields, i),
                float(error[i]),
                float(improved[i]),
                worst,
            )
        )
    return result


def capture_words(fields: "xr.Dataset", capture: int) -> str:
    """A capture by its number, its session where there are several, and its set-points."""
    session = ""
    if "session" in fields.coords and len(set(fields["session"].values.tolist())) > 1:
        session = f" ({fields['session'].values[capture]})"
    set_points = _pressures(fields, capture)
    return f"{fields['capture'].values[capture]}{session}" + (f": {set_points}" if set_points else "")


def _marker_of(fields: "xr.Dataset") -> list[str]:
    if "marker_of" not in fields.coords:
        return [""] * fields.sizes["observable"]
    return [str(name) for name in fields["marker_of"].values]


def actuated(fields: "xr.Dataset") -> bool:
    """Whether anything was commanded at all."""
    return "commanded" in fields and bool(np.nan_to_num(fields["commanded"].values).any())


def capture_numbers(fields: "xr.Dataset") -> NDArray[np.int64]:
    """The captures' numbers in their run; their places where these are no rising numbers."""
    captures = np.asarray(fields["capture"].values)
    if np.issubdtype(captures.dtype, np.integer) and (np.diff(captures) > 0).all():
        return captures.astype(np.int64)
    return np.arange(len(captures), dtype=np.int64)


def _pressures(fields: "xr.Dataset", capture: int) -> str:
    """The set-points that are not zero, largest first, such as `c3 41, c1 12 kPa`."""
    if not actuated(fields):
        return ""
    values = np.asarray(fields["commanded"].values[capture], dtype=float)
    chambers = [str(name) for name in fields["chamber"].values]
    unit = str(fields["commanded"].attrs.get("units", ""))
    unit = "" if unit == "1" else unit
    order = [
        int(k)
        for k in np.argsort(-np.abs(np.nan_to_num(values)))
        if np.isfinite(values[k]) and values[k] != 0
    ]
    shown = ", ".join(f"{chambers[k]} {values[k]:.3g}" for k in order[:4])
    more = ", …" if len(order) > 4 else ""
    return f"{shown}{more} {unit}".strip() if shown else "vented"


def kept_captures(count: int, error: Floats, most: int) -> list[int]:
    """Which captures can be looked at: all, or evenly many with the worst among them."""
    if count <= most:
        return list(range(count))
    worst = np.argsort(-np.nan_to_num(error, nan=-1.0))[: most // 10]
    even = np.linspace(0, count - 1, most - len(worst)).astype(int)
    return sorted({int(i) for i in np.concatenate([even, worst])})
