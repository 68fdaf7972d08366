"""An effect as a family of laws: a space of functions with a prior, wide enough for every published law of its kind."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._logged import is_temperature

FeatureKind = Literal["pressure", "field", "pattern"]


@dataclass(frozen=True)
class Feature:
    """One direction in which the members of a family differ.

    `kind` says what `values` is, for F rows, K observables, C chambers: `pressure` (F, C), a change of each chamber's
    pressure as a fraction of its range, one weight common to all chambers and one more for each; `field` (F, K), a
    change of the observables in their own units, where 1 is of the size of the rig's whole motion; `pattern` (F,), of
    order one, with a weight for each observable. `weight` is the prior variance of its coefficient before anything
    was learnt.
    """

    name: str
    kind: FeatureKind
    values: Floats
    weight: float = 1.0


@dataclass(frozen=True)
class Space:
    """A space of functions with one prior: features, and the name under which their covariance was learnt.

    An effect whose members differ in kind (a limit at one place or another) has several spaces; only one of them holds.
    """

    key: str
    spectrum: str
    features: tuple[Feature, ...]
    alike: float = 0.7
    """Share of the variance that all chambers have in common, before anything was learnt."""
    scanned: int = 0
    """Among how many places this one was found by a scan of the residuals; 0 where none was."""
    absolute: bool = True
    """Whether its functions mean the same on every run, by the yardsticks of the one that they were fitted to."""
    plain: bool = False
    """Whether it is one form alone: all of these together are as likely as the family's spaces together."""
    apart: Floats | None = None
    """Groups of observables (n, K), 1 or 0, in each of which it acts by itself; None where it acts in all as one."""
    alone_in: str = ""
    """The chamber, or session, that it is about alone; empty where it is about all."""
    rarer: float = 1.0
    """How many times less probable it is than a space of its kind, as it stands for one of several: itself in all
    chambers and sessions, or in any single one of them."""
    stays: bool = False
    """Whether it acts also where its effect was ruled out, so that it is something else which does the same."""
    along: Feature | None = None
    """What its change can only go along, never against, as a whole: a stop holds back. Of the kind of its features,
    pressures or fields; None where it may go either way.
    """


def motion_scale(context: Context) -> Floats:
    """The size of the rig's whole motion for each observable, (K,): one number for all that share a unit.

    The root mean square of the predicted displacement; where nothing moves, of what full pressures would do; where the
    base does not move at all, of the residual.
    """
    unit = np.array(context.rows.unit)
    scale = np.zeros(len(unit))
    sizes: tuple[Callable[[], Floats], ...] = (
        lambda: context.displacement,
        lambda: (context.jacobian * context.span).sum(axis=2),  # asked for by few rigs, and large
        lambda: np.nan_to_num(context.residual),
    )

    def of(own: NDArray[np.bool_]) -> Floats:
        each = (np.sqrt((size()[:, own] ** 2).mean()) for size in sizes)
        return np.array(next((value for value in each if value > 0), 1.0))

    for name in dict.fromkeys(context.rows.unit):
        own = unit == name
        scale[own] = context.yardstick(f"motion, {name}", partial(of, own))
    return scale


def pressure(name: str, values: Floats, weight: float = 1.0) -> Feature:
    """A change of each chamber's pressure, fraction of its range, (F, C)."""
    return Feature(name, "pressure", values, weight)


def field(name: str, values: Floats, weight: float = 1.0) -> Feature:
    """A change of the observables themselves, (F, K)."""
    return Feature(name, "field", values, weight)


def pattern(name: str, values: Floats, weight: float = 1.0) -> Feature:
    """A change whose shape over the observables is free, (F,)."""
    return Feature(name, "pattern", values, weight)


def one_way(space: Space) -> Space:
    """The same, where all features have the sign that they must have: it acts along their sum, weighted.

    Raises `ValueError` unless all of them are pressures, or all of them fields: a pattern is free, so it has no sign.
    """
    kinds = {f.kind for f in space.features}
    if not kinds:
        return space
    if len(kinds) > 1 or "pattern" in kinds:
        raise ValueError(
            f"space {space.key!r}: one_way takes pressures only, or fields only, not {sorted(kinds)}"
        )
    total = np.sum([f.weight * f.values for f in space.features], axis=0)
    return replace(space, along=Feature("all of them", space.features[0].kind, total))


def acting(features: list[Feature]) -> tuple[Feature, ...]:
    """Only those features that are not zero everywhere."""
    return tuple(
        f for f in features if np.isfinite(f.values).all() and np.abs(f.values).max(initial=0.0) > 1e-12
    )


def clocks(context: Context) -> Iterator[tuple[str, Floats, float]]:
    """Slow functions of the session's time, of the time over all sessions and of temperatures: name, values, weight.

    All are nothing where they begin: what has drifted has done so since then.
    """
    rows = context.rows
    for label, time in (("session", context.session_time_s), ("run", rows.time_s - rows.time_s.min())):
        end = float(np.max(time)) if np.isfinite(time).all() else 0.0
        if end <= 0 or (label == "run" and len(rows.sessions) < 2):
            continue
        t = time / end
        yield f"{label} linear", t, 1.0
        yield f"{label} warm-up 0.1", -np.expm1(-t / 0.1), 0.1
        yield f"{label} warm-up 0.3", -np.expm1(-t / 0.3), 0.5
        for k in range(1, 9):
            yield f"{label} cosine {k}", np.cos(np.pi * k * t) - 1, 0.3 / k**2
    for _, warmer in temperatures(context):
        yield "temperature", warmer, 1.0


def temperatures(context: Context) -> Iterator[tuple[str, Floats]]:
    """Of each temperature that was logged its name, and by how much it is warmer than at first, share of its range."""
    for name, cov in context.rows.covariates.items():
        if is_temperature(name, cov) and np.isfinite(cov.values).all() and np.ptp(cov.values) > 0:
            yield name, (cov.values - cov.values[0]) / np.ptp(cov.values)


def by_covariate(context: Context, name: str, values: Floats) -> list[Feature]:
    """What follows something that was logged, by its values (F,): at any place, and by the load."""
    out = [pattern(name, values), pattern(f"{name} square", values**2, 0.2)]
    x = context.rows.fraction
    return out + [pattern(f"{name} x {c}", values * x[:, c], 0.5) for c in range(x.shape[1])]


def ball_of(context: Context, drive: Floats, radius: float) -> Floats:
    """The vector play on a drive (E, C), at the rows (F, C): one point, dragged by a ball of `radius` a root of C.

    P. Krejci, Hysteresis, Convexity and Dissipation in Hyperbolic Equations, Gakkotosho, Tokyo, 1996.
    """
    state, reach = drive.copy(), radius * np.sqrt(drive.shape[1])
    for e, before in enumerate(context.started):
        last = state[before] if before >= 0 else np.zeros(drive.shape[1])
        behind = drive[e] - last
        state[e] = drive[e] - behind * min(1.0, reach / max(float(np.linalg.norm(behind)), 1e-12))
    return state[context.rows.event]


def lags(context: Context, taus: tuple[float, ...], first: float) -> list[Feature]:
    """Lags behind the pressure and behind the walls, s; of those up to `first` less is expected."""
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
