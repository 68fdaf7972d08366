"""Shells with parts that would do nothing are refused where they are read, and it is said what to change."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig._executor import Executor
from labrig.physics import load_shell
from labrig.physics._samples import LEVELS, inflation_curve, sample_pressures


def content(**chamber):
    """A small sheet with one chamber."""
    return {
        "name": "sheet",
        "control_points": [12, 12],
        "core": {"kind": "plane", "width": 160, "height": 120},
        "layers": [{"modulus": 400, "thickness": 2}],
        "chambers": [{"name": "air", "u": [0.1, 0.9], "v": [0.1, 0.9], **chamber}],
    }


@pytest.mark.parametrize(
    ("chamber", "said"),
    [
        ({"u": [-3, -2]}, "chambers: air: u from -3 to -2 lies off the surface, which goes from 0 to 1"),
        ({"v": [1, 1.5]}, "chambers: air: v from 1 to 1.5 lies off the surface"),
        (
            {"u": [0.5, 0.5005]},
            "u from 0.5 to 0.5005: 0.0005 of it lies on the surface, less than its soft edge",
        ),
        (
            {"v": [-0.5, 0.005]},
            "v from -0.5 to 0.005: 0.005 of it lies on the surface, less than its soft edge",
        ),
        (
            {"u": [0.49, 0.51], "edge": 0.001},
            "chamber air: u from 0.49 to 0.51 is narrower than a mesh of (12, 12) control points can see",
        ),
    ],
)
def test_a_chamber_without_weight_is_refused(chamber, said):
    """A chamber off the surface, narrower than its edge or than the mesh sees is named when the shell is read."""
    with pytest.raises(LabrigError) as error:
        load_shell(content(**chamber))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_chambers_that_reach_over_the_border_stay():
    """A chamber may be larger than the surface, and a narrow one is fine with a narrow edge and a fine mesh."""
    assert load_shell(content(u=[-1, 2], v=[-1, 2])).patch_area_mm2.sum() == pytest.approx(
        160 * 120, rel=1e-3
    )
    fine = {**content(u=[0.49, 0.51], edge=0.001), "control_points": [90, 12]}
    assert load_shell(fine).patch_area_mm2.sum() > 0


@pytest.mark.parametrize("markers", [{"columns": 0, "rows": 3}, {"columns": 4}, {}])
def test_a_grid_of_no_markers_is_refused(markers):
    """Zero columns or rows are no markers, and that is said when the shell is read."""
    with pytest.raises(LabrigError, match=r"markers: there are none: columns and rows are one or more each"):
        load_shell({**content(), "markers": markers})


def test_a_chamber_too_narrow_for_the_coarse_mesh_is_sampled_evenly():
    """Pressures are spread on a coarse mesh; a chamber that only the shell's own mesh sees is spread in proportion."""
    fine = {**content(u=[0.527, 0.543], edge=0.001), "control_points": [90, 12]}
    shell = load_shell(fine)
    np.testing.assert_array_equal(inflation_curve(({**fine, "control_points": [16, 16]}, 0)), LEVELS)
    with Executor(1) as executor:
        pressure, _ = sample_pressures(shell, 10, 0, executor)
    assert np.isfinite(pressure).all()
