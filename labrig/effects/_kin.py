"""Families of the shipped effects (temporary home)."""

from collections.abc import Callable, Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._family import Feature, Space, acting, clocks, field, motion_scale, pattern, pressure
from labrig.effects._rows import Floats
from labrig.effects._fields import frame_modes, overlap, scale_mode


def _play(context: Context, drive: Floats, width: float, rest: float | Floats) -> Floats:
    """The play operator on a drive (E, C) of the events, at the rows (F, C)."""
    state = np.zeros_like(drive)
    for e, before in enumerate(context.started):
        last = state[before] if before >= 0 else rest
        state[e] = np.maximum(drive[e] - width, np.minimum(drive[e] + width, last))
    return state[context.rows.event]


def hysteresis(context: Context) -> Iterator[Space]:
    if not context.moves:
        return
    x, u, span, d, slope = (
        context.rows.fraction,
        context.rows.actuation,
        context.span,
        context.deflection,
        context.deflection_slope,
    )
    out = []
    for r in (0.03, 0.06, 0.12, 0.25, 0.45):
        lag = (context.play(r) - u) / span
        out += [pressure(f"play {r}", lag), pressure(f"play {r} tilted", lag * (2 * x - 1), 0.25)]
        if not context.linear:
            out.append(
                pressure(
                    f"wall play {r}", (_play(context, context.event_deflection, r, 0.0) - d) / slope, 0.7
                )
            )
    out += [pressure("settled", x, 0.1), pressure("settled2", x * x, 0.1), pressure("settled3", x**3, 0.1)]
    if not context.linear:
        out += [pressure("settled wall", d / slope, 0.1), pressure("settled wall2", d * d / slope, 0.1)]
    yield Space("play", "hysteresis", acting(out), 0.8)


def friction(context: Context) -> Iterator[Space]:
    if not context.moves:
        return
    x, u, span = context.rows.fraction, context.rows.actuation, context.span
    turn = -context.direction[context.rows.event]
    out = [
        pressure("direction", turn),
        pressure("direction load", turn * x),
        pressure("direction load2", turn * x**2, 0.25),
    ]
    for r in (0.01, 0.025):
        z = (context.play(r) - u) / span / r
        out += [pressure(f"presliding {r}", z, 0.5), pressure(f"presliding {r} load", z * x, 0.5)]
    yield Space("sliding", "friction", acting(out))


def _memory(context: Context, taus: tuple[float, ...], first: float) -> list[Feature]:
    x, u, span = context.rows.fraction, context.rows.actuation, context.span
    out = []
    for tau in taus:
        lag = (context.relaxed(tau) - u) / span
        out += [
            pressure(f"lag {tau}", lag, 1.0 if tau > first else 0.2),
            pressure(f"lag {tau} tilted", lag * (2 * x - 1), 0.15),
        ]
        if not context.linear:
            wall = context.strained(tau) / span - context.deflection / context.deflection_slope
            out.append(pressure(f"wall {tau}", wall, 0.5))
    return out


def creep(context: Context) -> Iterator[Space]:
    if not context.has_time or not (context.moves or context.has_holds):
        return
    x = context.rows.fraction
    duration = float(np.nanmax(context.elapsed_s) + np.ptp(context.rows.event_time_s))
    taus = tuple(t for t in (2.0, 5.0, 15.0, 50.0, 150.0, 500.0, 1500.0, 5000.0) if t <= 1.5 * duration)
    out = _memory(context, taus, 3.0)
    out += [pressure("settled", x, 0.1), pressure("settled2", x * x, 0.02)]
    square = ((context.rows.event_actuation - context.rows.low) / context.span) ** 2
    for tau in (5.0, 50.0, 500.0):
        if tau in taus:
            out.append(pressure(f"square {tau}", context.lagged(tau, square, 0.0) - x * x, 0.3))
    if not context.linear:
        out.append(pressure("settled wall", context.deflection / context.deflection_slope, 0.05))
    yield Space("retarded", "creep", acting(out), 0.8)


