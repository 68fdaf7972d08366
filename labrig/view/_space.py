"""Looking at a surface in space: where its front is, from where to look at it, and the layout of such a picture."""

import numpy as np

from labrig.arrays import Floats
from labrig.view._figures import Figure, _layout, _plain

_FITS = 1.7  # largest extent beside the geometric mean of all three that a picture has room for
_THINNEST = 0.04  # that share of its size is what names stand in front of a flat one


def scene_layout(camera: Figure, bar: bool) -> Figure:
    """The layout of a picture in space: no axes, true proportions, room for a colour bar."""
    # Nothing of an axis, said part by part: of one that is only invisible plotly still makes the letters.
    off = dict.fromkeys(
        ("showbackground", "showgrid", "zeroline", "showline", "showticklabels", "showspikes"), False
    )
    axis = {**off, "title": {"text": ""}, "tickmode": "array", "tickvals": []}
    layout = _layout(
        height=430,
        margin={"l": 0, "r": 70 if bar else 0, "t": 0, "b": 0},
        showlegend=False,
        scene={
            "xaxis": axis,
            "yaxis": axis,
            "zaxis": axis,
            "aspectmode": "data",
            "camera": camera,
            "dragmode": "orbit",
        },
    )
    del layout["xaxis"], layout["yaxis"]
    return layout


def view_axes(rest_mm: Floats) -> tuple[Floats, Floats, Floats]:
    """Unit vectors to the right, up, and out of the surface, as somebody in front of it sees them."""
    normal = front(rest_mm)
    up = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, normal)
    right /= np.linalg.norm(right)
    return right, np.cross(normal, right), normal


def camera(rest_mm: Floats) -> Figure:
    """Look at the side that bulges, a little from the right and above."""
    _, up, _ = view_axes(rest_mm)
    eye = _towards(rest_mm) * _further(rest_mm)
    names = ("x", "y", "z")
    return {
        "eye": dict(zip(names, _plain(eye), strict=True)),
        "up": dict(zip(names, _plain(up), strict=True)),
    }


def camera_axes(rest_mm: Floats) -> tuple[Floats, Floats, Floats]:
    """Unit vectors to the right and up on the screen, and towards the camera, as a picture begins."""
    back = _towards(rest_mm)
    back /= np.linalg.norm(back)
    right = np.cross(view_axes(rest_mm)[1], back)
    right /= np.linalg.norm(right)
    return right, np.cross(back, right), back


def _towards(rest_mm: Floats) -> Floats:
    right, up, normal = view_axes(rest_mm)
    return 2.1 * normal + 1.2 * right + 0.5 * up


def room_for(rest_mm: Floats) -> Floats | None:
    """Two corners (2, 3) of a box around markers, as thick as a camera takes them to be; None where they are as thick.

    Markers on a line are else drawn so large that most of them are out of the picture.
    """
    extent = np.ptp(rest_mm, axis=0)
    least = _extent(rest_mm)
    if np.sort(extent)[1] >= np.sort(least)[1]:  # a sheet has its names in front of it
        return None
    middle = (rest_mm.min(axis=0) + rest_mm.max(axis=0)) / 2
    return np.stack([middle - least / 2, middle + least / 2])


def _extent(rest_mm: Floats) -> Floats:
    extent = np.ptp(rest_mm, axis=0)
    return np.maximum(extent, _THINNEST * extent.max() + 1e-9)


def _further(rest_mm: Floats) -> float:
    """How many times further off a flat thing is looked at: plotly scales by the mean of the three extents."""
    extent = _extent(rest_mm)
    return float(max(1.0, extent.max() / np.prod(extent) ** (1 / 3) / _FITS))


def light(rest_mm: Floats) -> Figure:
    """A lamp over the left shoulder of somebody in front of the surface."""
    right, up, normal = view_axes(rest_mm)
    return dict(zip("xyz", _plain(1e4 * (normal - 1.2 * right + 0.8 * up)), strict=True))


def front(rest_mm: Floats) -> Floats:
    """The unit direction that the surface faces: along its thinnest axis, to the side that bulges."""
    centred = rest_mm - rest_mm.mean(axis=0)
    if len(rest_mm) < 3:
        return np.array([0.0, 1.0, 0.0])
    normal = np.linalg.svd(centred, full_matrices=False)[2][2]
    depth = centred @ normal
    radius = np.linalg.norm(centred - depth[:, None] * normal, axis=1)
    inner = radius <= np.median(radius)
    if inner.all():  # corners that are as far from the middle as each other
        inner = radius < np.median(radius)
    bulge = depth[inner].mean() - depth[~inner].mean() if inner.any() else 0.0
    if abs(bulge) > 1e-6 * (np.ptp(centred) or 1.0):
        return normal if bulge > 0 else -normal
    return normal if normal[np.argmax(np.abs(normal))] > 0 else -normal
