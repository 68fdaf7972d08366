"""labrig's own sim-to-real correction: the field between the two, from markers, from scans, or from both."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.surface import identity_coefficients
from labrig.surrogate._captures import Frames, Shot
from labrig.surrogate._corrected import CorrectedHead
from labrig.surrogate._field import Posterior, Seen, infer
from labrig.surrogate._field_settings import Places, Settings, Spatial, fit_settings, places_of
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._left_out import factor_of, left_out, rough_of
from labrig.surrogate._scans import Matched, confidence_map, match
from labrig.surrogate._unseen import by_gain
from labrig.surrogate._warp_heads import FieldHead
from labrig.surrogate._warped import Doubt, WarpedModel

GAIN_SD = 0.1
"""How far a chamber's pressure may count for more or less than simulated, before anything was seen."""
_RELINEARISED = 2
_MATCHINGS = 5
_AGAIN = 2
"""The matching after which settings are fitted again, where there are scans alone."""
PLACES_ACROSS = 13
"""Places of the surface, in each direction, at which scans are looked at."""
SCAN_PRECISION = 0.1
"""Of one such place, relative to a marker: a scanner is less exact, and its neighbours say nearly the same."""


@dataclass(frozen=True)
class Correction:
    """A corrected model, and how far it was off, mm, (J, Q), at places and frames that were left out of it.

    NaN where nothing was seen, or nothing could be left out. The places are the markers, or those of scans alone.
    """

    model: WarpedModel
    left_out_mm: Floats
    facts: dict[str, Any]


def learn_correction(
    forward: ForwardModel, frames: Frames | None, shots: list[Shot], gain_sd: float = GAIN_SD
) -> Correction:
    """Learn the field from the markers of `frames`, from scans, or from both, in the simulator's frame."""
    marker_uv = forward.markers(frames.marker_names) if frames is not None else np.zeros((0, 2))
    scan_uv = _scan_places() if shots else np.zeros((0, 2))
    uv = np.concatenate([marker_uv, scan_uv])
    pressure, of_frame, of_shot = _set_points(frames, shots)
    places = places_of(forward, uv, np.repeat([1.0, SCAN_PRECISION], [len(marker_uv), len(scan_uv)]))
    gain = np.ones(len(forward.chamber_names))
    settings, matched, posterior, covariance = None, None, None, np.zeros((0, 0))
    seen = None
    for step in range(_MATCHINGS if shots else _RELINEARISED):
        counted = forward.low_kpa + gain * (pressure - forward.low_kpa)
        simulated = forward.points(counted, uv)
        directions = by_gain(forward, gain, pressure, uv)
        from_gain = np.tensordot(gain - 1.0, directions, axes=1)
        value = np.full(simulated.shape, np.nan)
        known = np.zeros((*simulated.shape, 3))
        if frames is not None:
            _put_markers(frames, of_frame, simulated, value, known)
        if shots:
            moved = simulated if posterior is None else simulated + posterior.expected - from_gain
            matched = match(shots, moved[of_shot][:, len(marker_uv) :])
            _put_scans(matched, of_shot, len(marker_uv), simulated, value, known)
        seen = Seen(
            forward.fraction(pressure),
            value + from_gain,  # directions count from a gain of one
            known,
            directions,
            np.full(len(gain), gain_sd),
        )
        if settings is None or (frames is None and step == _AGAIN):
            settings = _settings(seen, places, len(marker_uv), of_frame, of_shot, settings)
            covariance = places.covariance(settings)
        start = None if posterior is None else posterior.weights
        posterior = infer(seen, covariance, places.precision, settings, start)
        gain = 1.0 + posterior.theta
    assert posterior is not None
    assert seen is not None
    return _correction(forward, places, uv, pressure, posterior, seen, covariance, len(marker_uv), matched)


def _settings(
    seen: Seen,
    places: Places,
    markers: int,
    of_frame: NDArray[np.int64],
    of_shot: NDArray[np.int64],
    start: Settings | None,
) -> Settings:
    """Settings from the markers; without any, from what the scans say along the mean normal of each place."""
    rows = of_frame if markers else of_shot
    own = slice(0, markers) if markers else slice(markers, None)
    value, directions = seen.value_mm[rows][:, own], seen.directions[:, rows][:, :, own]
    count = value.shape[1]
    part = Places(
        places.modes[: 3 * count] if markers else places.modes[3 * markers :],
        places.size,
        places.middle_mm[own],
        places.precision[own],
    )
    along = np.zeros((0, 3))
    if markers:
        seen_here = np.where(
            np.trace(seen.known[rows][:, own], axis1=2, axis2=3)[..., None] > 2, value, np.nan
        )
        flat = seen_here.reshape(len(rows), -1)
    else:
        along = _normals(seen, rows, own)
        known = np.einsum("jqab,jqb->jqa", seen.known[rows][:, own], np.nan_to_num(value))
        flat = np.einsum("jqa,qa->jq", known, along)
        flat[np.trace(seen.known[rows][:, own], axis1=2, axis2=3) < 0.5] = np.nan
    root = np.repeat(np.sqrt(part.precision), 3 if markers else 1)
    flat_directions = (
        directions.reshape(len(directions), len(rows), -1)
        if markers
        else np.einsum("djqa,qa->djq", directions, along)
    )

    def spatial(tried: Settings) -> Spatial:
        covariance = part.covariance(tried)
        if not markers:
            of_place = np.einsum("qa,qab->qb", along, covariance.reshape(count, 3, -1))
            covariance = np.einsum("qrb,rb->qr", of_place.reshape(count, count, 3), along)
        return Spatial(covariance, root)

    iterations = 15 if markers else 6
    return fit_settings(
        seen.x[rows], flat * root, flat_directions * root, seen.direction_sd, spatial, start, iterations
    )


