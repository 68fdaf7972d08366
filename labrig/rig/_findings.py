"""What fillings say of a rig: tubes that are off or swapped, leaks, and sensors with a wrong zero or scale."""

import numpy as np

from labrig.arrays import Floats
from labrig.rig._chambers import Filling, Fillings
from labrig.rig._config import ChamberConfig, RigConfig
from labrig_drivers import Finding, State

_ZERO_KPA = 1.0
"""How far a sensor may be from the others at ambient: the total error of the boards' sensors, 1.5 % of 100 kPa, is
most of it."""

_BARELY = 0.2
"""A chamber that reaches less of what was asked for is not filled at all."""

_MOST = 0.5
"""Another chamber that reaches more of it is filled in its place."""

_ALIKE = 2.0
"""Chambers that fill so many times faster or slower than the others are worth a look."""

_OFF = 0.1
"""How far, as a share of what was asked for, a chamber may be off in a check: less than while a run goes on."""

_LEAK_PER_MIN = 0.05
"""A chamber that loses more of its pressure in a minute leaks."""

_SIGMAS = 4.0
_MARKER_GAIN = 0.2


def chamber_findings(config: RigConfig, fillings: Fillings) -> list[Finding]:
    """Every chamber with what is wrong with it, or that it is well; one line each, and one for each odd zero."""
    findings = _zeros(config, fillings.rest_kpa)
    delays = [_delay_s(filling, fillings.rest_kpa) for filling in fillings.of]
    fills = [_filled(filling, fillings.rest_kpa) for filling in fillings.of]
    for filling, reached in zip(fillings.of, fills, strict=True):
        others = [d for i, d in enumerate(delays) if i != filling.chamber and np.isfinite(d)]
        usual_s = float(np.median(others)) if others else np.nan
        state, text = _judge(config, filling, reached, fills, (delays[filling.chamber], usual_s))
        findings.append(Finding("pressure", config.chambers[filling.chamber].name, state, text))
    return findings


def _zeros(config: RigConfig, rest_kpa: Floats) -> list[Finding]:
    found = []
    for index, chamber in enumerate(config.chambers):
        others = np.delete(rest_kpa, index)
        common = float(np.nanmedian(others)) if np.isfinite(others).any() else 0.0
        if abs(rest_kpa[index] - common) > _ZERO_KPA:
            text = f"reads {rest_kpa[index]:.1f} kPa when vented, the others {round(common, 1) + 0.0:.1f} kPa"
            text += ": its sensor's zero is off"
            found.append(Finding("pressure", f"{chamber.name}, zero", "bad", text))
    return found


def _filled(filling: Filling, rest_kpa: Floats) -> Floats:
    """What every chamber reached at the beginning of the hold, as a share of what was asked for, (C,)."""
    if filling.refused:
        return np.full(len(rest_kpa), np.nan)
    late = filling.time_s >= filling.held_s - 0.5
    late &= filling.time_s <= filling.held_s + 0.5
    return (np.nanmedian(filling.pressure_kpa[late], axis=0) - rest_kpa) / filling.level_kpa


def _delay_s(filling: Filling, rest_kpa: Floats) -> float:
    """How long the pressure lags on the mean behind what is commanded, s: the area above its rise, less half the ramp.

    A wrong scale of the sensor leaves it as it is. A leak against the same supply shortens it, by the share of the
    pressure that is lost: filling through one conductance and emptying through another ends sooner as well as lower.
    """
    if filling.refused:
        return float("nan")
    end = _filled(filling, rest_kpa)[filling.chamber]
    if not end > _BARELY:
        return float("nan")
    rising = filling.time_s <= filling.held_s
    time_s = filling.time_s[rising]
    share = (
        (filling.pressure_kpa[rising, filling.chamber] - rest_kpa[filling.chamber]) / filling.level_kpa / end
    )
    return max(float(np.trapezoid(1.0 - share, time_s) + time_s[0]) - filling.ramp_s / 2, 0.0)


