"""Laws that act where they are seen, at each place in its own measure: still delay, creep, leak and friction."""

from typing import Any

import numpy as np
import pytest

from tests.naming import verdict_of

LONG = {"markers": 12, "captures": 60, "rows_s": (1.0, 1.5, 2.0, 3.0, 5.0, 12.0)}


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
    """Under one end of the body the pockets lose air through orifices: hyperbolic in time, refilled each time."""
    rate = 0.008 * np.clip(1.5 - 2 * along(lab), 0, 1)
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
        (rubs_in_places, "friction"),
    ],
)
def test_what_acts_at_each_place_in_its_own_measure_keeps_its_name(make_lab, law, effect) -> None:
    """A lag that spreads, pockets that sink and a sleeve that drags are named, alone, where no chamber has them."""
    lab = make_lab(**LONG)
    found = verdict_of(lab.dataset(law(lab) + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("identified", (effect,))
