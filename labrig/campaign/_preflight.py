"""Is the rig fit for this run? Asked after the first vent and before the first step."""

import shutil
from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig.campaign._session import Session, is_alive
from labrig_drivers import DeviceError, MarkerStatus

_WAIT_S = 5.0
_LOOK_S = 0.5
_BYTES_PER_MARKER, _BYTES_PER_FRAME, _FRAMES_PER_S = 13, 400, 120
_SPARE_BYTES = 50_000_000


def check_disk(folder: Path, duration_s: float, markers: int) -> None:
    """Raise `LabrigError` if the disk has less room than the run's log may need."""
    needed = _SPARE_BYTES + int(duration_s * _FRAMES_PER_S * (_BYTES_PER_MARKER * markers + _BYTES_PER_FRAME))
    free = shutil.disk_usage(folder).free
    if free < needed:
        raise LabrigError(
            f"{folder}: {free / 1e6:.0f} MB are free, and this run may need {needed / 1e6:.0f} MB; make room first"
        )


def preflight(session: Session) -> list[str]:
    """Read every device for a moment; returns what a person should know.

    Raises `DeviceError` when pressures or frames do not arrive, or when a vented chamber reads pressure.
    """
    session.held.frames.clear()
    session.held.samples.clear()
    _wait(session)
    session.wait_until(session.now_s() + _LOOK_S)
    return _vented_notes(session) + _marker_notes(session)


def _wait(session: Session) -> None:
    """Until each device has said something: the cameras are silent as long as all their markers are stale."""
    end_s = session.now_s() + _WAIT_S
    mocap = session.rig.mocap
    while not session.held.samples or (mocap is not None and not any(map(is_alive, session.held.frames))):
        if session.now_s() >= end_s:
            silent = session.rig.pressure if not session.held.samples else mocap
            name = silent.name if silent is not None else ""
            raise DeviceError(
                f"{name}: nothing was received within {_WAIT_S:g} s; check that it is streaming"
            )
        session.wait_until(session.now_s() + session.tick_s)


def _vented_notes(session: Session) -> list[str]:
    latest = session.held.samples[-1].pressure_kpa
    limit = session.rig.config.safety.vented_kpa
    for chamber, pressure_kpa in zip(session.rig.config.chambers, latest, strict=True):
        if abs(pressure_kpa) > limit:
            raise DeviceError(
                f"{session.rig.pressure.name}: {chamber.name} reads {pressure_kpa:.1f} kPa although it is vented "
                f"(more than {limit:g} kPa); check its sensor and valve"
            )
    blind = [c.name for c, p in zip(session.rig.config.chambers, latest, strict=True) if not np.isfinite(p)]
    return [f"no pressure is measured in {', '.join(blind)}"] if blind else []


def _marker_notes(session: Session) -> list[str]:
    if session.rig.mocap is None or not session.held.frames:
        return []
    seen = np.any([frame.status == MarkerStatus.SEEN for frame in session.held.frames], axis=0)
    names = [name for name, was_seen in zip(session.rig.config.markers, seen, strict=True) if not was_seen]
    if names and len(names) == len(seen):
        raise DeviceError(
            f"{session.rig.mocap.name}: none of the {len(seen)} markers is seen; check the cameras"
        )
    return [f"not seen at rest: {', '.join(names)}"] if names else []