def delay(context: Context) -> Iterator[Space]:
    if not context.has_time or not context.moves:
        return
    out = _memory(context, (0.15, 0.3, 0.6, 1.2, 2.4), 0.0)
    gap = (context.previous[context.rows.event] - context.rows.actuation) / context.span
    for tau in (0.3, 0.6, 1.2, 2.4):
        q = context.elapsed_s[:, None] / tau
        out += [
            pressure(f"second order {tau}", gap * (1 + q) * np.exp(-q), 0.5),
            pressure(f"dead {tau}", gap * (q < 1), 0.3),
        ]
    yield Space("late", "delay", acting(out), 0.8)


def leak(context: Context) -> Iterator[Space]:
    x, t = context.rows.fraction, context.elapsed_s[:, None]
    if np.ptp(t) <= 0:
        return
    out = []
    for tau in (2.0, 6.0, 20.0, 60.0, 200.0, 1000.0, 10000.0):
        lost = -np.expm1(-t / tau)
        out += [
            pressure(f"lost {tau}", -x * lost),
            pressure(f"lost {tau} square", -x * x * lost, 0.3),
            pressure(f"lost {tau} root", -np.sqrt(np.clip(x, 0, None)) * lost, 0.3),
        ]
    yield Space("lost", "leak", acting(out), 0.4)


def regulator(context: Context) -> Iterator[Space]:
    if not context.moves:
        return
    x = context.rows.fraction
    on = (np.abs(context.rows.actuation - context.vented) > 1e-9 * context.span).astype(float)
    out = [
        pressure("gain", x),
        pressure("offset", on, 0.3),
        pressure("zero", np.ones_like(x), 0.3),
        pressure("band 0.04", -np.minimum(x, 0.04), 0.15),
        pressure("band 0.1", -np.minimum(x, 0.1), 0.15),
        pressure("wave 2", on * np.sin(2 * np.pi * x) / np.pi, 0.15),
        pressure("wave 1", on * np.sin(np.pi * x), 0.15),
    ]
    yield Space("settled", "regulator", acting(out), 0.4)


def stiffening(context: Context) -> Iterator[Space]:
    if not context.moves:
        return
    x, d, slope = context.rows.fraction, context.deflection, context.deflection_slope
    far = float(context.travel.max())
    out = [
        pressure("square", x**2),
        pressure("cube", x**3),
        pressure("wall square", d**2 / slope),
        pressure("wall cube", d**3 / slope),
        pressure("wall fifth", d**5 / slope, 0.5),
        pressure("all", x * x.mean(axis=1, keepdims=True), 0.5),
    ]
    if far > 0:
        share = context.travel / far
        out += [
            field(f"travel {n}", context.displacement * share**n, w)
            for n, w in ((1, 0.5), (2, 0.5), (4, 0.25))
        ]
    yield Space("compliance", "stiffening", acting(out), 0.8)


def tension(context: Context) -> Iterator[Space]:
    far = float(context.travel.max())
    if not context.moves or far <= 0:
        return
    out = []
    if not context.linear:
        out += [
            pressure("laplace", context.deflection),
            pressure("laplace wall", context.deflection / context.deflection_slope, 0.3),
        ]
        for r in (0.3, 0.7):
            out += [
                pressure(f"string {r}", context.deflection / np.hypot(context.deflection, r), 0.5),
                pressure(f"fabric {r}", context.deflection / (1 + (context.deflection / r) ** 2), 0.5),
            ]
    for s in (0.1, 0.2, 0.4):
        out.append(field(f"fading {s}", context.displacement / (1 + (context.travel / (s * far)) ** 2), 0.5))
    yield Space("pre-stretch", "tension", acting(out), 0.95)


def contact(context: Context) -> Iterator[Space]:
    if not context.moves:
        return
    x, d, slope = context.rows.fraction, context.deflection, context.deflection_slope
    for limit in (0.35, 0.5, 0.6, 0.7, 0.8, 0.9):
        h, g = np.maximum(x - limit, 0), np.maximum(d - limit, 0)
        out = [
            pressure("pressure", -h, 0.6),
            pressure("wall", -g / slope, 0.6),
            pressure("soft", -(g**1.5) / slope, 0.6),
            pressure("later", -np.maximum(d - limit - 0.1, 0) / slope, 0.3),
            pressure("earlier", -np.maximum(d - limit + 0.1, 0) / slope, 0.3),
        ]
        if (h > 0).mean() >= 0.005 or (g > 0).mean() >= 0.005:
            yield Space(f"limit {limit}", "contact limit", acting(out), 0.2)
    yield from _places(context)


