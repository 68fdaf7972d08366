"""A map that was learnt errs by about the noise that it was learnt from: no effect, and it hides no memory."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import RBFInterpolator

import labrig
from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._notes import may_be_learnt
from labrig.diagnosis._ripple import ripple
from labrig.diagnosis._verdict import Verdict
from labrig.model import Model
from tests.conftest import HIGH_KPA
from tests.naming import verdict_of

if TYPE_CHECKING:
    from xarray import Dataset

NOISE = np.array([0.1, 0.3])
HOLD_S = np.array([1.0, 3.0, 9.0])


def rig(u: np.ndarray) -> np.ndarray:
    """A force, N, and an angle, deg, (F, 2), of two chambers that act on each other."""
    x = u / HIGH_KPA
    own = x * 1.5 / (1 + 0.5 * x)
    both = own[:, :1] * own[:, 1:]
    return np.hstack(
        [8 * own[:, :1] + 5 * own[:, 1:] + 2 * both, 20 * own[:, :1] - 15 * own[:, 1:] + 4 * both]
    )


def learnt(seed: int) -> Callable[[np.ndarray], np.ndarray]:
    """A thin-plate spline through sixty measurements of it."""
    random = np.random.default_rng(100 + seed)
    points = random.uniform(0, HIGH_KPA, (60, 2))
    return RBFInterpolator(points, rig(points) + random.normal(0, NOISE, (60, 2)), smoothing=20.0)


def campaign(folder: Path, seed: int, leak: float = 0.0) -> "Dataset":
    """Forty set-points, three rows each; a pinhole lets the root of each pressure fall in a straight line."""
    random = np.random.default_rng(seed)
    u = np.repeat(random.uniform(0, HIGH_KPA, (40, 2)).round(1), 3, axis=0)
    left = np.maximum(np.sqrt(u) - leak * np.tile(HOLD_S, 40)[:, None], 0.0) ** 2
    seen = rig(left) + random.normal(0, NOISE, (120, 2))
    columns = {
        "t (s)": np.repeat(12.0 * np.arange(40), 3) + np.tile(HOLD_S, 40),
        "step": np.repeat(np.arange(40), 3),
    }
    columns |= {"p1 set (kPa)": u[:, 0], "p2 set (kPa)": u[:, 1]}
    columns |= {"force (N)": seen[:, 0].round(3), "angle (deg)": seen[:, 1].round(2)}
    return labrig.import_table(pd.DataFrame(columns), folder / "run")


def test_what_a_learnt_map_errs_by_is_no_missing_effect(tmp_path: Path) -> None:
    """Of a rig that has changed in nothing since it was learnt nothing is missing."""
    model = Model.of(learnt(0), learned=True)
    assert verdict_of(campaign(tmp_path, 0), model).verdict == "nothing_missing"


def test_a_leak_beside_a_learnt_map_is_named(tmp_path: Path) -> None:
    """What goes on in a hold is no function of the set-point."""
    found = verdict_of(campaign(tmp_path, 1, leak=0.03), Model.of(learnt(1), learned=True))
    assert (found.verdict, found.effects) == ("identified", ("leak",))


def test_it_is_a_function_of_the_set_points_of_one_size(make_lab) -> None:
    """Rows of one set-point have it alike, and everywhere it is as large; few captures have few functions."""
    lab = make_lab(captures=45)
    context = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model()).context
    phi = ripple(context)
    assert phi.shape[1] <= 15
    few = make_lab(captures=18)
    short = prepared(rows_from(few.dataset(few.predict(few.u) + few.noise())), few.model()).context
    assert ripple(short).shape[1] == 6
    assert (np.ptp(phi[context.rows.capture == 7], axis=0) < 1e-9).all()
    size = (phi**2).sum(axis=1)
    assert size.min() > 0.3
    assert size.max() <= 1 + 1e-6


@pytest.mark.parametrize(
    ("said", "names", "asked"),
    [
        pytest.param(None, ("regulator", "creep"), "regulator", id="nobody said"),
        pytest.param(None, ("stiffening", "contact"), "stiffening or contact", id="either"),
        pytest.param(None, ("creep", "frame"), "", id="no curve of the set-points"),
        pytest.param(True, ("regulator",), "", id="it was learnt"),
        pytest.param(False, ("regulator",), "", id="it is a formula"),
    ],
)
def test_whether_a_model_was_learnt_is_asked(
    make_lab, said: bool | None, names: tuple[str, ...], asked: str
) -> None:
    """Where a curve of the set-points is named, and the model may be a map that somebody fitted and did not say so."""
    model = make_lab().model()
    model.file.base.learned = said
    lines = may_be_learnt(model, Verdict("confounded", names[:1], 0.9, names[1:]), model.library())
    expected = (
        f"if the model was fitted or trained on measurements, its own error may be what {asked} explains: say learned: "
        "true in the model file, or learned: false of a formula"
    )
    assert lines == ([expected] if asked else [])
