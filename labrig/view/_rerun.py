"""The only module that imports rerun: its API moves monthly, so what labrig needs of it is named here once.

Timelines: `capture` (a sequence) and `time` (seconds since the start). Positions mm.
"""

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

os.environ.setdefault("RUST_LOG", "off")  # a viewer that went away is no news for the run's terminal

import rerun as rr
import rerun.blueprint as rrb
from rerun.encodings import AbsoluteTimeRange

from labrig.arrays import Floats

Colour = tuple[int, int, int] | Sequence[int]

BACKGROUND = (22, 26, 33)
APPLICATION = "labrig"
LAST_WORDS_S = 2.0
PACE_FPS, THERE_S = 30.0, 0.5
_NEVER_LET_GO: list[rr.RecordingStream] = []


class Recording:
    """A stream of what is to be seen: into a file, or to a viewer that may or may not be there."""

    def __init__(self, name: str = APPLICATION) -> None:
        self._stream = rr.RecordingStream(APPLICATION)
        self._stream.send_recording_name(name)

    def to_file(self, path: Path) -> None:
        """Write everything that follows into an .rrd file."""
        self._stream.save(str(path))

    def to_viewer(self, url: str) -> None:
        """Send everything that follows to a viewer, for as long as it takes it.

        Letting go of a viewer that hangs waits without end: such a stream is never let go of, and the end of the
        program does not wait for it either.
        """
        rr.unregister_shutdown()
        _NEVER_LET_GO.append(self._stream)
        self._stream.connect_grpc(url)

    def arrange(self, blueprint: rrb.Blueprint) -> None:
        """Say how the viewer is to be laid out."""
        self._stream.send_blueprint(blueprint)

    def at(self, capture: int | None = None, time_s: float | None = None) -> None:
        """Set when the things that are logged next happened."""
        if capture is not None:
            self._stream.set_time("capture", sequence=capture)
        if time_s is not None:
            self._stream.set_time("time", duration=time_s)

    def upright(self, root: str, up: str = "z") -> None:
        """Say which axis points up below `root`."""
        system = {"z": rr.ViewCoordinates.RIGHT_HAND_Z_UP, "y": rr.ViewCoordinates.RIGHT_HAND_Y_UP}[up]
        self._stream.log(root, system, static=True)

    def mesh(self, path: str, vertices: Floats, triangles: Any, colours: NDArray[np.uint8]) -> None:
        """A surface: vertices (V, 3), triangles (T, 3), one colour a vertex (V, 3)."""
        self._stream.log(
            path,
            rr.Mesh3D(
                vertex_positions=vertices,
                triangle_indices=triangles,
                vertex_normals=_normals(vertices, triangles),
                vertex_colors=colours,
            ),
        )

    def points(
        self,
        path: str,
        positions: Floats,
        colours: Any,
        radius: float,
        labels: Sequence[str] | None = None,
    ) -> None:
        """Points (N, 3) of one radius, mm, with one colour or one each; labels show when pointed at."""
        self._stream.log(
            path, rr.Points3D(positions, colors=colours, radii=radius, labels=labels, show_labels=False)
        )

    def arrows(self, path: str, origins: Floats, vectors: Floats, colours: Any, radius: float) -> None:
        """Arrows (N, 3) from their origins (N, 3)."""
        self._stream.log(path, rr.Arrows3D(origins=origins, vectors=vectors, colors=colours, radii=radius))

    def series(self, path: str, name: str, colour: Colour, width: float = 1.5, steps: bool = False) -> None:
        """Name and style the curve that `value` draws at `path`."""
        mode = rr.components.InterpolationMode.StepAfter if steps else rr.components.InterpolationMode.Linear
        self._stream.log(
            path,
            rr.SeriesLines(colors=[list(colour)], names=name, widths=width, interpolation_mode=mode),
            static=True,
        )

    def value(self, path: str, value: float) -> None:
        """One more value of a curve."""
        self._stream.log(path, rr.Scalars(float(value)))

    def curve(self, path: str, timeline: str, at: Any, values: Floats) -> None:
        """A whole curve at once, over `capture` or over `time` (s); NaN is left out."""
        keep = np.isfinite(values)
        at = np.asarray(at)[keep]
        index = (
            rr.TimeColumn(timeline, sequence=at)
            if timeline == "capture"
            else rr.TimeColumn(timeline, duration=at)
        )
        self._stream.send_columns(path, indexes=[index], columns=rr.Scalars.columns(scalars=values[keep]))

    def state(self, path: str, state: str) -> None:
        """The state that something is in from now on, for a lane of the timeline view."""
        self._stream.log(path, rr.StateChange(state=state))

    def lane(self, path: str, colours: dict[str, Colour]) -> None:
        """The colours of the states of a lane."""
        self._stream.log(
            path,
            rr.StateConfiguration(
                values=list(colours), labels=list(colours), colors=[list(c) for c in colours.values()]
            ),
            static=True,
        )

    def text(self, path: str, markdown: str, static: bool = True) -> None:
        """A page of text."""
        self._stream.log(path, rr.TextDocument(markdown, media_type=rr.MediaType.MARKDOWN), static=static)

    def picture(self, path: str, pixels: NDArray[np.uint8]) -> None:
        """A still picture (H, W, 3)."""
        self._stream.log(path, rr.Image(pixels), static=True)

    def line(self, path: str, text: str, level: str = "INFO") -> None:
        """One line of a log."""
        self._stream.log(path, rr.TextLog(text, level=level))

    def clear(self, path: str) -> None:
        """Nothing is at `path` and below from now on."""
        self._stream.log(path, rr.Clear(recursive=True))

    def close(self) -> None:
        """Write what is left and close the file, or give a viewer two seconds to take what is left."""
        if self._stream not in _NEVER_LET_GO:
            self._stream.disconnect()
            return
        with contextlib.suppress(Exception):  # nobody is listening any more
            self._stream.flush(timeout_sec=LAST_WORDS_S)