def _places(context: Context) -> Iterator[Space]:
    """Limits in space: travel, planes that markers meet, and posts in the way of some of them."""
    far, rows = float(context.travel.max()), context.rows
    has_axis = (rows.axis >= 0).sum() >= 3 and (rows.marker >= 0).any()
    if far <= 0 or not has_axis:
        return
    move = _by_marker(context, context.displacement)
    length = np.linalg.norm(move, axis=2)
    way = move / np.maximum(length, 1e-9)[..., None]
    for share in (0.3, 0.5, 0.7, 0.85):
        past = np.maximum(length - share * far, 0)
        yield Space(
            f"travel {share}",
            "contact travel",
            acting([field("stop", _to_rows(context, -past[..., None] * way))]),
        )
    for share in (0.35, 0.55, 0.75, 0.9):  # each marker by itself, at a share of its own farthest way
        past = np.maximum(length - share * length.max(axis=0), 0)
        out = []
        for m in range(len(rows.markers)):
            alone = np.zeros_like(move)
            alone[:, m] = -past[:, m, None] * way[:, m]
            out.append(field(f"marker {m}", _to_rows(context, alone)))
        yield Space(f"post {share}", "contact post", acting(out))
    rest = rows.rest_mm
    here = move + (rest[None] if rest is not None and np.isfinite(rest).all() else 0.0)
    main = (move * length[..., None]).sum(axis=(0, 1))
    normals = {"main": main / max(np.linalg.norm(main), 1e-9)}
    for a, letter in enumerate("xyz"):
        for side in (1.0, -1.0):
            if (side * move[:, :, a]).max() > 0.3 * far:
                normals[("+" if side > 0 else "-") + letter] = side * np.eye(3)[a]
    for name, n in normals.items():
        height = here @ n
        out_ = (move @ n) > 0.1 * far
        if out_.mean() < 0.01:
            continue
        across = np.linalg.svd(n[None])[2][1:]
        beside = np.stack([(here - here.mean(axis=(0, 1))) @ t for t in across], axis=2)
        beside /= np.abs(beside).max() + 1e-12
        for share in (40, 65, 85, 95):
            past = np.where(out_, np.maximum(height - np.percentile(height[out_], share), 0), 0.0)
            met = (past > 0).astype(float) * past.max(initial=0.0)
            out = [
                ("back", -past[..., None] * n, 1.0),
                ("own way", -past[..., None] * way, 0.5),
                ("nearer", -met[..., None] * n, 0.1),
            ]
            out += [(f"tilted {j}", -(met * beside[:, :, j])[..., None] * n, 0.3) for j in (0, 1)]
            yield Space(
                f"plane {name} {share}",
                "contact plane",
                acting([field(k, _to_rows(context, v), w) for k, v, w in out]),
            )


def _by_marker(context: Context, values: Floats) -> Floats:
    """Values (F, K) as (F, M, 3), zero along axes that are not seen."""
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    out = np.zeros((len(values), len(rows.markers), 3))
    out[:, rows.marker[own], rows.axis[own]] = values[:, own]
    return out


def _to_rows(context: Context, values: Floats) -> Floats:
    """The reverse of `_by_marker`."""
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    out = np.zeros((len(values), len(rows.marker)))
    out[:, own] = values[:, rows.marker[own], rows.axis[own]]
    return out


def coupling(context: Context) -> Iterator[Space]:
    C = len(context.rows.chambers)
    if C < 2 or not context.moves:
        return
    x, near = context.rows.fraction, overlap(context)
    d, slope = context.deflection, context.deflection_slope
    sat, others = x / (0.3 + x), 1 - np.eye(C)
    both = np.sqrt(np.clip(x[:, :, None] * x[:, None], 0, None))
    out = [
        pressure("all", x * (x @ others) / (C - 1), 0.5),
        pressure("near", x * (x @ near)),
        pressure("near saturating", x * (sat @ near), 0.7),
        pressure("near root", (both * near).sum(axis=2), 0.5),
        pressure("wall near saturating", d * (np.tanh(1.5 * d) @ near) / slope, 0.7),
        pressure("wall near", d * (d @ near) / slope, 0.7),
    ]
    for k in range(1, min(C, 4)):  # each chamber by its k-th nearest neighbour
        order = np.argsort(-near, axis=1)[:, k - 1]
        out.append(pressure(f"neighbour {k}", x * x[:, order]))
    yield Space("together", "coupling", acting(out), 0.6)


