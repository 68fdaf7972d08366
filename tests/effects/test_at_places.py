"""Laws that act where they are seen, at each place in its own measure: still delay, creep, leak and friction."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.effects import Space, library
from tests.naming import verdict_of

LONG = {"chambers": 2, "markers": 16, "captures": 60, "rows_s": (1.0, 1.5, 2.0, 3.0, 5.0, 12.0)}


def along(lab: Any) -> np.ndarray:
    """How far along the body each observable is, (K,), 0 to 1."""
    return np.repeat(np.linspace(0, 1, lab.markers), 3)


def before_each(lab: Any) -> np.ndarray:
    """What the body showed before each actuation, settled, (n, 1, K)."""
    settled = lab.predict(lab.commanded)
    return np.concatenate([lab.rest[None], settled[:-1]])[:, None]


def diffuses_along(lab: Any) -> np.ndarray:
    """Pressure goes through a body as through a porous rod: the farther from the inlet, the later (Barenblatt 1960)."""
    cells = 12
    flow = 2 * np.eye(cells) - np.eye(cells, k=1) - np.eye(cells, k=-1)
    flow[-1, -1] = 1.0  # shut at the far end
    power, ways = np.linalg.eigh(flow * cells**2 / 2.5)
    cell = np.minimum((along(lab) * cells).astype(int), cells - 1)
    start = ways.T @ np.ones(cells)
    left = np.einsum("cm,m,tm->tc", ways, start, np.exp(-np.outer(lab.rows_s, power)))[:, cell]
    now = lab.predict(lab.u)
    return now + left * (before_each(lab) - now)


def sinks_in_places(lab: Any) -> np.ndarray:
    """The nearer to one end, the faster pockets lose air through orifices: hyperbolic in time, refilled each time."""
    rate = 0.006 * (1.2 - along(lab))
    return lab.rest + (lab.predict(lab.u) - lab.rest) / (1 + rate * lab.hold_s[:, :, None]) ** 2


def rubs_in_places(lab: Any) -> np.ndarray:
    """A sleeve that is tight at one end drags each place, stick first, then slip (Dahl 1968, exponent one)."""
    size = 1.2 * np.clip(1.3 * along(lab), 0.1, 1)
    values = lab.predict(lab.u)
    force, last = np.zeros(len(lab.rest)), lab.rest
    for i, way in lab.path(40):
        for point in lab.predict(way):
            step = (point - last) / 0.8
            force, last = (force + step) / (1 + np.abs(step)), point
        values[i] -= size * force
    return values


@pytest.mark.parametrize(
    ("law", "effect"),
    [
        (diffuses_along, "delay"),
        (sinks_in_places, "leak"),
    ],
)
def test_what_acts_at_each_place_in_its_own_measure_keeps_its_name(make_lab, law, effect) -> None:
    """A lag that spreads and pockets that sink are named, alone, where no chamber has them."""
    lab = make_lab(**{**LONG, "markers": 10, "captures": 45})
    found = verdict_of(lab.dataset(law(lab) + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("identified", (effect,))


def columns_of(space: Space, context: Any) -> np.ndarray:
    """The functions of a space as they show, (F K, n)."""
    shown = [
        f.values if f.kind == "field" else np.einsum("fkc,fc->fk", context.jacobian * context.span, f.values)
        for f in space.features
    ]
    return np.stack([np.broadcast_to(v, context.base.shape).ravel() for v in shown], axis=1)


def left_by(columns: np.ndarray, change: np.ndarray) -> float:
    """The share of a change that no sum of the columns is, root mean square."""
    fitted = columns @ np.linalg.lstsq(columns, change.ravel(), rcond=None)[0]
    return float(np.linalg.norm(change.ravel() - fitted) / np.linalg.norm(change))


@pytest.mark.parametrize(
    ("law", "effect", "most"),
    [(diffuses_along, "delay", 0.25), (sinks_in_places, "leak", 0.05), (rubs_in_places, "friction", 0.2)],
)
def test_the_family_holds_what_acts_by_place(make_lab, law, effect, most) -> None:
    """Functions by place, beside another gain of each place, hold most of such a law; the plain ones leave far more."""
    lab = make_lab(**LONG)
    data = lab.dataset(law(lab))
    context = prepared(rows_from(data), lab.model()).context
    spaces = {space.key: space for space in library()[effect].family(context)}
    key = next(key for key in spaces if key.endswith("by place"))
    gains = (
        context.displacement[..., None] * np.stack([np.ones(len(lab.rest)), along(lab)], axis=1)
    ).reshape(context.base.size, -1)
    change = context.rows.values - context.base
    plain = left_by(np.hstack([gains, columns_of(spaces[key.removesuffix(", by place")], context)]), change)
    by_place = left_by(np.hstack([gains, columns_of(spaces[key], context)]), change)
    assert by_place < most
    assert by_place < 0.6 * plain
