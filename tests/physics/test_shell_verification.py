"""The shell simulator against theory, against itself on finer meshes, and against finite differences."""

import numpy as np
import pytest

from labrig.physics import load_shell

RIGIDITY = 1000.0 * 2.0**3 / 3.0  # D = E h^3 / 12 (1 - nu^2) = mu h^3 / 3 of an incompressible sheet


def middle_mm(shell, pressure_kpa):
    """How far the middle of a sheet rises."""
    solution = shell.solve([pressure_kpa])
    return float(shell.spline.evaluate(solution.control_mm, [[0.5, 0.5]])[0, 1])


@pytest.mark.parametrize(("border", "coefficient"), [("hinged", 0.00406235), ("clamped", 0.00126532)])
def test_a_plate_bends_as_kirchhoff_says(sheet, border, coefficient):
    """The middle of a square plate under small pressure rises by the textbook's coefficient times p a^4 / D."""
    wanted_mm = 0.04
    pressure = wanted_mm * RIGIDITY / coefficient / 100.0**4
    assert middle_mm(sheet(16, border, degree=3), pressure) == pytest.approx(wanted_mm, rel=2e-3)


def test_a_plate_converges_with_the_mesh(sheet):
    """The error of a clamped plate of quadratic splines falls about as the square of the mesh."""
    pressure = 0.04 * RIGIDITY / 0.00126532 / 100.0**4
    errors = [abs(middle_mm(sheet(count, "clamped"), pressure) / 0.04 - 1.0) for count in (8, 14, 26)]
    assert errors[1] < errors[0] / 2.5
    assert errors[2] < errors[1] / 2.5
    assert errors[2] < 0.01


def test_a_membrane_rises_as_its_tension_says(sheet):
    """The middle of a stretched square membrane rises by 0.0736713 p a^2 / T, T = mu h (l^2 - l^-4)."""
    tension = 1000.0 * 0.5 * (1.2**2 - 1.2**-4)
    rise = middle_mm(sheet(16, thickness=0.5, prestretch=1.2), 0.01)
    assert rise == pytest.approx(0.0736713 * 0.01 * 100.0**2 / tension, rel=6e-3)


def test_a_balloon_follows_laplace(sheet):
    """A strongly blown thin sheet is in balance: the force of its border along y is the pressure times its area."""
    shell = sheet(14, thickness=0.2, prestretch=1.05)
    solution = shell.solve([0.5])
    system = shell._system
    lifted = np.zeros((shell.spline.size, 3))
    lifted[:, 1] = 1.0
    nothing = system.field(np.zeros(1))
    inner = system.energy(solution.state, nothing)[1].reshape(-1, 3)[:, 1].sum()
    outer = -(
        system.energy(solution.state, system.field(np.array([0.5])))[1].reshape(-1, 3)[:, 1].sum() - inner
    )
    assert outer == pytest.approx(inner, rel=1e-4)
    assert 0.8 * 0.5 * 100.0**2 < outer < 0.5 * 100.0**2  # the outer ring of control points carries the rest


@pytest.mark.parametrize("name", ["mannequin", "membrane4"])
def test_the_gradient_is_the_derivative_of_the_energy(small, name):
    """Forces are finite differences of the energy, away from rest, with contact, seams, air, weight and history."""
    shell = small(name).changed(core_offset_mm=1.5)
    random = np.random.default_rng(0)
    layers, points = len(shell.file.layers), len(shell.quadrature.uv)
    shell = shell.remembering(
        0.02 * random.normal(size=(points, layers, 3)), random.uniform(0, 0.3, (points, layers))
    )
    system = shell._system
    x = random.normal(scale=1.5, size=system.size)
    field = system.field(0.4 * shell.max_kpa)
    gradient = system.energy(x, field)[1]
    for _ in range(4):
        along = random.normal(size=system.size)
        rise = (system.energy(x + 1e-5 * along, field)[0] - system.energy(x - 1e-5 * along, field)[0]) / 2e-5
        assert rise == pytest.approx(gradient @ along, rel=1e-5)