def gravity(context: Context) -> Iterator[Space]:
    rows = context.rows
    loads = []
    for name, cov in rows.covariates.items():
        if not np.isfinite(cov.values).all() or np.ptp(cov.values) <= 0:
            continue
        if "load" in name.lower() or "mass" in name.lower():
            loads.append(("load", cov.values / np.abs(cov.values).max()))
        if name.lower() in {"tilt", "orientation", "angle"}:
            angle = np.deg2rad(cov.values) if cov.unit.startswith("deg") else cov.values
            loads += [("sine", np.sin(angle)), ("cosine", np.cos(angle) - np.cos(angle).mean())]
    has_axis = (rows.axis >= 0).sum() >= 3 and (rows.marker >= 0).any()
    out = [pattern(name, values) for name, values in loads]
    if has_axis and context.moves:
        scale = motion_scale(context)
        give = np.abs(context.jacobian * context.span).sum(axis=2)
        for m in np.unique(rows.marker[rows.marker >= 0]):
            own = rows.marker == m
            give[:, own] = give[:, own].mean(axis=1, keepdims=True)
        give = give / np.sqrt((give**2).mean()) * scale
        out += [
            pressure(f"{n} held", np.repeat(v[:, None], len(rows.chambers), axis=1), 0.3) for n, v in loads
        ]
        out += [pressure(f"{n} held load", v[:, None] * rows.fraction, 0.3) for n, v in loads]
        ways = [("own", np.ones(len(give)), 1.0)] + [(n, v, 1.0) for n, v in loads]
        for way, factor, weight in ways:
            for a, letter in enumerate("xyz"):
                own = rows.axis == a
                out.append(field(f"{way} {letter} give", np.where(own, give, 0.0) * factor[:, None], weight))
                out.append(
                    field(f"{way} {letter} even", np.where(own, scale, 0.0) * factor[:, None], 0.25 * weight)
                )
    if out:
        yield Space("weight", "gravity", acting(out))


def drift(context: Context) -> Iterator[Space]:
    rows = context.rows
    ticks = list(clocks(context))
    if not ticks:
        return
    has_axis = (rows.axis >= 0).sum() >= 3 and (rows.marker >= 0).any()
    scale = motion_scale(context)
    if np.ptp(context.displacement) > 0:
        out = [field(n, context.displacement * q[:, None], w) for n, q, w in ticks]
        out += [
            pressure(f"{n} load", q[:, None] * rows.fraction, 0.5 * w) for n, q, w in ticks if context.moves
        ]
        yield Space("gain", "drift gain", acting(out), 0.5)
    if has_axis:
        modes = frame_modes(context)
        size = np.sqrt((modes**2).mean(axis=(0, 1)))
        modes = modes / np.where(size > 0, size, 1.0) * scale[None, :, None]
        out = [
            field(f"{n} {j}", modes[:, :, j] * q[:, None], w * (1.0 if j < 3 else 0.3))
            for n, q, w in ticks
            for j in range(6)
        ]
        yield Space("rigid", "drift rigid", acting(out))
    if context.moves:
        out = [pressure(n, np.repeat(q[:, None], len(rows.chambers), axis=1), w) for n, q, w in ticks]
        yield Space("zero", "drift zero", acting(out), 0.5)
    yield Space("pattern", "drift pattern", acting([pattern(n, q, w) for n, q, w in ticks]))


def frame(context: Context) -> Iterator[Space]:
    rows = context.rows
    if (rows.axis >= 0).sum() < 3:
        return
    scale = motion_scale(context)
    modes = np.concatenate([frame_modes(context), scale_mode(context)[:, :, None]], axis=2)
    size = np.sqrt((modes**2).mean(axis=(0, 1)))
    modes = modes / np.where(size > 0, size, 1.0) * scale[None, :, None]
    names = ("x", "y", "z", "about x", "about y", "about z", "scale")
    whole = [field(n, modes[:, :, j], 1.0 if j < 6 else 0.3) for j, n in enumerate(names)]
    yield Space("always", "frame", acting(whole))
    if len(rows.sessions) > 1:
        out = [
            field(f"{n} session {s}", modes[:, :, j] * (rows.session == s)[:, None])
            for j, n in enumerate(names)
            for s in range(len(rows.sessions))
        ]
        yield Space("by session", "frame by session", acting(out))