def _judge(
    config: RigConfig, filling: Filling, reached: Floats, fills: list[Floats], delays: tuple[float, float]
) -> tuple[State, str]:
    index, chambers = filling.chamber, config.chambers
    if filling.refused:
        return "look", f"cannot be filled alone: {filling.refused}"
    if not np.isfinite(reached[index]):
        return "look", "its pressure is not measured: nothing can be said of its tube"
    asked = f"{filling.level_kpa:g} kPa"
    reads = f"{round(reached[index] * filling.level_kpa, 1) + 0.0:.1f} kPa"
    if reached[index] < _BARELY:
        return "bad", _not_filled(chambers, index, reached, fills, asked, reads)
    allowed = _OFF + config.follow.tolerance_kpa / abs(filling.level_kpa)
    rate = _rate_kpa_min(filling)
    loses = -rate * np.sign(filling.level_kpa) > _LEAK_PER_MIN * abs(filling.level_kpa)
    if loses:
        return "bad", f"leaks: it loses {abs(rate):.2g} kPa a minute at {reads}"
    if abs(reached[index] - 1.0) > allowed:
        return "bad", _wrong_level(filling, reached[index], asked, reads, delays)
    beside = config.follow.tolerance_kpa / abs(filling.level_kpa)
    if shared := [n for n, share in enumerate(reached) if n != index and abs(share) > beside]:
        names = ", ".join(f"{chambers[n].name} ({reached[n] * filling.level_kpa:.1f} kPa)" for n in shared)
        return "look", f"{names} rises with it: a line that is shared, or a leak between them"
    own_s, usual_s = delays
    if np.isfinite(usual_s) and not 1 / _ALIKE < (own_s + 0.1) / (usual_s + 0.1) < _ALIKE:
        how = "slower" if own_s > usual_s else "faster"
        text = f"lags {own_s:.1f} s behind on the way to {asked}, the others {usual_s:.1f} s: {how}"
        return "look", f"{text} (another volume, a narrow tube, or its sensor's scale)"
    keeps = "and keeps it" if abs(rate) < 0.05 else f"and changes by {rate:+.1f} kPa a minute"
    return "well", f"reads {reads} of {asked}, lagging {own_s:.1f} s behind, {keeps}"


def _not_filled(
    chambers: tuple[ChamberConfig, ...],
    index: int,
    reached: Floats,
    fills: list[Floats],
    asked: str,
    reads: str,
) -> str:
    """Nothing arrives: somebody else is filled, or nobody is."""
    instead = [n for n, share in enumerate(reached) if n != index and share > _MOST]
    if not instead:
        return f"reads {reads} when {asked} is asked for: its tube is off, its line is shut, or its pump stands still"
    other = instead[0]
    if fills[other][index] > _MOST:
        return f"is swapped with {chambers[other].name}: asking for one fills the other"
    return f"asking for it fills {chambers[other].name}: look where its tube goes"


def _wrong_level(
    filling: Filling, reached: float, asked: str, reads: str, delays: tuple[float, float]
) -> str:
    own_s, usual_s = delays
    scale = f"its sensor's scale is wrong (it reads {reached:.2f} of the pressure)"
    text = f"reads {reads} when {asked} is asked for: "
    if reached > 1.0:
        return text + scale
    rate_kpa_s = (1 - reached) * abs(filling.level_kpa) / max(usual_s, 0.05)
    leak = f"it leaks as fast as it is filled (about {rate_kpa_s:.2g} kPa/s)"
    if not np.isfinite(usual_s) or usual_s < 0.05:
        return f"{text}{leak if reached < 1.0 else ''}, or {scale}"
    return text + (leak if abs(own_s - usual_s * reached) < abs(own_s - usual_s) else scale)


def _rate_kpa_min(filling: Filling) -> float:
    """How fast the held pressure changes, kPa a minute; 0 where that is not told from the sensor's noise."""
    held = filling.time_s > filling.held_s
    time_s, pressure = filling.time_s[held], filling.pressure_kpa[held, filling.chamber]
    if len(time_s) < 5:
        return 0.0
    centred = time_s - time_s.mean()
    slope = float(centred @ pressure / (centred @ centred))
    left = pressure - pressure.mean() - slope * centred
    sigma = float(np.sqrt(left @ left / max(len(left) - 2, 1) / (centred @ centred)))
    return 60.0 * slope if abs(slope) > _SIGMAS * sigma else 0.0


def swapped_markers(config: RigConfig, fillings: Fillings, expected_mm: Floats) -> list[Finding]:
    """Tubes that are swapped between the board and the chambers: only the markers show it.

    `expected_mm` (C, M, 3): how far a model lets the markers move when each chamber is filled as it was.
    """
    seen = [filling for filling in fillings.of if filling.moved_mm is not None]
    likeness = np.array(
        [[_likeness(f.moved_mm, expected_mm[n]) for n in range(len(fillings.of))] for f in seen]
    )
    findings = []
    for row, filling in zip(likeness, seen, strict=True):
        best = int(np.argmax(row))
        if best != filling.chamber and row[best] - row[filling.chamber] > _MARKER_GAIN:
            own, other = config.chambers[filling.chamber].name, config.chambers[best].name
            text = f"asking for {own} moves the markers as filling {other} would: are the tubes swapped?"
            findings.append(Finding("mocap", own, "bad", text))
    if seen and not findings:
        findings.append(
            Finding("mocap", "tubes", "well", "each chamber moves the markers that the model says")
        )
    return findings


def _likeness(moved_mm: Floats | None, expected_mm: Floats) -> float:
    """The cosine between two fields of displacements over the markers that were seen."""
    if moved_mm is None:
        return float("nan")
    known = np.isfinite(moved_mm).all(axis=1)
    a, b = moved_mm[known].ravel(), expected_mm[known].ravel()
    return float(a @ b / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-12))
