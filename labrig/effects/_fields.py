"""From an effect's coefficients to the change of the observables that they make."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from labrig._turns import quaternions
from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Variant
from labrig.effects._rows import Rows


def _strains() -> Iterator[tuple[str, Floats]]:
    for a, b in ((0, 1), (1, 2), (2, 0)):
        shear = np.zeros((3, 3))
        shear[a, b] = shear[b, a] = 1.0
        yield "xyz"[a] + "xyz"[b], shear
    yield "x - z", np.diag([1.0, 0.0, -1.0])
    yield "y - z", np.diag([0.0, 1.0, -1.0])


STRAINS = dict(_strains())
"""Small symmetric strains (3, 3) that leave the mean scale as it is: shears, and x and y against z."""


def frame_modes(context: Context) -> Floats:
    """How each observable changes under a small rigid motion of the measuring frame, shape (F, K, 6).

    Columns: translations along x, y, z (mm), then rotations about x, y, z through the centre of the markers at
    rest (rad), to first order: dq = t + w x (q - q0).
    """
    rows = context.rows
    F, K = context.base.shape
    modes = np.zeros((F, K, 6))
    where = _places(context)
    for k in range(K):
        m, a = int(rows.marker[k]), int(rows.axis[k])
        if a < 0 or m < 0:
            continue
        modes[:, k, a] = 1.0
        b, c = (a + 1) % 3, (a + 2) % 3
        modes[:, k, 3 + b] = where[:, m, c]
        modes[:, k, 3 + c] = -where[:, m, b]
    return modes


def scale_mode(context: Context) -> Floats:
    """How each observable changes when the measuring frame's scale is off, about `centre_of`, (F, K)."""
    rows = context.rows
    where = _places(context)
    mode = np.zeros_like(context.base)
    for k in np.flatnonzero((rows.axis >= 0) & (rows.marker >= 0)):
        mode[:, k] = where[:, rows.marker[k], rows.axis[k]]
    return mode


def strain_modes(context: Context) -> Floats:
    """How each observable changes when the measuring frame's axes are skew or scaled unlike, (F, K, 5).

    Small symmetric strains without a change of the mean scale, about `centre_of`: xy, yz, zx, and x and y against z.
    """
    rows = context.rows
    where = _places(context)
    modes = np.zeros((*context.base.shape, len(STRAINS)))
    strain = np.array(list(STRAINS.values()))
    for k in np.flatnonzero((rows.axis >= 0) & (rows.marker >= 0)):
        modes[:, k] = where[:, rows.marker[k]] @ strain[:, rows.axis[k]].T
    return modes


def orientation_modes(context: Context) -> Floats:
    """How each quaternion changes when the measuring frame is turned about x, y, z (rad), shape (F, K, 3), to first
    order; zeros of all that is none, or whose real part no name says (``w`` or ``0`` at the end).

    dq = (-w.v / 2, (w q0 + w x v) / 2) of a quaternion (q0, v): J. B. Kuipers, Quaternions and Rotation Sequences,
    Princeton University Press 1999, section 5.
    """
    rows, modes = context.rows, np.zeros((*context.base.shape, 3))
    for own in quaternions(rows.unit, rows.values):
        real = [
            k for k in range(own.start, own.stop) if rows.observables[k].strip().lower().endswith(("w", "0"))
        ]
        if len(real) != 1:
            continue
        vector = [k for k in range(own.start, own.stop) if k != real[0]]
        q0, v = context.base[:, real[0]], context.base[:, vector]
        for a, about in enumerate(np.eye(3)):
            modes[:, real[0], a] = -0.5 * v[:, a]
            modes[:, vector, a] = 0.5 * (q0[:, None] * about + np.cross(about, v))
    return modes


def in_a_plane(rows: Rows) -> tuple[int, ...]:
    """The two axes that markers are seen along, as one camera or scanner sees them; empty where there are not two."""
    axes = tuple(int(a) for a in np.unique(rows.axis[(rows.axis >= 0) & (rows.marker >= 0)]))
    return axes if len(axes) == 2 else ()