def _normals(seen: Seen, rows: NDArray[np.int64] | slice, own: slice) -> Floats:
    """The direction (Q, 3), of length one, along which scans saw each place, on average."""
    return np.ascontiguousarray(np.linalg.eigh(seen.known[rows][:, own].mean(axis=0))[1][:, :, -1])


def _set_points(
    frames: Frames | None, shots: list[Shot]
) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """All set-points (J, C), a scan sharing one with the frame at the same pressures; rows of frames and scans."""
    rows: list[Floats] = [] if frames is None else list(frames.pressure_kpa)
    of_shot = []
    for shot in shots:
        same = [j for j, row in enumerate(rows) if np.abs(row - shot.pressure_kpa).max() < 1e-6]
        of_shot.append(same[0] if same else len(rows))
        if not same:
            rows.append(shot.pressure_kpa)
    count = 0 if frames is None else len(frames)
    return np.array(rows), np.arange(count), np.array(of_shot, dtype=np.int64)


def _scan_places() -> Floats:
    """Places evenly over the surface, none on its border."""
    line = (np.arange(PLACES_ACROSS) + 0.5) / PLACES_ACROSS
    return np.stack(np.meshgrid(line, line, indexing="xy"), axis=-1).reshape(-1, 2)


def _put_markers(
    frames: Frames, rows: NDArray[np.int64], simulated: Floats, value: Floats, known: Floats
) -> None:
    count = len(frames.marker_names)
    value[rows, :count] = frames.position_mm - simulated[rows, :count]
    known[rows, :count] = frames.captured[:, :, None, None] * np.eye(3)


def _put_scans(
    matched: Matched, rows: NDArray[np.int64], first: int, simulated: Floats, value: Floats, known: Floats
) -> None:
    for shot, row in enumerate(rows):
        normal = matched.normal[shot]
        value[row, first:] = matched.foot_mm[shot] - simulated[row, first:]
        known[row, first:] = (normal[:, :, None] * normal[:, None, :]) * matched.found[shot][:, None, None]


def _correction(
    forward: ForwardModel,
    places: Places,
    uv: Floats,
    pressure: Floats,
    posterior: Posterior,
    seen: Seen,
    covariance: Floats,
    markers: int,
    matched: Matched | None,
) -> Correction:
    settings, x, gain = posterior.settings, seen.x, 1.0 + posterior.theta
    kernel = settings.kernel(x.shape[1])
    still, moving = settings["still"] ** 2, settings["moving"] ** 2
    flat = posterior.weights.reshape(len(x), -1)
    latent = flat @ places.modes * places.latent_prior(settings["shape_power"])
    head = CorrectedHead(forward.head, gain, kernel, x, still * latent.sum(axis=0), moving * latent)
    own = _coefficients(places, posterior.weights, settings)
    identity = identity_coefficients(len(uv))
    field_head = FieldHead(kernel, x, identity + still * own.sum(axis=0), moving * own)
    left = left_out(seen, covariance, places.precision, posterior)
    simulated_mm = forward.sd_mm(pressure, uv)
    model = WarpedModel(
        replace(forward, head=head),
        uv,
        settings["c"],
        field_head,
        factor=factor_of(left, seen, places.precision, settings["noise_mm"], simulated_mm),
        doubt=Doubt(
            settings.values,
            places.precision,
            seen.direction_sd,
            rough_of(left),
            None if markers else _normals(seen, slice(None), slice(None)),
        ),
    )
    if matched is not None:
        model = replace(model, confidence=confidence_map(matched, left.both_mm[:, markers:]))
    facts = {"gain": gain.tolist(), "settings": settings.facts(), "set_points": len(x)}
    return Correction(model, left.both_mm[:, :markers] if markers else left.both_mm, facts)


def _coefficients(places: Places, weights: Floats, settings: Any) -> Floats:
    """Coefficients (J, Q + 4, 3) of the smooth part of the field that each frame's weights (J, Q, 3) stand for."""
    centred = places.middle_mm.mean(axis=0)
    linear = settings["affine"] ** 2 * np.einsum("qk,jqd->jkd", places.affine(), weights)
    turn = linear[:, 1:] / places.extent_mm
    still = linear[:, :1] - np.einsum("k,jkd->jd", centred, turn)[:, None]
    return np.concatenate([still, turn, settings["bells"] ** 2 * weights], axis=1)
