"""What no name explains: the base's own error of form, and unnamed structure, on the same scale as effects."""

from collections.abc import Collection, Iterator

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.diagnosis._handover import handovers
from labrig.diagnosis._sudden import sudden
from labrig.effects import (
    Context,
    Feature,
    Space,
    acting,
    affine,
    by_covariate,
    distortions,
    field,
    frame_modes,
    motion_scale,
    pattern,
    pressure,
    scale_mode,
)

FORM = "form"
"""The base's own error of form: each chamber's deflection, in a pattern of its own."""
LEVER = "lever"
"""The base's own error of form where chambers act at other places than the base has them."""


_MOST_WAVES = 40
"""Slow functions of time, at most: it bounds the columns."""
_FEWEST_EVENTS = 4
"""Actuations from which on use can be told from anything else."""


def unnamed(context: Context, followed: Collection[str] = ()) -> Iterator[Space]:
    """The spaces that have no name, each by what carries it; `key` says it in words. What follows a covariate that is
    `followed` by an effect is that effect.
    """
    if context.moves:
        yield from _by_pressure(context)
        yield from _history(context)
        yield from _use(context)
    yield from _covariates(context, followed)
    yield from handovers(context)
    yield from sudden(context)
    yield from _place(context)
    yield from _in_hold(context)
    yield from _slow(context)


def _by_pressure(context: Context) -> Iterator[Space]:
    """What goes by the set-point: the base's errors of form, what pressures do together, and through other chambers."""
    x, d = context.rows.fraction, context.deflection
    C = x.shape[1]
    columns = [pattern(f"deflection {c}", d[:, c]) for c in range(C)]
    columns += [pattern(f"deflection2 {c}", d[:, c] ** 2, 0.3) for c in range(C)]
    columns += [pattern(f"pressure {c}", x[:, c], 0.3) for c in range(C)]
    yield Space(FORM, FORM, acting(columns))
    together = "pressures together" if C > 1 else "another curve of the pressure"
    yield Space(together, "static", acting(list(_static(x))))
    yield from _lever(context)
    yield from _cross(x)


def _place(context: Context) -> Iterator[Space]:
    """What is always there: at each place, as one body that was moved, as through a lens."""
    rows = context.rows
    yield Space("place", "place", (pattern("always", np.ones(len(rows.capture))),))
    if (rows.axis >= 0).sum() >= 3:
        modes = np.concatenate([frame_modes(context), scale_mode(context)[:, :, None]], axis=2)
        size = np.sqrt((modes**2).mean(axis=(0, 1))) + 1e-12
        body = [field(f"mode {j}", modes[:, :, j] / size[j]) for j in range(7)]
        yield Space("place, as one body", "rigid", acting(body))
        lens = [*affine(context), *(field(n, motion_scale(context) * v) for n, v in distortions(context))]
        yield Space("place, as through a lens", "lens", acting(lens))


def _in_hold(context: Context) -> Iterator[Space]:
    """What goes by the time in the hold."""
    if not context.has_holds:
        return
    x, held = context.rows.fraction, np.log1p(context.elapsed_s)
    held = held - held.mean()
    columns = [pattern("log time", held), pattern("log time 2", held**2, 0.3)]
    if context.moves:
        columns += [pattern(f"log time x {c}", held * x[:, c]) for c in range(x.shape[1])]
    yield Space("time in hold", "hold", acting(columns))


def _slow(context: Context) -> Iterator[Space]:
    """What goes by the time, slowly: at each place, and through the pressures of all chambers."""
    rows, x = context.rows, context.rows.fraction
    if not np.isfinite(rows.time_s).all() or np.ptp(rows.time_s) <= 0:
        return
    t = (rows.time_s - rows.time_s.min()) / np.ptp(rows.time_s)
    many = int(np.clip(_told_apart(context), 2, _MOST_WAVES))
    waves = {k: np.cos(np.pi * k * t) for k in range(1, many)}
    load = x.mean(axis=1)
    columns = [pattern(f"cosine {k}", wave) for k, wave in waves.items()]
    columns += [pattern(f"cosine {k} load", wave * load, 0.5) for k, wave in waves.items() if k % 2]
    yield Space("time", "time", acting(columns))
    if context.moves:
        through = [
            pressure(f"cosine {k}", np.repeat(wave[:, None], x.shape[1], axis=1)) for k, wave in waves.items()
        ]
        yield Space("time through the pressures", "clock", acting(through), 0.8)


def _told_apart(context: Context) -> float:
    """How many slow functions of time can be told from what the pressures do.

    A third of the captures. Of a record of single rows, which follow one another, as many as it has full strokes: of
    random set-points that is a third of them, too.
    """
    rows = context.rows
    most = rows.n_captures / 3
    if len(rows.capture) > rows.n_captures:
        return most
    u = rows.event_actuation
    way, reach = np.abs(np.diff(u, axis=0)).sum(axis=0), np.ptp(u, axis=0)
    strokes = way[reach > 0] / reach[reach > 0]
    return min(most, float(strokes.mean())) if len(strokes) else most