def aslant_modes(context: Context) -> tuple[Floats, Floats]:
    """What a camera does that no longer looks square at the plane that it sees, each (F, K, 2), to first order.

    Foreshortening, about `centre_of`: one axis against the other, and a shear. And perspective: what is nearer is
    larger, so that each place is multiplied by itself along one axis, and along the other. With a rigid motion and a
    scale these are all small changes of a plane's view: R. Hartley, A. Zisserman, Multiple View Geometry in Computer
    Vision, 2nd ed., Cambridge University Press, 2004, section 2.4. No markers in a plane: `ValueError`.
    """
    rows = context.rows
    a, b = in_a_plane(rows)
    where = _places(context)
    skew, near = np.zeros((2, *context.base.shape, 2))
    for k in np.flatnonzero((rows.axis >= 0) & (rows.marker >= 0)):
        place = where[:, rows.marker[k]]
        own, other = (a, b) if rows.axis[k] == a else (b, a)
        skew[:, k, 0] = place[:, own] if own == a else -place[:, own]
        skew[:, k, 1] = place[:, other]
        near[:, k] = place[:, [a, b]] * place[:, own, None]
    return skew, near


def distortions(context: Context) -> list[tuple[str, Floats]]:
    """What a lens or a perspective that is off does: squares of the measured place along each axis, and its cube.

    Each (F, K) of size one, root mean square over all.
    """
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    if len(own) < 9:
        return []
    place = _places(context)
    place = place / np.maximum(context.yardstick("body", lambda: np.sqrt((place**2).mean())), 1e-12)
    x, y, z = np.moveaxis(place, 2, 0)
    r2 = (place**2).sum(axis=2)
    out = []
    for name, shape in (
        ("xx", x * x),
        ("yy", y * y),
        ("zz", z * z),
        ("xy", x * y),
        ("yz", y * z),
        ("zx", z * x),
    ):
        for a, letter in enumerate("xyz"):
            change = np.zeros_like(context.base)
            mine = own[rows.axis[own] == a]
            change[:, mine] = shape[:, rows.marker[mine]]
            out.append((f"{name} along {letter}", change))
    radial = np.zeros_like(context.base)
    radial[:, own] = (place * r2[..., None])[:, rows.marker[own], rows.axis[own]]
    out.append(("radial", radial))
    size = context.yardstick("distortions", lambda: np.array([np.sqrt((v**2).mean()) for _, v in out]))
    return [(n, v / s) for (n, v), s in zip(out, size, strict=True) if s > 1e-3]


def travel_of_all(context: Context) -> Floats:
    """How far everything has come out together, (F, 1): the root mean square of what each unit's observables are off
    from the vented position, as a share of the most.
    """
    unit, square = np.array(context.rows.unit), np.zeros(len(context.base))
    for name in dict.fromkeys(context.rows.unit):
        own = (context.displacement[:, unit == name] ** 2).mean(axis=1)
        square += own / np.maximum(context.yardstick(f"farthest, {name}", partial(_most, own)), 1e-300)
    return np.sqrt(square / np.maximum(context.yardstick("farthest", partial(_most, square)), 1e-300))[
        :, None
    ]


def _most(values: Floats) -> Floats:
    return values.max(initial=0.0)


def smooth_places(context: Context) -> Floats:
    """Smooth fields over the body at rest, (K, q): polynomials of degree 0 to 2 of the place, along each axis.

    Each of size one, root mean square over the observables of its axis; none where places at rest are unknown.
    """
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    if rows.rest_mm is None or not np.isfinite(rows.rest_mm).all() or len(own) < 9:
        return np.zeros((len(rows.marker), 0))
    place = rows.rest_mm - rows.rest_mm.mean(axis=0)
    place = place / (np.sqrt((place**2).mean(axis=0)) + 1e-9 * (1 + np.abs(place).max()))
    x, y, z = place.T
    bent = [x * x - (x * x).mean(), y * y - (y * y).mean(), x * y, y * z, z * x]
    fields = []
    for shape in (np.ones_like(x), x, y, z, *bent):
        for a in range(3):
            field = np.zeros(len(rows.marker))
            mine = own[rows.axis[own] == a]
            field[mine] = shape[rows.marker[mine]]
            size = np.sqrt((field[mine] ** 2).mean()) if len(mine) else 0.0
            if size > 1e-3:
                fields.append(field / size)
    return np.array(fields).T if fields else np.zeros((len(rows.marker), 0))