def test_second_derivatives_are_those_of_the_gradient(small):
    """The stiffness equals finite differences of the forces, but for the moments' own small share."""
    from scipy.linalg.blas import dsbmv

    shell = small()
    shell = shell.remembering(np.full((len(shell.quadrature.uv), 2, 3), 0.02))
    system = shell._system
    random = np.random.default_rng(1)
    x = shell.solve(0.5 * shell.max_kpa).state + random.normal(scale=0.1, size=system.size)
    field = system.field(0.5 * shell.max_kpa)
    band = np.empty((system.size, system.bandwidth + 1))
    system.second(x, field, band, False)
    along = random.normal(size=system.size)
    numeric = (system.energy(x + 1e-5 * along, field)[1] - system.energy(x - 1e-5 * along, field)[1]) / 2e-5
    exact = dsbmv(system.bandwidth, 1.0, band.T, along, lower=1)
    assert np.linalg.norm(exact - numeric) < 0.01 * np.linalg.norm(numeric)


def differences(shell, at, moved):
    """Control points of (shell, pressure) pairs, second less first."""
    low, high = (s.solve(p, at.state).control_mm for s, p in moved)
    return high - low


@pytest.mark.parametrize("name", ["mannequin", "membrane4"])
def test_jacobians_by_pressure(small, name):
    """Implicit derivatives by chamber pressure equal differences of solved shapes."""
    shell = small(name)
    pressure = shell.max_kpa * np.linspace(0.3, 0.6, len(shell.max_kpa))
    at = shell.solve(pressure)
    jacobian = shell.jacobian(at)
    assert jacobian.shape == (12, 12, 3, len(pressure))
    for chamber in (0, 3):
        step = np.eye(len(pressure))[chamber] * 0.2
        numeric = differences(shell, at, [(shell, pressure - step), (shell, pressure + step)]) / 0.4
        assert np.abs(numeric - jacobian[..., chamber]).max() < 0.01 * np.abs(numeric).max()


def test_jacobians_without_a_cholesky_factor(small, monkeypatch):
    """Where the stiffness looks unstable, derivatives come from another factorisation and are the same."""
    shell = small("membrane4")
    at = shell.solve(0.5 * shell.max_kpa)
    usual = shell.jacobian(at)
    monkeypatch.setattr("labrig.physics._shell_solve._factor_double", lambda band, lower: (band, 1))
    np.testing.assert_allclose(shell.jacobian(at), usual, atol=1e-9)


def test_jacobians_by_parameter(small):
    """Implicit derivatives by every physical parameter equal differences of shapes solved with other values."""
    shell = small()
    at = shell.solve(0.5 * shell.max_kpa)
    names = list(shell.parameters)
    wide = {"gravity_m_per_s": 5.0, "contact_kpa_per_mm": 0.3, "prestretch_": 4e-4}
    jacobian = shell.parameter_jacobian(at, names)
    assert jacobian.shape == (12, 12, 3, len(names))
    for k, name in enumerate(names):
        parameter = shell.parameters[name]
        step = wide.get(name.rstrip("12"), 4e-3 * max(abs(parameter.value), 1.0))
        values = [parameter.value - step, parameter.value + step]
        if name.startswith("share") and parameter.value == 1.0:
            values = [1.0 - 2 * step, 1.0]
        moved = [(shell.changed(**{name: value}), at.pressure_kpa) for value in values]
        numeric = differences(shell, at, moved) / (2 * step)
        assert np.abs(numeric).max() > 0
        off = np.linalg.norm(numeric - jacobian[..., k])
        assert off < 0.03 * np.linalg.norm(numeric) + 1e-4 / step, name


def test_meshes_agree():
    """The mannequin on 22 x 22 control points is within 0.2 mm on average of that on 34 x 34."""
    uv = np.random.default_rng(2).random((500, 2))
    coarse, fine = (load_shell("mannequin").changed(count=(n, n)) for n in (22, 34))
    pressure = coarse.max_kpa * np.array([1, 0, 1, 0.8, 0, 1, 0.5, 1, 0])
    points = [s.spline.evaluate(s.solve(pressure).control_mm, uv) for s in (coarse, fine)]
    assert np.linalg.norm(points[0] - points[1], axis=1).mean() < 0.2
