"""The rig in 3D, as recordings and the live view draw it: one moment, and where to look at it from."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.arrays import Floats
from labrig.view._colours import error_colours, rgb
from labrig.view._fields import Skin, filled, per_coordinate
from labrig.view._space import view_axes

if TYPE_CHECKING:
    from labrig.view._rerun import Recording

ARROW, PREDICTED, UNSEEN = "#7fe3ff", "#d7dde4", "#5a6472"
CHAMBER_COLOURS = (
    "#e58b55", "#6fb3c8", "#9cc069", "#d67fa8", "#e3c15b", "#8f8fd6", "#68c2a3", "#c97f5f", "#a9b2bd", "#dd5e66",
)  # fmt: skip


def draw_state(
    recording: "Recording",
    root: str,
    names: Sequence[str],
    surface: Skin | None,
    measured: Floats,
    predicted: Floats,
    floor: float,
    scale: float,
) -> None:
    """One moment below `root`: the measured surface in the colour of its error, markers, residuals, the unseen.

    `measured` and `predicted` are (M, 3) mm, measured NaN where a marker was not seen; errors are per coordinate, their
    colours count in noise floors of `floor` mm, and the arrows of the residual are `scale` times as long as it.
    """
    radius = 0.006 * float(np.ptp(predicted, axis=0).max())
    error = per_coordinate(measured - predicted)
    seen = np.isfinite(error)
    if surface is not None:
        known = np.where(seen, error, np.nanmean(error) if seen.any() else 0.0)
        colours = error_colours(np.clip(surface.vertices(known), 0.0, None), floor)
        recording.mesh(
            f"{root}/surface", surface.vertices(filled(measured, predicted)), surface.triangles, colours
        )
    labels = [f"{names[m]}: {error[m]:.3g} mm per coordinate" for m in np.flatnonzero(seen).tolist()]
    recording.points(f"{root}/measured", measured[seen], error_colours(error[seen], floor), radius, labels)
    recording.points(f"{root}/predicted", predicted, rgb(PREDICTED), 0.45 * radius)
    unseen = [f"{names[m]}: not seen" for m in np.flatnonzero(~seen).tolist()]
    recording.points(f"{root}/occluded", predicted[~seen], rgb(UNSEEN), radius, unseen)
    vectors = scale * (measured - predicted)[seen]
    recording.arrows(f"{root}/residual", predicted[seen], vectors, rgb(ARROW), 0.3 * radius)


def scene_in_front(name: str, root: str, rest_mm: Floats) -> Any:
    """A 3D view of what lies below `root`, from the side to which the surface at rest (M, 3) faces."""
    from labrig.view import _rerun

    right, up, normal = view_axes(rest_mm)
    target = rest_mm.mean(axis=0)
    size = float(np.ptp(rest_mm, axis=0).max())
    return _rerun.scene(name, root, target + size * (1.25 * normal + 0.7 * right + 0.35 * up), target, up)
