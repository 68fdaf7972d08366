"""A rig that is driven by vacuum is the same rig as one whose vacuum is counted as a positive pressure."""

from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from labrig.effects import contribution, ends, library, rows_of
from labrig.experiment._plan import Limits
from labrig.model._simulator import SimulatorModel, solved_curves
from tests.conftest import HIGH_KPA
from tests.naming import verdict_of

if TYPE_CHECKING:
    import xarray as xr

    from labrig.model import Model

_MOST = 40  # forms of an effect
_OFFSETS = {"regulator": "offset", "drift": "pressure"}


def mirrored(lab: Any, data: "xr.Dataset") -> "tuple[xr.Dataset, Model]":
    """The same campaign and its model where every chamber is filled by vacuum, from -60 to 0 kPa."""
    model = lab.model()
    path = lab.folder / "base.py"
    path.write_text(path.read_text() + "\n\nfilled = predict\n\n\ndef predict(u):\n    return filled(-u)\n")
    names = ("commanded", "event_commanded", *(["measured"] if "measured" in data else []))
    data = data.assign({name: (data[name].dims, -data[name].values, data[name].attrs) for name in names})
    none = np.zeros(lab.chambers)
    limits = {"chamber_min": ("chamber", none - HIGH_KPA), "chamber_max": ("chamber", none)}
    return data.assign_coords(limits), type(model).load(lab.folder / "model.yaml")


def both(lab: Any, values: np.ndarray) -> Any:
    """The contexts of the campaign as it is, and by vacuum."""
    data = lab.dataset(values)
    plain = lab.model().context(rows_of(data))
    data, model = mirrored(lab, data)
    return plain, model.context(rows_of(data))


@pytest.fixture
def contexts(make_lab) -> Any:
    """Those of a rig with memory, walls that stiffen, two sessions, and long holds."""
    lab = make_lab(captures=40, sessions=2, long_s=(3.0, 8.0, 20.0))
    return both(lab, lab.predict(lab.looped(3.0)) + lab.noise())


@pytest.mark.parametrize("name", sorted(library()))
def test_every_space_of_an_effect_is_the_same(contexts, name: str) -> None:
    """What an effect may be, as functions, does not depend on the sign that a laboratory gives to its vacuum."""
    plain, by_vacuum = contexts
    effect = library()[name]
    spaces = zip(effect.family(plain), effect.family(by_vacuum), strict=True)
    for one, other in spaces:
        assert one.key == other.key
        for a, b in zip(one.features, other.features, strict=True):
            assert (a.name, a.kind) == (b.name, b.kind)
            scale = np.abs(a.values).max() + 1e-12
            np.testing.assert_allclose(
                b.values / scale, a.values / scale, atol=1e-6, err_msg=f"{one.key}: {a.name}"
            )


@pytest.mark.parametrize("name", sorted(library()))
def test_every_form_of_an_effect_is_the_same(contexts, name: str) -> None:
    """A formula with the same values changes the same observables by the same amount."""
    plain, by_vacuum = contexts
    effect = library()[name]
    forms = zip(effect.variants(plain), effect.variants(by_vacuum), strict=True)
    for one, other in islice(forms, _MOST):
        assert one.form == other.form
        assert one.shape == pytest.approx(other.shape)
        random = np.random.default_rng(0)
        values = [random.normal(size=_shape(term, plain)) for term in one.terms]
        signs = [_sign(name, term.parameter) for term in one.terms]
        a = contribution(plain, one, values)
        b = contribution(by_vacuum, other, [s * v for s, v in zip(signs, values, strict=True)])
        np.testing.assert_allclose(b, a, atol=1e-6 * (np.abs(a).max() + 1e-12), err_msg=one.form)


def _shape(term: Any, context: Any) -> tuple[int, ...]:
    if term.kind == "frame":
        return (6,)
    width = term.feature.shape[-1]
    return (width, context.base.shape[1]) if term.kind == "pattern" else (width,)


def _sign(effect: str, parameter: str) -> float:
    """An offset of the pressure has the sign of the set-points."""
    return -1.0 if parameter.startswith(_OFFSETS.get(effect, "?")) else 1.0


@pytest.mark.parametrize(
    ("low", "high", "begin", "far"),
    [(0.0, 60.0, 0.0, 60.0), (-60.0, 0.0, 0.0, -60.0), (-5.0, 60.0, -5.0, 60.0), (-60.0, 5.0, 5.0, -60.0)],
)
def test_a_range_begins_where_a_chamber_is_vented(low, high, begin, far) -> None:
    """At the limit nearer to no pressure, and goes from there to the other one."""
    origin, span = ends(np.array([low]), np.array([high]))
    assert (origin[0], origin[0] + span[0]) == (begin, far)


def test_a_range_that_nobody_said_begins_at_no_pressure(make_lab) -> None:
    """Of a run without limits whose set-points are all of vacuum the range goes from there to the largest one."""
    lab = make_lab(captures=20)
    data, _ = mirrored(lab, lab.dataset(lab.predict(lab.u)))
    rows = rows_of(data.drop_vars(["chamber_min", "chamber_max"]).assign_coords(_unknown(lab.chambers)))
    assert rows.origin.tolist() == [0.0] * lab.chambers
    np.testing.assert_allclose(rows.span, -lab.commanded.max(axis=0))


def _unknown(chambers: int) -> dict[str, Any]:
    return {name: ("chamber", np.full(chambers, np.nan)) for name in ("chamber_min", "chamber_max")}


def test_a_programme_is_vented_at_nothing() -> None:
    """What is planned in shares of the range begins vented, and a quarter of it is a quarter of the vacuum."""
    limits = Limits(np.array([-60.0]), np.array([0.0]), np.array([100.0]))
    assert limits.rest == (0.0,)
    assert limits.actuation([0.25]).tolist() == [-15.0]


def test_solved_curves_are_the_same() -> None:
    """How far a chamber of a simulated surface goes over its range does not depend on the sign of the vacuum."""
    low, high = np.zeros(1), np.full(1, HIGH_KPA)
    filled, sucked = solved_curves(_Solved(1.0), low, high), solved_curves(_Solved(-1.0), -high, low)
    for one, other in zip(filled, sucked, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-9)
    assert np.ptp(filled[0]) > 0.5


class _Solved(SimulatorModel):
    """A surface of one chamber and one observable that saturates; vacuum of `sign` -1 fills it."""

    def __init__(self, sign: float) -> None:
        self.sign = sign

    def simulate(self, actuation: np.ndarray) -> np.ndarray:
        return np.tanh(self.sign * actuation / 40.0)

    def slope(self, actuation: np.ndarray) -> np.ndarray:
        return self.sign / 40.0 / np.cosh(actuation / 40.0)[:, None, :] ** 2


def test_a_wall_is_met_by_vacuum_too(make_lab) -> None:
    """A stop that holds a bellows back from 40 kPa of vacuum on is contact, as it is where pressure fills it."""
    lab = make_lab(captures=60, chambers=2)
    beyond = np.maximum(lab.u - 40.0, 0.0)
    data, model = mirrored(lab, lab.dataset(lab.predict(lab.u - 0.8 * beyond**1.2) + lab.noise()))
    first = verdict_of(data, model).considered[0]
    assert first.effect == "contact"
    assert first.probability > 0.5