def rest_shape(context: Context) -> Iterator[Space]:
    yield Space("shape", "rest_shape", (pattern("rest", np.ones(len(context.base))),))


KIN: dict[str, Callable[[Context], Iterator[Space]]] = {
    f.__name__: f
    for f in (
        hysteresis,
        friction,
        creep,
        delay,
        leak,
        regulator,
        stiffening,
        tension,
        contact,
        coupling,
        gravity,
        drift,
        frame,
        rest_shape,
    )
}


def _more_steps(e: Floats, first: int) -> list[int]:
    """Where the two pieces beside a first step are best cut again."""
    out = []
    for begin, end in ((0, first + 1), (first + 1, len(e))):
        piece = e[begin:end]
        if len(piece) < 8:
            continue
        n = np.arange(1, len(piece))
        gain = (
            (np.cumsum(piece - piece.mean(axis=0), axis=0)[:-1] ** 2).sum(axis=1)
            * len(piece)
            / (n * (len(piece) - n))
        )
        out.append(begin + int(np.argmax(gain[2:-2])) + 2)
    return out


def marker_slip(context: Context) -> Iterator[Space]:
    """The clearest moments at which one marker leaves the others, three at most."""
    rows = context.rows
    markers = np.unique(rows.marker[rows.marker >= 0])
    captures, first = np.unique(rows.capture, return_index=True)
    if len(captures) < 8 or len(markers) < 4:
        return
    from labrig.diagnosis._spectrum import fill

    residual = context.residual
    seen = np.isfinite(residual)
    error = np.stack(
        [
            np.where(seen[rows.capture == c], residual[rows.capture == c], 0).sum(axis=0)
            / np.maximum(seen[rows.capture == c].sum(axis=0), 1)
            for c in captures
        ]
    )
    error[np.stack([~seen[rows.capture == c].any(axis=0) for c in captures])] = np.nan
    error = fill(error)
    scale = motion_scale(context)
    found = []
    for m in markers:
        own = rows.marker == m
        A = error[:, ~own]
        _, U = np.linalg.eigh(A.T @ A)
        Z = np.column_stack([A @ U[:, -min(6, A.shape[1]) :], np.ones(len(A))])
        ridge = 1e-2 * np.trace(Z.T @ Z) / len(Z.T) * np.eye(Z.shape[1])
        e = error[:, own] - Z @ np.linalg.solve(Z.T @ Z + ridge, Z.T @ error[:, own])
        e -= np.median(e, axis=0)
        spread = 1.4826 * np.median(np.abs(np.diff(e, axis=0))) / np.sqrt(2) + 1e-12
        e = np.clip(e / spread, -30, 30)
        n = np.arange(1, len(e))
        gain = (np.cumsum(e - e.mean(axis=0), axis=0)[:-1] ** 2).sum(axis=1) * len(e) / (n * (len(e) - n))
        gain[:3] = gain[-3:] = 0
        i = int(np.argmax(gain))
        found.append(
            (float(gain[i]), int(m), int(captures[i + 1]), [int(captures[j + 1]) for j in _more_steps(e, i)])
        )
    for _, m, since, others in sorted(found, reverse=True)[:3]:
        after = rows.capture >= since
        ramp = np.clip((rows.capture - since) / max(captures[-1] - since, 1), 0, None)
        out = []
        for k in np.flatnonzero(rows.marker == m):
            e = np.zeros(context.base.shape[1])
            e[k] = scale[k]
            out += [
                field(f"step {rows.axis[k]}", after[:, None] * e),
                field(f"slide {rows.axis[k]}", ramp[:, None] * e, 0.3),
            ]
            out += [
                field(f"step {rows.axis[k]} {i}", (rows.capture >= o)[:, None] * e, 0.3)
                for i, o in enumerate(others)
            ]
        yield Space(
            f"marker {m} since {since}", "marker_slip", tuple(out), scanned=len(markers) * len(captures)
        )


KIN["marker_slip"] = marker_slip
