"""A few poses, each repeated many times, and many markers: what is off by as much in all of them is no drift."""

import numpy as np

from labrig.diagnosis import diagnose
from labrig.diagnosis._diagnose import laid_out
from labrig.diagnosis._problem import prepared, rows_from
from tests.conftest import Lab


def repeated(lab: Lab, seed: int, off_mm: float) -> np.ndarray:
    """Six poses nine times over, each time in another order, then the vented rig; markers are glued on so far beside
    where the model has them, each by itself: positions (n, T, K).
    """
    random = np.random.default_rng(seed)
    poses = random.uniform(0, 60, (6, lab.chambers)).round(1)
    lab.commanded[:] = 0.0
    lab.commanded[:54] = np.concatenate([poses[random.permutation(6)] for _ in range(10)])[:54]
    return lab.predict(lab.u) + off_mm * random.normal(size=len(lab.rest)) + lab.noise()


def test_an_offset_is_a_rest_shape(make_lab, few_effects) -> None:
    """It is named as such, and no drift that has warmed up before the first repeat."""
    few_effects("rest_shape", "drift", "frame")
    lab = make_lab(chambers=6, markers=30, captures=60, seed=3)
    found = diagnose(lab.dataset(repeated(lab, 103, 0.2)), lab.model()).summary
    assert found["effects"] == ["rest_shape"]


def test_each_marker_may_be_off_by_itself(make_lab, few_effects) -> None:
    """However little a repeat counts, the family of rest shapes has a function for each direction of the design."""
    few_effects("rest_shape")
    lab = make_lab(chambers=6, markers=30, captures=60)
    model = lab.model()
    _, _, design = laid_out(prepared(rows_from(lab.dataset(repeated(lab, 1, 0.1))), model), model.library())
    assert design is not None
    (shape,) = [b for b in design.blocks if (b.owner, b.space.key) == ("rest_shape", "shape")]
    assert shape.at.stop - shape.at.start >= len(design.V.T)
