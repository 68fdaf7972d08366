"""Bodies that are warped or of another size, and cameras of another scale: which it is, if that can be told."""

from typing import Any

import numpy as np
import pytest

from labrig.effects import rows_of
from labrig.effects._fields import travel_of_all
from labrig.effects._registry import shipped
from tests.effects.test_family import followed
from tests.naming import calls_of, verdict_of


def plate(out: np.ndarray) -> np.ndarray:
    """What is left of motions that would be so far out: of w, where w + 0.5 w^3 is that (von Karman's plate)."""
    w = out.copy()
    for _ in range(30):
        w -= (w + 0.5 * w**3 - out) / (1 + 1.5 * w**2)
    return np.divide(w, out, out=np.ones_like(out), where=out > 0)


LAWS = {"tighter": lambda out: 1 - 0.12 / (0.1 + out), "stiffer": plate}


def sheet(make_lab, side: int = 4) -> Any:
    """Markers on a flat grid, so many a side, over four chambers in a row."""
    lab = make_lab(chambers=4, markers=side**2, captures=45, rows_s=(2.0, 4.0, 8.0), reach_mm=6.0)
    x, y = np.meshgrid(np.linspace(0, 90, side), np.linspace(-40, 40, side))
    lab.rest_mm = np.stack([x.ravel(), y.ravel(), np.zeros(side**2)], axis=1)
    lab.rest = lab.rest_mm.ravel()
    away = np.hypot(x.ravel()[:, None] - 30 * np.arange(4), 0.5 * y.ravel()[:, None]) / 25
    lab.reach = np.zeros((side**2, 3, 4))
    lab.reach[:, 2] = 6.0 * np.exp(-(away**2))
    lab.reach = lab.reach.reshape(-1, 4)
    return lab


def test_a_warped_sheet_is_a_rest_shape(make_lab) -> None:
    """No rigid motion makes a saddle of a sheet, and no camera is named for it."""
    lab = sheet(make_lab)
    x, y = ((v - v.mean()) / 40 for v in lab.rest_mm[:, :2].T)
    warp = np.sinh(x) * np.sin(y)
    values = lab.predict(lab.u).reshape(*lab.hold_s.shape, 16, 3)
    values[..., 2] += 0.8 * (warp - warp.mean()) / warp.std()
    calls = calls_of(lab.dataset(values.reshape(*lab.hold_s.shape, 48) + lab.noise()), lab.model())
    assert calls["rest_shape"] == "sure"
    assert calls["frame"] == "not it"


def test_a_wand_that_is_too_short_leaves_the_frame_possible(make_lab) -> None:
    """One number says all of it: motions, too, are of another scale, and a body of another size moves as before."""
    lab = sheet(make_lab, side=5)
    values = 1.002 * lab.predict(lab.u)
    found = verdict_of(lab.dataset(values + lab.noise()), lab.model())
    by_evidence = {c.effect: c.by_evidence for c in found.considered}
    assert by_evidence["frame"] > 0.2
    assert set(found.effects) <= {"frame"}


def test_how_far_all_have_come_out_together(make_lab) -> None:
    """The root mean square of all motions as a share of the most, whatever their units."""
    lab = sheet(make_lab)
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    there = np.sqrt((context.displacement**2).mean(axis=1))
    assert travel_of_all(context)[:, 0] == pytest.approx(there / there.max())


def test_a_body_of_another_size_is_a_rest_shape(make_lab) -> None:
    """It moves as before: what swells from one corner on, a little more along than across, is no camera's scale."""
    lab = sheet(make_lab)
    corner, much = lab.rest_mm.min(axis=0), np.array([0.0042, 0.0036, 0.0])
    grown = lab.predict(lab.u) + (np.expm1(much) * (lab.rest_mm - corner)).ravel()
    found = verdict_of(lab.dataset(grown + lab.noise()), lab.model())
    by_evidence = {c.effect: c.by_evidence for c in found.considered}
    assert by_evidence["rest_shape"] > 0.5
    assert set(found.effects) <= {"rest_shape"}


def out_of(moved: np.ndarray, where: str) -> np.ndarray:
    """How far motions (n, T, K) are out, as a share of the most: all of them together, or each marker."""
    if where == "all over":
        out = np.sqrt((moved**2).mean(axis=2, keepdims=True))
    else:
        out = np.repeat(np.linalg.norm(moved.reshape(*moved.shape[:2], -1, 3), axis=3), 3, axis=2)
    return out / out.max()


SPACES = {
    ("tighter", "all over"): ("tension", "fading as all travel"),
    ("tighter", "at each place"): ("tension", "fading"),
    ("stiffer", "all over"): ("stiffening", "as all travel"),
    ("stiffer", "at each place"): ("stiffening", "as it travels"),
}


@pytest.mark.parametrize(("law", "where"), list(SPACES))
def test_a_narrow_space_holds_each_of_these_laws(make_lab, law: str, where: str) -> None:
    """With three functions, while that of the other way has less of it."""
    lab = sheet(make_lab)
    moved = lab.predict(lab.u) - lab.rest
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    change = (moved * (LAWS[law](out_of(moved, where)) - 1)).reshape(context.base.shape)
    effect, key = SPACES[law, where]
    spaces = {s.key: s for s in shipped()[effect].family(context)}
    (other,) = (k for (one, there), (_, k) in SPACES.items() if one == law and there != where)
    assert len(spaces[key].features) == 3
    assert followed(context, spaces[key], change) > max(0.95, followed(context, spaces[other], change))


@pytest.mark.parametrize(("law", "where"), [("tighter", "all over"), ("stiffer", "at each place")])
def test_what_is_held_back_goes_by_how_far_it_is_out(make_lab, law: str, where: str) -> None:
    """What a tension holds back near rest, and what a stretched sheet gives less: by how far all of it is out, since a
    membrane is as tight all over, or each place.
    """
    lab = sheet(make_lab)
    moved = lab.predict(lab.u) - lab.rest
    left = LAWS[law](out_of(moved, where))
    found = verdict_of(lab.dataset(lab.rest + moved * left + lab.noise()), lab.model())
    name = "tension" if law == "tighter" else "stiffening"
    by_evidence = {c.effect: c.by_evidence for c in found.considered}
    assert by_evidence[name] > (0.7 if law == "tighter" else 0.99)
    assert set(found.effects) <= {name}