def scene(name: str, root: str, eye: Floats, target: Floats, up: Floats) -> rrb.Spatial3DView:
    """A 3D view of what lies below `root`, seen from `eye`, mm."""
    return rrb.Spatial3DView(
        origin=root,
        name=name,
        background=list(BACKGROUND),
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=eye, look_target=target, eye_up=up),
    )


def plot(
    name: str, contents: str | list[str], last_s: float | None = None, legend: bool = True
) -> rrb.TimeSeriesView:
    """A view of curves: all of them, or what lies in the last `last_s` seconds before the cursor.

    A `legend` of more than a few curves is cut in a low view: it goes without where a picture has them.
    """
    bound = rrb.TimeRangeBoundary
    seen = rrb.TimeRange(start=bound.infinite(), end=bound.infinite())
    if last_s is not None:
        seen = rrb.TimeRange(
            start=bound.cursor_relative(seconds=-last_s), end=bound.cursor_relative(seconds=0.0)
        )
    return rrb.TimeSeriesView(
        origin="/",
        contents=contents,
        name=name,
        axis_x=rrb.TimeAxis(view_range=seen),
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.LeftTop, visible=legend),
    )


def page(name: str, path: str) -> rrb.TextDocumentView:
    """A view of text."""
    return rrb.TextDocumentView(origin=path, name=name)


def picture(name: str, path: str) -> rrb.Spatial2DView:
    """A view of a still picture."""
    return rrb.Spatial2DView(origin=path, name=name, background=list(BACKGROUND))


def log_lines(name: str, path: str) -> rrb.TextLogView:
    """A view of log lines."""
    return rrb.TextLogView(origin=path, name=name)


def lanes(name: str, root: str) -> rrb.StateTimelineView:
    """A view of states over time."""
    return rrb.StateTimelineView(origin=root, name=name)


def side_by_side(*views: Any, shares: Sequence[float] | None = None) -> rrb.Horizontal:
    """Views in a row."""
    return rrb.Horizontal(*views, column_shares=list(shares) if shares else None)


def stacked(*views: Any, shares: Sequence[float] | None = None) -> rrb.Vertical:
    """Views in a column."""
    return rrb.Vertical(*views, row_shares=list(shares) if shares else None)


def arrangement(view: Any, timeline: str, follow: bool = False, at: int | None = None) -> rrb.Blueprint:
    """The whole window: one container, the side panels out of the way, the time panel small.

    A layout can't say where the time begins: opened `at` a place of a sequence, it goes there in half a second, and
    plays that place over and over, until somebody moves the time.
    """
    time: dict[str, Any] = {"play_state": "following" if follow else "paused"}
    if at is not None:
        here = AbsoluteTimeRange(min=at, max=at)
        pace = max(PACE_FPS, at / THERE_S)
        time = {"play_state": "playing", "loop_mode": "selection", "time_selection": here, "fps": pace}
    return rrb.Blueprint(
        view,
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="collapsed", timeline=timeline, **time),
        auto_layout=False,
        auto_views=False,
    )


def _normals(vertices: Floats, triangles: Any) -> Floats:
    a, b, c = (vertices[np.asarray(triangles)[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, np.asarray(triangles)[:, k], face)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return total / np.where(length > 0, length, 1.0)
