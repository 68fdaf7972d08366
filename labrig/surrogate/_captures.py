"""What a rig showed: markers at the quasi-static end of each hold, and scans with the pressures they were taken at."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface import Mesh, read_mesh

if TYPE_CHECKING:
    from xarray import Dataset

_END_SHARE = 0.5
"""The part of the settled rows that counts as the end of a hold."""
_SEEN_SHARE = 0.5
"""A marker is captured in a hold if at least this share of the rows at its end saw it."""


@dataclass(frozen=True)
class Frames:
    """One frame a hold: `pressure_kpa` (F, C) as commanded, `position_mm` (F, M, 3), NaN for markers not captured."""

    marker_names: tuple[str, ...]
    pressure_kpa: Floats
    position_mm: Floats

    def __len__(self) -> int:
        return len(self.pressure_kpa)

    @property
    def captured(self) -> NDArray[np.bool_]:
        """Which markers were captured in which frames, (F, M)."""
        return np.asarray(np.isfinite(self.position_mm).all(axis=2))

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Which frames have every marker, (F,)."""
        return np.asarray(self.captured.all(axis=1))

    def take(self, index: Any) -> "Frames":
        """Some of the frames: a mask, indices or a slice."""
        return Frames(self.marker_names, self.pressure_kpa[index], self.position_mm[index])

    @classmethod
    def joined(cls, several: "Sequence[Frames]") -> "Frames":
        """The frames of several runs one after the other; markers that a run does not have were not captured there."""
        names = tuple(dict.fromkeys(name for frames in several for name in frames.marker_names))
        positions = [np.full((len(frames), len(names), 3), np.nan) for frames in several]
        for frames, position in zip(several, positions, strict=True):
            position[:, [names.index(name) for name in frames.marker_names]] = frames.position_mm
        pressure = np.concatenate([frames.pressure_kpa for frames in several])
        return cls(names, pressure, np.concatenate(positions))

    def set_points(self) -> NDArray[np.int64]:
        """Which set-point each frame is at, (F,), numbered as they first come."""
        _, first, group = np.unique(
            self.pressure_kpa.round(6), axis=0, return_index=True, return_inverse=True
        )
        return np.argsort(np.argsort(first))[group.reshape(-1)]

    def merged(self) -> "Frames":
        """One frame for each set-point: the mean position of each marker over the visits that saw it."""
        group = self.set_points()
        seen = self.captured
        rows = [group == g for g in range(group.max() + 1)]
        position = np.full((len(rows), *self.position_mm.shape[1:]), np.nan)
        for g, own in enumerate(rows):
            some = seen[own].any(axis=0)
            position[g, some] = np.nanmean(self.position_mm[own][:, some], axis=0)
        pressure = np.array([self.pressure_kpa[own][0] for own in rows])
        return Frames(self.marker_names, pressure, position)


@dataclass(frozen=True)
class Shot:
    """A scan and the pressures (C,), kPa, that were commanded when it was taken; `name` is its file's."""

    name: str
    pressure_kpa: Floats
    mesh: Mesh


def frames_of(run: "Dataset", chamber_names: tuple[str, ...]) -> Frames:
    """The frames of a run (docs/reference/dataset.md), its chambers in the order of `chamber_names`, in kPa.

    Raises `LabrigError` for a run without markers, with other chambers, or in no unit of pressure.
    """
    from labrig.tables import factor

    where = str(run.attrs.get("run", "run"))
    order = _chamber_order(where, [str(v) for v in run["chamber"].values], chamber_names)
    units = str(run["commanded"].attrs.get("units", "kPa"))
    try:
        in_kpa = factor(units or "1", "kPa", "commanded")
    except LabrigError:
        raise LabrigError(
            f"{where}: the forward model needs pressures; its are in {units or 'no unit'}"
        ) from None
    if "position_mm" not in run or run.sizes.get("capture", 0) == 0:
        raise LabrigError(f"{where}: has no captures with markers to learn from")
    position = np.asarray(run["position_mm"].values, dtype=float)
    settled = np.asarray(run["settled"].values, dtype=bool) & np.isfinite(run["hold_s"].values)
    ends = np.full((len(position), position.shape[2], 3), np.nan)
    for capture, rows in enumerate(settled):
        index = np.flatnonzero(rows)
        if len(index):
            ends[capture] = _end(position[capture, index[int(len(index) * (1 - _END_SHARE)) :]])
    kept = np.isfinite(ends).any(axis=(1, 2))
    if not kept.any():
        raise LabrigError(f"{where}: no marker was seen at the end of any hold")
    commanded = in_kpa * np.asarray(run["commanded"].values, dtype=float)[:, order]
    return Frames(tuple(str(v) for v in run["marker"].values), commanded[kept], ends[kept])


def _end(rows: Floats) -> Floats:
    """The median position (M, 3) over rows (T, M, 3); NaN for a marker that fewer than half of them saw."""
    seen = np.isfinite(rows).all(axis=2)
    result = np.full(rows.shape[1:], np.nan)
    enough = seen.mean(axis=0) >= _SEEN_SHARE
    result[enough] = np.nanmedian(rows[:, enough], axis=0)
    return result


def _chamber_order(where: str, have: list[str], want: tuple[str, ...]) -> list[int]:
    if sorted(have) != sorted(want):
        raise LabrigError(
            f"{where}: its chambers ({', '.join(have)}) are not the forward model's ({', '.join(want)})"
        )
    return [have.index(name) for name in want]


def shots_of(path: str | Path, chamber_names: tuple[str, ...]) -> list[Shot]:
    """The scans of a run folder in order; none is an empty list.

    Raises `LabrigError` for a run that can't be read, and for a scan whose file is gone or damaged.
    """
    from labrig.log import Topic, load_segments, sessions, to_ns
    from labrig_schema.pressure_pb2 import PressureCommand
    from labrig_schema.step_pb2 import Step

    path = Path(path)
    segments, _ = load_segments(path)
    shots = []
    for loaded in sessions(segments):
        order = _chamber_order(str(path), list(loaded.layout.chambers), chamber_names)
        commands = loaded.messages(Topic.COMMAND)
        times, setpoints = [], []
        for time_ns, payload in zip(commands.time_ns, commands.payload, strict=True):
            command = PressureCommand.FromString(payload)
            if command.event:
                times.append(time_ns)
                setpoints.append(np.array(command.setpoint, dtype=float)[order])
        for payload in loaded.messages(Topic.STEP).payload:
            step = Step.FromString(payload)
            if step.state != Step.DONE or step.kind != "scan":
                continue
            event = int(np.searchsorted(times, to_ns(step.started_s), side="right")) - 1
            values = json.loads(step.result_json or "{}")
            if values.get("missed"):  # the pressures did not follow: nobody knows what was scanned
                continue
            files = values.get("files") or []
            if event >= 0 and files:
                file = next((f for f in files if not f.endswith((".mtl", ".png", ".jpg"))), files[0])
                mesh = read_mesh(path / file, values.get("unit"))  # runs from before 0.11 do not say it
                shots.append(Shot(file.removeprefix("scans/"), setpoints[event], mesh))
    return shots