def _static(x: Floats) -> Iterator[Feature]:
    """Functions of the set-point that the base's deflections do not hold: products, hinges, steps, random waves."""
    C = x.shape[1]
    for i in range(C):
        for j in range(i):
            yield pattern(f"product {i} {j}", x[:, i] * x[:, j])
        yield pattern(f"hinge {i}", np.maximum(x[:, i] - 0.5, 0), 0.5)
        yield pattern(f"step {i}", np.tanh((x[:, i] - 0.3) / 0.1), 0.3)
    random = np.random.default_rng(0)
    for k in range(16):
        way = 2 * random.normal(size=C) / np.sqrt(C)
        yield pattern(f"wave {k}", np.cos(2 * x @ way + random.uniform(0, 2 * np.pi)), 0.3)


def _lever(context: Context) -> Iterator[Space]:
    """Where each chamber acts: its own motion times a parabola of the place, as when its patch lies elsewhere.

    The derivative of a bell by its middle or its width is the bell times such a polynomial.
    """
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    if rows.rest_mm is None or not np.isfinite(rows.rest_mm).all() or len(own) < 9:
        return
    moved = context.jacobian * (rows.actuation - context.vented)[:, None, :]
    place = np.zeros((len(rows.marker), 3))
    place[own] = rows.rest_mm[rows.marker[own]]
    out = []
    for c, name in enumerate(rows.chambers):
        weight = (moved[:, :, c] ** 2).mean(axis=0)
        if weight.sum() <= 0:
            continue
        middle = (weight[:, None] * place).sum(axis=0) / weight.sum()
        away = place - middle
        size = np.sqrt((weight[:, None] * away**2).sum(axis=0) / weight.sum())
        for a, letter in enumerate("xyz"):
            if size[a] <= 1e-3 * size.max():  # a flat body, or one place alone
                continue
            z = away[:, a] / size[a]
            out.append(field(f"{name} along {letter}", moved[:, :, c] * z))
            out.append(field(f"{name} wide {letter}", moved[:, :, c] * (z**2 - 1), 0.5))
    if out:
        yield Space("where chambers act", LEVER, acting(out))


def _cross(x: Floats) -> Iterator[Space]:
    """What the others' pressures do through each chamber."""
    C = x.shape[1]
    if C > 1:
        other = [(k, np.roll(x, k, axis=1)) for k in range(1, C)]
        out = [pressure(f"chamber + {k}", y, 0.5) for k, y in other]
        out += [pressure(f"chamber + {k} load", x * y) for k, y in other]
        yield Space("other chambers through the pressures", "cross", acting(out), 0.5)


def _use(context: Context) -> Iterator[Space]:
    """How much each chamber has been moved so far, and how often any: wear, fatigue, running in."""
    rows = context.rows
    x, moved = rows.fraction, np.abs((rows.event_actuation - context.previous) / context.span)
    travel = np.cumsum(moved, axis=0)
    if len(travel) < _FEWEST_EVENTS or travel.max() <= 0:
        return
    often = np.cumsum((moved > 0).any(axis=1))[:, None] * np.ones_like(travel)
    out = []
    for name, used in (("travel", travel / travel.max()), ("moves", often / often.max())):
        for power in (0.5, 1.0):
            own = (used**power)[rows.event]
            out += [
                pressure(f"{name} {power}", own, 0.3),
                pressure(f"{name} {power} load", own * x),
                pressure(f"{name} {power} load2", own * x * x, 0.3),
            ]
        early = -np.expm1(-used / 0.1)[rows.event]
        out.append(pressure(f"{name} early load", early * x, 0.5))
    yield Space("use so far through the pressures", "use", acting(out), 0.6)


def _covariates(context: Context, followed: Collection[str]) -> Iterator[Space]:
    """What follows something else that was recorded, at any place, and by the load: what a change of it makes, from
    none where it is nothing at times, else from its mean. What follows what is `followed` is an effect's.
    """
    out = []
    rows = context.rows
    x = rows.fraction
    has_axis = (rows.axis >= 0).sum() >= 3
    modes = frame_modes(context) if has_axis else np.zeros((*context.base.shape, 0))
    modes = modes / (np.sqrt((modes**2).mean(axis=(0, 1))) + 1e-12) * motion_scale(context)[:, None]
    for name, cov in rows.covariates.items():
        if name in followed or not np.isfinite(cov.values).all() or np.ptp(cov.values) <= 0:
            continue
        out += by_covariate(context, name, (cov.values - cov.values.mean()) / np.ptp(cov.values))
        if not context.moves:
            continue
        at_times_none = cov.values.min() <= 0 <= cov.values.max()
        change = cov.values - (0.0 if at_times_none else cov.values.mean())
        whole = (change / np.abs(change).max())[:, None]
        body = [field(f"mode {j}", modes[:, :, j] * whole, 0.5) for j in range(modes.shape[2])]
        held = [pressure("held", np.repeat(whole, x.shape[1], axis=1)), pressure("held load", whole * x)]
        yield Space(f"{name}, as one body", "along", acting([*held, *body]))
    if out:
        yield Space("what was recorded beside", "beside", acting(out))


