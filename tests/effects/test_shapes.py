"""What shapes at rest a body may have."""

import numpy as np

from labrig.effects import library
from tests.effects.test_family import context_of


def test_a_hump_is_a_shape_of_its_own(make_lab) -> None:
    """What rises as a cone with a round tip about one place, a fifth of the body wide, is in the space of humps, where
    smooth bends of the whole body leave most of it.
    """
    lab = make_lab(chambers=4, markers=30, captures=20)
    context = context_of(lab)
    away = np.linalg.norm(lab.rest_mm - lab.rest_mm[11], axis=1)
    hump = np.zeros((30, 3))
    hump[:, 2] = np.exp(-away / 12.0 * np.tanh(away / 6.0))
    left = {}
    for space in library()["rest_shape"].family(context):
        if space.key in {"humps", "bent"}:
            shapes = np.stack([f.values[0] for f in space.features], axis=1)
            fit = shapes @ np.linalg.lstsq(shapes, hump.ravel(), rcond=1e-9)[0]
            left[space.key] = np.linalg.norm(hump.ravel() - fit) / np.linalg.norm(hump)
    assert left["humps"] < 0.2
    assert left["bent"] > 0.5
