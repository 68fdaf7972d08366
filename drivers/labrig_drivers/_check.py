"""Is a rig well? Each device is connected, identified, read for a while, and the vent is tried."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from labrig_drivers._protocols import DeviceError, MarkerStatus, frames_missing

LEAST_SPAN_MM, MOST_SPAN_MM = 10.0, 20_000.0  # what markers of a rig are apart, at least and at most
MAX_UNSEEN = 0.25  # the part of the markers that may be covered in a rig that is well


State = Literal["well", "look", "bad"]


@dataclass(frozen=True)
class Finding:
    """One line of a check: which device, what was looked at, how it is, and what was seen.

    `look` is for a person to judge: it works, but may not be as meant.
    """

    device: str
    what: str
    state: State
    text: str


def check_devices(
    makers: Mapping[str, Callable[[], Any]], read_s: float = 2.0, vent_timeout_s: float = 10.0
) -> list[Finding]:
    """Try every device (`pressure`, `mocap`, `scanner`); one that fails does not keep the others from it.

    Every device is closed at the end; the pressures are at ambient then, or a finding says that they are
    not.
    """
    findings: list[Finding] = []
    connected: dict[str, Any] = {}
    try:
        for role, make in makers.items():
            device = _connected(role, make, findings)
            if device is not None:
                connected[role] = device
        _drain(connected)
        time.sleep(read_s)
        for role, device in connected.items():
            look = {"pressure": _look_at_pressure, "mocap": _look_at_mocap}.get(role)
            if look is not None:
                findings += _tried(role, "readings", lambda look=look, d=device: look(d, read_s))
        if "pressure" in connected:
            device = connected["pressure"]
            findings += _tried("pressure", "vent", lambda: _look_at_vent(device, vent_timeout_s))
    finally:
        for device in connected.values():
            device.close()
    return findings


def _connected(role: str, make: Callable[[], Any], findings: list[Finding]) -> Any:
    device = None
    try:
        device = make()
        device.connect()
        identity = device.identify()
    except DeviceError as error:
        findings.append(Finding(role, "connect", "bad", _without_name(error, role)))
        if device is not None:
            device.close()
        return None
    details = ", ".join(f"{key} {value}" for key, value in identity.details.items())
    text = identity.description + (f" ({details})" if details else "")
    findings.append(Finding(role, "connect", "well", text))
    return device


def _drain(connected: Mapping[str, Any]) -> None:
    for role, read in (("pressure", "samples"), ("mocap", "frames")):
        if role in connected:
            try:
                getattr(connected[role], read)()
            except DeviceError:
                continue  # the reading that follows reports it


def _tried(role: str, what: str, look: Callable[[], list[Finding]]) -> list[Finding]:
    try:
        return look()
    except DeviceError as error:
        return [Finding(role, what, "bad", _without_name(error, role))]


def _look_at_pressure(device: Any, read_s: float) -> list[Finding]:
    samples = device.samples()
    if not samples:
        return [Finding("pressure", "readings", "bad", f"none in {read_s:g} s")]
    values = np.array([sample.pressure_kpa for sample in samples])
    blind = [c.name for c, v in zip(device.channels, values.T, strict=True) if not np.isfinite(v).any()]
    known = values[:, np.isfinite(values).any(axis=0)]
    spread = float(np.nanmax(np.nanstd(known, axis=0))) if known.size else float("nan")
    text = (
        f"{len(samples) / read_s:.0f} Hz, {np.nanmin(known):.2f} to {np.nanmax(known):.2f} kPa, "
        f"noise up to {spread:.2f} kPa"
        if known.size
        else f"{len(samples) / read_s:.0f} Hz"
    )
    if blind:
        text += f"; no reading from {', '.join(blind)}"
    return [Finding("pressure", "readings", "bad" if blind else "well", text)]


def _look_at_mocap(device: Any, read_s: float) -> list[Finding]:
    frames = [frame for frame in device.frames() if not np.all(frame.status == MarkerStatus.STALE)]
    if not frames:
        return [Finding("mocap", "readings", "bad", f"no frame in {read_s:g} s: is the capture live?")]
    lost = frames_missing(frames)
    text = f"{len(frames) / read_s:.0f} Hz" + (f", {lost} frames missing" if lost else ", no frame missing")
    findings = [Finding("mocap", "readings", "look" if lost else "well", text)]
    status = np.array([frame.status for frame in frames])
    findings.append(_markers(device.marker_names, status))
    position = np.array([frame.position_mm for frame in frames])
    seen = position[np.isfinite(position).all(axis=2)]
    if np.isfinite(position).all(axis=2).any(axis=0).sum() > 1:
        size_mm = float(np.linalg.norm(seen.max(axis=0) - seen.min(axis=0)))
        findings.append(_extent(size_mm))
    return findings


def _extent(size_mm: float) -> Finding:
    """How far the markers are apart, and whether that looks like another unit."""
    text = f"the markers span {size_mm:.4g} mm"
    if size_mm < LEAST_SPAN_MM:
        hint = ": that looks like metres; set `unit: m`, or correct the calibration"
    elif size_mm > MOST_SPAN_MM:
        hint = ": no rig is so large; is `unit: m` set, and the server sends mm?"
    else:
        return Finding("mocap", "extent", "well", text)
    return Finding("mocap", "extent", "look", text + hint)


def _markers(names: Any, status: np.ndarray) -> Finding:
    unknown = [n for n, s in zip(names, status.T, strict=True) if np.all(s == MarkerStatus.NOT_SUBSCRIBED)]
    if unknown:
        listed = ", ".join(unknown[:8]) + (f" and {len(unknown) - 8} more" if len(unknown) > 8 else "")
        return Finding(
            "mocap",
            "markers",
            "bad",
            f"the server sends nothing for {listed}: check `subject` and the marker names, and that its "
            "output holds labelled markers",
        )
    seen = (status == MarkerStatus.SEEN).mean(axis=0)
    never = [n for n, share in zip(names, seen, strict=True) if share == 0]
    if never:
        state = "look" if len(never) <= MAX_UNSEEN * len(seen) else "bad"
        return Finding(
            "mocap", "markers", state, f"never seen: {', '.join(never)} (covered, or not labelled?)"
        )
    worst = int(np.argmin(seen))
    text = f"{len(names)} markers, all seen; least {names[worst]} ({100 * seen[worst]:.0f} % of the frames)"
    return Finding("mocap", "markers", "well", text)


def _look_at_vent(device: Any, timeout_s: float) -> list[Finding]:
    report = device.vent(timeout_s)
    worst = float(np.max(np.abs(report.pressure_kpa)))
    return [
        Finding(
            "pressure", "vent", "well", f"confirmed in {report.took_s:.1f} s, at most {worst:.2f} kPa left"
        )
    ]


def _without_name(error: DeviceError, role: str) -> str:
    return str(error).removeprefix(f"{role}: ")