def centre_of(context: Context) -> Floats:
    """The mean place of the markers at rest, mm, (3,): measured, else predicted of the vented rig."""
    if context.centre is not None:
        return context.centre
    rows = context.rows
    centre = np.zeros(3)
    for a in range(3):
        own = np.flatnonzero((rows.axis == a) & (rows.marker >= 0))
        places = [_rest(context, int(k)) for k in own]
        known = [context.base_vented[k] if p is None else p for k, p in zip(own, places, strict=True)]
        if not known and rows.rest_mm is not None:  # an axis that nobody sees
            known = rows.rest_mm[np.isfinite(rows.rest_mm[:, a]), a].tolist()
        centre[a] = np.mean(known) if known else 0.0
    return centre


def _rest(context: Context, observable: int) -> float | None:
    """Where a marker is at rest along the axis of an observable, mm; None where nobody knows."""
    rest, marker = context.rows.rest_mm, context.rows.marker[observable]
    if rest is None or marker >= len(rest):
        return None
    place = float(rest[marker, context.rows.axis[observable]])
    return place if np.isfinite(place) else None


def _places(context: Context) -> Floats:
    """Predicted positions of the markers about their common centre at rest, mm, (F, M, 3); along an axis that nobody
    sees those at rest.
    """
    rows = context.rows
    centre = centre_of(context)
    still = np.zeros((len(rows.markers), 3))
    if rows.rest_mm is not None:
        still = np.where(np.isfinite(rows.rest_mm), rows.rest_mm, 0.0)
    where = np.tile(still - centre, (len(context.base), 1, 1))
    for k in np.flatnonzero((rows.axis >= 0) & (rows.marker >= 0)):
        rest, a = _rest(context, int(k)), rows.axis[k]
        moved = context.base[:, k] if rest is None else rest + context.displacement[:, k]
        where[:, rows.marker[k], a] = moved - centre[a]
    return where


def overlap(context: Context) -> Floats:
    """How much two chambers move the same observables: |J_i| . |J_j|, rows summing to one, shape (C, C).

    J is the mean slope of each chamber alone over its range, so that neighbours are the base's and not the run's.
    """
    reach = np.abs(context.jacobian).mean(axis=0) if context.reach is None else context.reach
    norm = np.linalg.norm(reach, axis=0)
    reach = reach / np.where(norm > 0, norm, 1.0)
    near = reach.T @ reach
    np.fill_diagonal(near, 0.0)
    near = np.where(near > 0.05 * near.max(), near, 0.0)
    total = near.sum(axis=1, keepdims=True)
    return near / np.where(total > 0, total, 1.0)


def contribution(context: Context, variant: Variant, coefficients: Sequence[Floats]) -> Floats:
    """The change of the prediction, shape (F, K), by one array of coefficients for each term.

    A pattern's coefficients have the shape (q, K), a frame's (6,), all others (q,).
    """
    total = np.zeros_like(context.base)
    for term, beta in zip(variant.terms, coefficients, strict=True):
        if term.kind == "pressure":
            total += np.einsum("fkc,fc->fk", context.jacobian, term.feature @ beta)
        elif term.kind == "pattern":
            total += term.feature @ np.reshape(beta, (term.feature.shape[1], -1))
        elif term.kind == "frame":
            total += (frame_modes(context) @ beta) * term.feature[:, None]
        else:
            total += term.feature @ beta
    return total
