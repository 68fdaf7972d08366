"""The live view of a run: an observer that draws what happens, and that the run never waits for."""

import atexit
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.campaign import Completed, Observer, Progress, RigInfo, Step
from labrig.view._colours import STEPS, moved_colours, rgb
from labrig.view._fields import rms, skin
from labrig.view._legend import legend_picture
from labrig.view._scene import CHAMBER_COLOURS, UNSEEN, draw_state, scene_in_front
from labrig.view._style import BEFORE
from labrig.view._viewer import Viewer, reachable, start_viewer
from labrig_drivers import MarkerFrame, PressureSample

if TYPE_CHECKING:
    from labrig.view._rerun import Recording

Predict = Callable[[Floats], Floats]

FRAME_S = 0.05  # frames that follow each other faster are not drawn
SURFACE_S = 0.2
SHOWN_S = 120.0
LOOK_S = 2.0  # how often it is looked whether the viewer is still there
FLOOR_MM = 0.2  # noise floor that the colours of the error count in: while a run goes on nobody knows its own
ARROWS = 10.0
STEP_COLOURS = {
    "actuate": "#e58b55", "settle": "#e3c15b", "record": "#9cc069", "scan": "#6fb3c8",
    "note": "#a9b2bd", "ask": "#a9b2bd", "vent": "#d67fa8", "paused": "#dd5e66", "ended": "#5a6472",
}  # fmt: skip
STATE_COLOURS = {"well": "#9cc069", "WARNING": "#e3c15b", "ERROR": "#dd5e66", "FATAL": "#dd5e66"}


