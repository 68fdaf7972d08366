"""The plant: one physical thing behind all simulated devices of a rig."""

import threading
from pathlib import Path
from typing import Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig.arrays import Floats
from labrig.physics import has_shell, reduced_surface
from labrig_drivers._protocols import Channel, DeviceError
from labrig_drivers.simulated._attention import Attention, is_exact
from labrig_drivers.simulated._calibration import calibrate, reference_programme
from labrig_drivers.simulated._engine import Engine, seen_positions
from labrig_drivers.simulated._observer import Observer
from labrig_drivers.simulated._sealed import HiddenSetting, checked, reveal
from labrig_drivers.simulated.hidden import EFFECTS, Body, Hidden, Setting

FLOOR_FRAMES = 20  # frames whose mean makes the noise floor in which amplitudes may be given


class Plant(Protocol):
    """What simulated devices share. Times: s on the rig's clock, not decreasing between commands."""

    chamber_names: tuple[str, ...]
    channels: tuple[Channel, ...]
    marker_names: tuple[str, ...]
    rest_mm: Floats

    def command(self, time_s: float, pressure_kpa: ArrayLike) -> None:
        """Set-points (C,), kPa, from `time_s` on; 0 vents."""
        ...

    def pressure_kpa(self, time_s: float) -> Floats:
        """True chamber pressures, kPa, (C,)."""
        ...

    def markers_mm(self, time_s: float) -> Floats:
        """True marker positions in the measuring frame, mm, (M, 3), without noise."""
        ...

    def observe(self, time_s: float) -> tuple[Floats, NDArray[np.int8]]:
        """One frame: positions, mm, (M, 3), noisy, NaN where occluded; `MarkerStatus` (M,)."""
        ...

    def observe_frames(self, time_s: Floats) -> tuple[Floats, NDArray[np.int8]]:
        """Many frames at once, at rising times (F,): (F, M, 3) and (F, M)."""
        ...

    def pressures_kpa(self, time_s: Floats) -> Floats:
        """True chamber pressures at many times (F,): (F, C)."""
        ...

    def surface(self, time_s: float) -> tuple[Floats, NDArray[np.int64]]:
        """The whole surface: vertices, mm, (V, 3), and triangles (T, 3)."""
        ...


class PlantBody(Body, Protocol):
    """A body with markers that has a surface to scan."""

    marker_names: tuple[str, ...]

    @property
    def triangles(self) -> NDArray[np.int64]: ...
    def mesh_at(self, deflection_mm: Floats) -> Floats: ...


class SimulatedPlant:
    """A surface, its air supply, its cameras and what is hidden in them; may be used from several threads.

    Pressures never wait for a shape that is being worked out: a real controller does not wait for the cameras either.
    Its time begins with whatever it is asked first. `capture_floor_mm` is the noise floor of a capture of 20
    frames (see `drivers/labrig_drivers/simulated/_observer.py` for what it is made of).
    """

    def __init__(
        self,
        surface: PlantBody,
        channels: tuple[Channel, ...],
        observer: Observer,
        hidden: list[Hidden] | None = None,
    ) -> None:
        self.chamber_names = surface.chamber_names
        self.channels = channels
        self.marker_names = surface.marker_names
        self.rest_mm = surface.rest_mm
        self._surface = surface
        self._hidden = list(hidden or [])
        self._engine = Engine(surface, self._hidden)
        self._observer = observer
        self._attention = Attention(surface) if is_exact(surface) else None  # type: ignore[arg-type]
        self._lock = threading.Lock()  # of the pressures; held for moments
        self._eyes = threading.Lock()  # of what is seen; held while a shape is worked out
        self._unseen: list[tuple[float, Floats]] = []  # commands that those who look have not heard of
        self._start_s: float | None = None
        self._target = np.zeros(len(channels))

    @property
    def capture_floor_mm(self) -> float:
        """Repeatability of the mean of 20 frames of a hold, mm rms per axis."""
        return self._observer.capture_floor_mm(FLOOR_FRAMES)

    def command(self, time_s: float, pressure_kpa: ArrayLike) -> None:
        """Set-points (C,), kPa, from `time_s` on; 0 vents. The same set-points again change nothing."""
        target = np.asarray(pressure_kpa, dtype=float)
        with self._lock:
            now_s = float(self._since_start(np.array([time_s]))[0])
            if np.array_equal(target, self._target):
                return
            self._target = target.copy()
            self._engine.command(now_s, target)
            self._unseen.append((now_s, target))

    def make_ready(self) -> None:
        """Work out what takes long about any shape at all, so that the first that is asked for does not wait for it."""
        with self._eyes:
            self._surface.shape_mm(np.zeros((1, len(self.channels))))

    def prepare(self, pressure_kpa: ArrayLike) -> None:
        """Work out what takes long about set-points (C,), kPa, before it is asked for; any thread may."""
        if self._attention is not None:
            self._attention.prepare(np.asarray(pressure_kpa, dtype=float))

    def pressure_kpa(self, time_s: float) -> Floats:
        """True chamber pressures, kPa, (C,)."""
        return self.pressures_kpa(np.array([time_s]))[0]

    def pressures_kpa(self, time_s: Floats) -> Floats:
        """True chamber pressures at many times (F,): (F, C), kPa."""
        with self._lock:
            return self._engine.state(self._since_start(time_s))[0]

    def markers_mm(self, time_s: float) -> Floats:
        """True marker positions in the measuring frame, mm, (M, 3), without noise."""
        with self._eyes:
            return self._seen(*self._moments(np.array([time_s])))[0]

    def observe(self, time_s: float) -> tuple[Floats, NDArray[np.int8]]:
        """One frame: positions, mm, (M, 3), NaN where occluded; `MarkerStatus` (M,)."""
        position, status = self.observe_frames(np.array([time_s]))
        return position[0], status[0]

    def observe_frames(self, time_s: Floats) -> tuple[Floats, NDArray[np.int8]]:
        """Many frames at once, at rising times (F,): (F, M, 3) mm and (F, M)."""
        with self._eyes:
            time_s, deflection = self._moments(time_s)
            return self._observer.look(time_s, self._seen(time_s, deflection))

    def surface(self, time_s: float) -> tuple[Floats, NDArray[np.int64]]:
        """The whole surface at one time: vertices, mm, (V, 3), and triangles (T, 3)."""
        with self._eyes:
            _, deflection = self._moments(np.array([time_s]))
            return self._surface.mesh_at(deflection[0]), self._surface.triangles

    def _moments(self, time_s: Floats) -> tuple[Floats, Floats]:
        """Times since the start (F,) and the deflections (F, C) then; whoever looks hears of new commands first."""
        with self._lock:
            since_s = self._since_start(time_s)
            deflection = self._engine.state(since_s)[1]
            commands, self._unseen = self._unseen, []
        for command_s, target in commands:
            self._observer.next_hold(command_s)
            if self._attention is not None:
                self._attention.command(command_s, target)
        return since_s, deflection

    def _seen(self, time_s: Floats, deflection: Floats) -> Floats:
        shape = self._surface.shape_mm(deflection)
        if self._attention is not None:
            shape = shape + self._attention.correction_mm(time_s, deflection)
        return seen_positions(shape, self._hidden, time_s, np.zeros(time_s.size), deflection)

    def _since_start(self, time_s: Floats) -> Floats:
        time_s = np.asarray(time_s, dtype=float)
        if self._start_s is None:
            self._start_s = float(time_s.max())
        return np.maximum(time_s - self._start_s, 0.0)


