"""The reduced simulator: its shapes, its Jacobian, and what it refuses."""

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig.physics import load_shell, reduced_surface, rig_shell


@pytest.mark.parametrize(("name", "chambers", "markers"), [("mannequin", 9, 34), ("membrane", 4, 16)])
def test_a_vented_surface_is_at_rest(name: str, chambers: int, markers: int) -> None:
    """With no pressure the markers are where the surface says they rest, in the sizes promised."""
    surface = reduced_surface({"simulated": {"surface": name}})
    position = surface.predict(np.zeros((2, chambers)))
    assert position.shape == (2, markers, 3)
    np.testing.assert_allclose(position[1], surface.rest_mm, atol=1e-9)


@pytest.mark.parametrize("name", ["mannequin", "membrane"])
def test_the_jacobian_equals_finite_differences(name: str) -> None:
    """The analytic derivative by pressure agrees with central differences."""
    surface = reduced_surface({"simulated": {"surface": name}})
    chambers = len(surface.chamber_names)
    pressure = np.random.default_rng(1).uniform(0.0, 60.0, (5, chambers))
    numeric = np.stack(
        [
            (surface.predict(pressure + 1e-4 * row) - surface.predict(pressure - 1e-4 * row)) / 2e-4
            for row in np.eye(chambers)
        ],
        axis=-1,
    )
    np.testing.assert_allclose(surface.jacobian(pressure), numeric, atol=1e-7)


def test_deflection_grows_with_pressure_and_ever_more_slowly() -> None:
    """A chamber's law is monotone, convex towards the pressure axis, and reaches 30 to 60 mm at 60 kPa."""
    surface = reduced_surface({})
    rise = np.diff(surface.deflection_mm(np.linspace(0.0, 60.0, 61)[:, None] * np.ones(9)), axis=0)
    assert (rise > 0).all()
    assert (np.diff(rise, axis=0) < 0).all()
    full = surface.deflection_mm(np.full(9, 60.0))
    assert ((full > 30.0) & (full < 60.0)).all()


def test_the_law_holds() -> None:
    """Deflections solve d + d^3 / limit^2 = gain * p, for vacuum too."""
    surface = reduced_surface({})
    pressure = np.random.default_rng(2).uniform(-60.0, 60.0, (20, 9))
    d = surface.deflection_mm(pressure)
    np.testing.assert_allclose(
        d + d**3 / surface.limit_mm**2, surface.compliance_mm_per_kpa * pressure, atol=1e-9
    )


def test_the_mesh_moves_with_the_markers_and_faces_outwards() -> None:
    """Every marker lies on the mesh to within its coarseness, and triangles are wound outwards."""
    surface = reduced_surface({})
    pressure = np.linspace(5.0, 55.0, 9)
    vertices, triangles = surface.mesh(pressure)
    markers = surface.predict(pressure)[0]
    nearest = np.linalg.norm(vertices[None] - markers[:, None], axis=-1).min(axis=1)
    assert nearest.max() < 5.0
    corner = vertices[triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    assert normal[:, 1].mean() > 0
    assert triangles.max() == len(vertices) - 1


def test_a_rig_names_chambers_and_picks_markers() -> None:
    """Chambers take the rig's names; listed markers are the only ones, in that order."""
    rig = {"simulated": {"surface": "membrane"}, "chambers": list("abcd"), "markers": ["m05", "m02"]}
    surface = reduced_surface(rig)
    assert surface.chamber_names == ("a", "b", "c", "d")
    whole = reduced_surface({"simulated": {"surface": "membrane"}})
    np.testing.assert_array_equal(surface.rest_mm, whole.rest_mm[[4, 1]])


@pytest.mark.parametrize(
    ("rig", "message"),
    [
        (
            {"simulated": {"surface": "sphere"}},
            "rig: simulated.surface: there is no surface 'sphere' (known: mannequin, membrane)",
        ),
        ({"chambers": [{"name": "c1"}]}, "rig: chambers: surface 'mannequin' has 9, the rig names 1"),
        ({"markers": ["x"]}, "rig: markers: surface 'mannequin' has no marker 'x' (it has m01..m34)"),
    ],
)
def test_a_rig_that_does_not_fit_is_refused(rig: dict, message: str) -> None:
    """A surface, chambers or markers that do not exist are named in one line."""
    with pytest.raises(LabrigError) as error:
        reduced_surface(rig)
    assert str(error.value) == message


def test_chambers_are_found_by_name() -> None:
    """A rig that lists a simulator's chambers in another order has each at its own place, with its own limit."""
    names, order = ["c1", "c2", "c3", "c4"], [2, 0, 3, 1]
    chambers = [{"name": names[k], "max_kpa": 10.0 + k} for k in order]
    surfaces = [
        reduced_surface({"simulated": {"surface": "membrane"}, "chambers": some})
        for some in (names, chambers)
    ]
    pressure = np.array([40.0, 0.0, 10.0, 20.0])
    np.testing.assert_allclose(surfaces[1].predict(pressure[order]), surfaces[0].predict(pressure))
    shell = rig_shell({"simulated": {"shell": "membrane4"}, "chambers": chambers})
    assert shell.chamber_names == ("c3", "c1", "c4", "c2")
    assert shell.max_kpa.tolist() == [12.0, 10.0, 13.0, 11.0]
    there = {chamber.name: (chamber.u, chamber.v) for chamber in load_shell("membrane4").file.chambers}
    assert {chamber.name: (chamber.u, chamber.v) for chamber in shell.file.chambers} == there


def test_pressures_of_the_wrong_width_are_refused() -> None:
    """One column per chamber, or an error that says so."""
    with pytest.raises(LabrigError) as error:
        reduced_surface({}).predict(np.zeros((3, 4)))
    assert str(error.value) == "surface mannequin: pressures of shape (3, 4) given, (captures, 9) needed"