class LiveView(Observer):
    """Draws a run in a viewer while it goes on; `predict` maps pressures (C,) kPa to markers (M, 3) mm.

    Every method is called on the observer's own thread (see `Observer`): nothing here can delay the run, and the
    viewer may hang, die or never have been there.
    """

    def __init__(self, url: str, predict: Predict | None = None) -> None:
        self._url = url
        self._predict = predict
        self._recording: Recording | None = None
        self._markers: tuple[str, ...] = ()
        self._chambers: tuple[str, ...] = ()
        self._rest: Floats | None = None
        self._start_s: float | None = None
        self._frame_s = self._surface_s = -np.inf
        self._pressure: Floats | None = None
        self._last: Floats | None = None
        self._top = 1.0
        self._paused = False
        self._captures = 0
        self._looked_s = 0.0

    def _look(self) -> None:
        """Raise where nobody listens any more: an observer that raises is left alone from then on."""
        self._looked_s = time.monotonic()
        if not reachable(self._url):
            self._recording = None
            raise LabrigError("the viewer is gone")

    def started(self, rig: RigInfo, rest_mm: Floats | None) -> None:
        """Connect to the viewer and lay out the views."""
        from labrig.view._rerun import Recording

        self._look()
        self._recording = recording = Recording(rig.name)
        recording.to_viewer(self._url)
        self._markers, self._chambers = tuple(rig.marker_names), rig.chamber_names
        self._rest = None if rest_mm is None else np.asarray(rest_mm, dtype=float)
        known = self._rest is not None and bool(np.isfinite(self._rest).all())
        self._skin = skin(self._rest) if known and self._rest is not None else None
        for k, name in enumerate(self._chambers):
            colour = rgb(CHAMBER_COLOURS[k % len(CHAMBER_COLOURS)])
            recording.series(f"/commanded/{name}", name, colour, 1.0, steps=True)
            recording.series(f"/measured/{name}", name, colour, 2.0)
        recording.series("/residual", "measured − predicted", rgb(BEFORE), 2.0)
        recording.lane("/plan/step", {name: rgb(colour) for name, colour in STEP_COLOURS.items()})
        recording.lane("/plan/interlock", {name: rgb(colour) for name, colour in STATE_COLOURS.items()})
        recording.upright("/rig")
        self._arrange(recording)

    def _arrange(self, recording: "Recording") -> None:
        from labrig.view import _rerun

        rest = self._rest
        rest = None if rest is None else rest[np.isfinite(rest).all(axis=1)]
        title = "Surface and markers"
        if self._predict is not None:
            title += (
                f" (colour: error, dark from {STEPS[-1] * FLOOR_MM:.2g} mm; arrows: residual × {ARROWS:g})"
            )
        left = [] if rest is None or len(rest) < 3 else [scene_in_front(title, "/rig", rest)]
        curves: list[Any] = [
            _rerun.plot("measured, kPa", "/measured/**", SHOWN_S, legend=False),
            _rerun.plot("commanded, kPa", "/commanded/**", SHOWN_S, legend=False),
        ]
        if self._predict is not None:
            curves.insert(0, _rerun.plot("residual, mm rms", "/residual", SHOWN_S))
        plan = _rerun.stacked(
            _rerun.lanes("plan and interlock", "/plan"), _rerun.log_lines("events", "/events")
        )
        floor = FLOOR_MM if self._predict is not None else None
        recording.picture("/legend", legend_picture(floor, "mm", self._chambers))
        curves.append(_rerun.picture("What the colours mean", "/legend"))
        top = _rerun.side_by_side(*left, _rerun.stacked(*curves), shares=[3.0, 2.0] if left else None)
        recording.arrange(
            _rerun.arrangement(_rerun.stacked(top, plan, shares=[3.0, 1.2]), "time", follow=True)
        )

    def step_started(self, index: int, step: Step) -> None:
        """A step becomes the state of the plan."""
        if self._recording is not None:
            self._recording.state("/plan/step", step.kind)

    def step_done(self, completed: Completed) -> None:
        """A recording that is done is one more capture on the `capture` timeline."""
        if self._recording is not None and completed.step.kind == "record":
            self._captures += 1
            self._at(completed.ended_s)

    def commanded(self, time_s: float, pressure_kpa: Sequence[float]) -> None:
        """Draw the set-points."""
        if (recording := self._at(time_s)) is not None:
            for name, value in zip(self._chambers, pressure_kpa, strict=False):
                recording.value(f"/commanded/{name}", value)

    def sample(self, sample: PressureSample) -> None:
        """Draw the measured pressures."""
        self._pressure = sample.pressure_kpa
        if (recording := self._at(sample.time_s)) is not None:
            for name, value in zip(self._chambers, sample.pressure_kpa, strict=False):
                if np.isfinite(value):
                    recording.value(f"/measured/{name}", value)

    def frame(self, frame: MarkerFrame) -> None:
        """Draw the markers, and the surface and the residual less often."""
        if frame.time_s - self._frame_s < FRAME_S or (recording := self._at(frame.time_s)) is None:
            return
        self._frame_s = frame.time_s
        position = np.asarray(frame.position_mm, dtype=float)
        if self._last is None:
            self._last = position.copy() if self._rest is None else self._rest.copy()
        seen = np.isfinite(position).all(axis=1)
        self._last[seen] = position[seen]
        surface_due = frame.time_s - self._surface_s >= SURFACE_S
        if self._predict is not None and self._pressure is not None and np.isfinite(self._pressure).all():
            if surface_due:
                self._compare(recording, position, self._predict(self._pressure))
                self._surface_s = frame.time_s
            return
        known = self._last[np.isfinite(self._last).all(axis=1)]
        radius = 0.006 * float(np.ptp(known, axis=0).max()) if len(known) else 0.0
        labels = [self._markers[m] for m in np.flatnonzero(seen).tolist()]
        recording.points("/rig/measured", position[seen], rgb("#f3cf9b"), radius, labels)
        hidden = ~seen & np.isfinite(self._last).all(axis=1)
        recording.points("/rig/occluded", self._last[hidden], rgb(UNSEEN), radius)
        if surface_due and self._skin is not None and self._rest is not None:
            self._surface_s = frame.time_s
            distance = np.linalg.norm(self._last - self._rest, axis=1)
            self._top = max(self._top, float(np.nanmax(distance)))
            colours = moved_colours(np.clip(self._skin.vertices(distance), 0.0, None), self._top)
            recording.mesh("/rig/surface", self._skin.vertices(self._last), self._skin.triangles, colours)

    def _compare(self, recording: "Recording", position: Floats, predicted: Floats) -> None:
        residual = float(rms(position - predicted))
        if np.isfinite(residual):
            recording.value("/residual", residual)
        draw_state(recording, "/rig", self._markers, self._skin, position, predicted, FLOOR_MM, ARROWS)

    def event(self, time_s: float, text: str, level: str) -> None:
        """Show the line; what is worse than INFO also colours the interlock."""
        if (recording := self._at(time_s)) is not None:
            recording.line("/events", text, {"WARNING": "WARN", "FATAL": "CRITICAL"}.get(level, level))
            recording.state("/plan/interlock", level if level in STATE_COLOURS else "well")

    def progress(self, progress: Progress) -> None:
        """Show a pause, and its end, as a state of the plan."""
        if self._recording is not None and progress.paused != self._paused:
            self._paused = progress.paused
            self._recording.state("/plan/step", "paused" if progress.paused else progress.step)

    def finished(self, reason: str) -> None:
        """Say why the run ended, and let go of the viewer."""
        if (recording := self._recording) is not None:
            recording.state("/plan/step", "ended")
            recording.line("/events", f"the run has ended: {reason}")
            self._recording = None
            recording.close()

    def _at(self, time_s: float) -> "Recording | None":
        if self._start_s is None:
            self._start_s = time_s
        if time.monotonic() - self._looked_s > LOOK_S:
            self._look()
        if self._recording is not None:
            self._recording.at(capture=self._captures, time_s=time_s - self._start_s)
        return self._recording


def live_observers(
    window: bool, web: bool, say: Callable[[str], None], predict: Predict | None = None
) -> list[Observer]:
    """The observers that `--live` (a window) and `--serve` (a page for a browser on this machine) ask for.

    A viewer that does not start costs the run nothing: `say` gets a line that tells why, and the run goes on
    without. The window stays open after the run; the page is served until labrig ends.
    """
    observers: list[Observer] = []
    for wanted, is_web in ((window, False), (web, True)):
        if not wanted:
            continue
        try:
            viewer: Viewer = start_viewer(web=is_web)
        except LabrigError as error:
            say(f"no live view: {error}")
            continue
        if is_web:
            atexit.register(viewer.stop)
            say(f"live view for a browser on this machine: {viewer.page}")
        observers.append(LiveView(viewer.url, predict))
    return observers