def make_hidden(hidden: HiddenSetting, surface: Body, max_kpa: Floats, floor_mm: float) -> list[Hidden]:
    """The effects of a `hidden` setting, each brought to its amplitude over the reference campaign."""
    setting = checked(hidden)
    programme = reference_programme(max_kpa, setting["duration_s"])
    made = []
    for index, entry in enumerate(setting["effects"]):
        random = np.random.default_rng([setting["seed"], index, 5])
        effect = EFFECTS[entry["name"]](Setting(surface, max_kpa, setting["duration_s"], random))
        rms_mm = entry["amplitude"] * (floor_mm if setting["unit"] == "floors" else 1.0)
        reached = calibrate(surface, effect, rms_mm, programme)
        if abs(reached / rms_mm - 1.0) > 0.05:
            raise DeviceError(
                f"simulated: hidden: {effect.name}: cannot move the markers by {rms_mm:g} mm rms"
            )
        made.append(effect)
    return made


def build_plant(rig: dict, folder: Path) -> SimulatedPlant:
    """The plant of a simulated rig, from the content of its rig.yaml and the folder it lies in.

    Reads `simulated:` shell and plant (see `labrig.physics.plant_shell`; without them the mannequin), or the name of a
    reduced surface; seed (0), noise_mm (0.1),
    repeatability_mm (as noise_mm), occlusion (0.03), and hidden: a sealed file's name (relative to `folder`), the
    setting itself, or nothing.
    """
    settings = rig.get("simulated") or {}
    surface = _body_of(rig, Path(folder)) if has_shell(rig) else reduced_surface(rig)
    listed = rig.get("chambers") or [{"name": name} for name in surface.chamber_names]
    channels = tuple(
        Channel(
            str(c["name"]),
            float(c.get("min_kpa", 0.0)),
            float(c.get("max_kpa", 60.0)),
            float(c.get("slew_kpa_s", np.inf)),
        )
        for c in listed
    )
    noise_mm = float(settings.get("noise_mm", 0.1))
    repeatability = settings.get("repeatability_mm")
    observer = Observer(
        markers=len(surface.marker_names),
        seed=int(settings.get("seed", 0)),
        noise_mm=noise_mm,
        repeatability_mm=noise_mm if repeatability is None else float(repeatability),
        occlusion=float(settings.get("occlusion", 0.03)),
    )
    source = settings.get("hidden")
    hidden: list[Hidden] = []
    if source:
        given = isinstance(source, dict)
        content = cast(HiddenSetting, source) if given else reveal(Path(folder) / str(source))
        max_kpa = np.array([channel.max_kpa for channel in channels])
        hidden = make_hidden(content, surface, max_kpa, observer.capture_floor_mm(FLOOR_FRAMES))
    return SimulatedPlant(surface, channels, observer, hidden)


def _body_of(rig: dict, folder: Path) -> PlantBody:
    # here, since it takes half a second to import, and only shells need it
    from labrig.physics import load_body

    return load_body(rig, folder)