def _history(context: Context) -> Iterator[Space]:
    """What goes by what each chamber did before: the set-point before, the highest so far, the last that moved.

    All of it is counted from a vented chamber, wherever the range begins.
    """
    rows, event = context.rows, context.rows.event
    x = (rows.actuation - context.vented) / context.span
    mover, most, ever = (each[event] for each in _so_far(context))
    gap = ((context.previous - context.vented) / context.span)[event] - x
    held = context.elapsed_s[:, None]
    through = [
        pressure("peak", most - x),
        pressure("peak square", most**2 - x**2),
        pressure("peak load", (most - x) * x),
        pressure("gap", gap),
        pressure("gap load", gap * x),
        pressure("gap size", np.abs(gap), 0.5),
        pressure("gap fading", gap * np.exp(-held / 10), 0.5),
        pressure("mover", mover * x, 0.5),
        pressure("load in hold", x * np.log1p(held), 0.5),
        pressure("ever", ever, 0.5),
        pressure("ever load", ever * x, 0.5),
    ]
    if context.has_time:
        lags = [(tau, (context.relaxed(tau) - rows.actuation) / context.span) for tau in (8.0, 60.0, 400.0)]
        through += [pressure(f"lag {tau}", lag, 0.5) for tau, lag in lags]
    yield Space("history through the pressures", "through", acting(through))
    C = x.shape[1]
    columns = [pattern(f"gap {c}", gap[:, c]) for c in range(C)]
    columns += [pattern(f"mover {c}", mover[:, c] - mover[:, c].mean()) for c in range(C) if C > 1]
    columns += [pattern(f"peak {c}", (most - x)[:, c]) for c in range(C)]
    columns += [pattern(f"direction {c}", context.direction[event][:, c], 0.5) for c in range(C)]
    columns += [pattern(f"ever {c}", ever[:, c], 0.5) for c in range(C)]
    columns += [pattern(f"switch {i}", state[event], 0.5) for i, state in enumerate(_switches(context))]
    yield Space("history", "history", acting(columns))


def _so_far(context: Context) -> tuple[Floats, Floats, Floats]:
    """For each event and chamber (E, C): whether it was the last that moved, 0 or 1; its highest share of the range so
    far, which fades with a time constant of a minute where the times are known; and the highest ever.
    """
    rows = context.rows
    level = (rows.event_actuation - context.vented) / context.span
    change = np.abs((rows.event_actuation - context.previous) / context.span)
    last, peak, ever = np.zeros_like(change), np.zeros_like(change), np.zeros_like(change)
    for e, before in enumerate(context.started):
        if change[e].max() > 1e-9:
            last[e, change[e].argmax()] = 1.0
        elif before >= 0:
            last[e] = last[before]
        fade = 1.0
        if before >= 0 and context.has_time:
            fade = np.exp(-max(rows.event_time_s[e] - rows.event_time_s[before], 0) / 60.0)
        ever[e] = np.maximum(level[e], ever[before] if before >= 0 else 0.0)
        peak[e] = np.maximum(level[e], peak[before] * fade if before >= 0 else 0.0)
    return last, peak, ever


def _switches(context: Context) -> Iterator[np.ndarray]:
    """States (E,) that go over at a high load of all chambers together and come back at a low one."""
    load = (context.rows.event_actuation / context.span).mean(axis=1)
    for low, high in ((0.2, 0.5), (0.35, 0.65), (0.5, 0.8)):
        back, over = np.quantile(load, low), np.quantile(load, high)
        state = np.zeros(len(load))
        for e, b in enumerate(context.started):
            before = state[b] if b >= 0 else 0.0
            state[e] = 1.0 if load[e] >= over else 0.0 if load[e] <= back else before
        yield state


def slow_noise(index: Ints) -> Floats:
    """Slow noise that captures share with their neighbours, AR(1) of 0.9 a capture: (F, q), of unit variance together.
    `index` (F,) numbers the captures.
    """
    n = int(index.max()) + 1
    knots = np.linspace(0, n - 1, int(np.clip(n // 6, 4, 45)))
    hats = np.clip(1 - np.abs(np.arange(n)[:, None] - knots) / max(knots[1] - knots[0], 1e-9), 0, None)
    memory = np.exp(-np.abs(knots[:, None] - knots) / 9.5)
    return (hats @ np.linalg.cholesky(memory + 1e-9 * np.eye(len(knots))))[index]
