"""The pressures of a run as a base takes them: their unit, vacuum, and how far the base is known."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.effects import Rows, rows_of
from labrig.log._dataset import CampaignArrays, to_dataset
from labrig.log._layout import Layout
from labrig.model import Model
from labrig.surface import Spline
from labrig.surrogate import TrainingSet, save_model, train_forward

CHAMBERS = ("left", "right")
SHELL = {
    "name": "sheet",
    "control_points": [10, 10],
    "core": {"kind": "plane", "width": 160, "height": 120},
    "layers": [{"modulus": 400, "thickness": 2, "prestretch": 1.05}],
    "chambers": [{"name": n, "u": u, "v": [0.06, 0.94]} for n, u in (("left", [0.06, 0.48]), ("right", [0.52, 0.94]))],
    "markers": {"m1": [0.27, 0.5], "m2": [0.7, 0.4]},
}  # fmt: skip
RIG = {"name": "r", "chambers": [{"name": n, "max_kpa": 50} for n in CHAMBERS], "simulated": {"shell": SHELL}}


def learned(folder: Path) -> None:
    """A forward model of a sheet with two markers, trained on pressures up to 60 kPa."""
    pressure, spline = np.random.default_rng(0).random((30, 2)) * 60.0, Spline((6, 6), 2)
    u, v = np.meshgrid(*spline.greville, indexing="ij")
    control = np.tile(np.stack([100 * u, 0 * u, 100 * v], axis=-1), (30, 1, 1, 1))
    control[..., 1] += np.einsum("fc,cij->fij", pressure, np.stack([u * (1 - u), v * (1 - v) * u]))
    uv = np.array([[0.3, 0.4], [0.6, 0.5]])
    data = TrainingSet(
        CHAMBERS, np.zeros(2), np.full(2, 60.0), spline, pressure, control, None, ("m1", "m2"), uv
    )
    save_model(train_forward(data, samples=5).model, folder / "forward.pt")


def model_in(folder: Path, kind: str) -> Model:
    """A model whose base is a shell, or one that was learned."""
    base: dict[str, Any] = {"kind": kind, "file": "forward.pt"}
    if kind == "simulator":
        (folder / "rig.yaml").write_text(yaml.safe_dump(RIG))
        base = {"kind": kind, "rig": "rig.yaml"}
    else:
        learned(folder)
    (folder / "model.yaml").write_text(yaml.safe_dump({"base": base}))
    return Model.load(folder / "model.yaml")


def rows_at(u: Any, unit: str = "kPa", low: float = 0.0, high: float = 50.0) -> Rows:
    """A campaign at set-points (n, 2) of two chambers with limits `low` and `high`; what was seen does not matter."""
    u = np.asarray(u, float)
    n = len(u)
    layout = Layout(
        source="rig", chambers=CHAMBERS, chamber_min=(low, low), chamber_max=(high, high), markers=("m1", "m2"),
        unit=unit, session="1", start_s=0.0,
    )  # fmt: skip
    arrays = CampaignArrays(
        commanded=u,
        hold_s=np.full((n, 1), 3.0),
        time_s=np.arange(float(n))[:, None] * 4,
        settled=np.ones((n, 1), bool),
        event_time_s=np.arange(float(n)) * 4,
        event_commanded=u,
        session=["1"] * n,
        repeat=[""] * n,
        event_session=["1"] * n,
        event_of=np.arange(n),
        position_mm=np.zeros((n, 1, 2, 3)),
    )
    return rows_of(to_dataset(arrays, layout, {"run": "test"}))


POINTS = np.array([[0.0, 0.0], [20.0, 5.0], [8.0, 45.0]])


@pytest.mark.parametrize("kind", ["simulator", "surrogate"])
@pytest.mark.parametrize(("unit", "each"), [("mbar", 10.0), ("bar", 0.01), ("Pa", 1000.0)])
def test_a_run_in_another_unit_of_pressure_is_predicted_alike(
    tmp_path: Path, kind: str, unit: str, each: float
) -> None:
    """The same shapes, and slopes by the unit of the run."""
    model = model_in(tmp_path, kind)
    known, other = (
        model.context(rows_at(k * POINTS, name, high=50.0 * k)) for name, k in (("kPa", 1.0), (unit, each))
    )
    assert np.ptp(known.base, axis=0).max() > 3.0
    np.testing.assert_allclose(other.base, known.base, atol=1e-9)
    np.testing.assert_allclose(other.jacobian * each, known.jacobian, atol=1e-9)


@pytest.mark.parametrize(
    ("kind", "file"), [("simulator", "rig.yaml"), ("surrogate", "forward.pt")], ids=["simulator", "surrogate"]
)
@pytest.mark.parametrize("unit", ["mm", ""])
def test_what_is_no_pressure_is_refused(tmp_path: Path, kind: str, file: str, unit: str) -> None:
    """A base that knows pressures takes neither lengths nor numbers without a unit for them."""
    with pytest.raises(LabrigError) as caught:
        model_in(tmp_path, kind).context(replace(rows_at(POINTS), actuation_unit=unit))
    said = f"{tmp_path / file}: needs pressures; the run's actuation is in {unit or 'no unit'}"
    assert str(caught.value) == said


@pytest.mark.parametrize("value", [-30.0, np.nan])
def test_a_shell_is_not_asked_for_a_vacuum(tmp_path: Path, value: float) -> None:
    """Air cannot pull it through its core: the chamber is named, and nothing is predicted as if it were vented."""
    rows = rows_at(POINTS, low=-30.0)
    actuation = np.where(rows.actuation == 5.0, value, rows.actuation)
    with pytest.raises(LabrigError) as caught:
        model_in(tmp_path, "simulator").context(replace(rows, actuation=actuation))
    rig = tmp_path / "rig.yaml"
    assert str(caught.value) == f"{rig}: its shell knows no vacuum, and chamber right is at {value:g} kPa"


def test_a_zero_that_is_off_and_limits_that_are_not_used_are_no_vacuum(tmp_path: Path) -> None:
    """Half a kPa below vented is vented; where a rig may go to vacuum but has not, a chamber does not move there."""
    model = model_in(tmp_path, "simulator")
    plain, off = (model.context(rows_at(POINTS - by)) for by in (0.0, 0.5 * (POINTS == 0)))
    np.testing.assert_allclose(off.base, plain.base)
    shares = np.linspace(0.0, 1.0, 5)[:, None] * np.full(2, 60.0) - 10.0
    alone = model.context(rows_at(POINTS, low=-10.0)).alone
    assert alone is not None
    curves = alone(np.full(2, -10.0), np.full(2, 50.0))
    moved = curves.at(shares)
    np.testing.assert_allclose(moved[0], 0.0, atol=1e-6)
    assert (np.diff(moved[1:], axis=0) > 0.1).all()
    narrow = alone(np.zeros(2), np.full(2, 50.0))
    np.testing.assert_allclose(curves.slope(shares[2:]), narrow.slope(shares[2:]) * 60 / 50, rtol=0.1)


@pytest.mark.parametrize(
    ("kind", "far", "said"),
    [
        ("simulator", 52.0, ""),
        ("simulator", 90.0, "right 0 to 50 kPa (here 0 to 90)"),
        ("surrogate", 62.0, ""),
        ("surrogate", 75.0, "right 0 to 60 kPa (here 0 to 75)"),
    ],
)
def test_a_base_says_where_it_is_not_known(tmp_path: Path, kind: str, far: float, said: str) -> None:
    """A shell beyond its highest pressure, a learned model beyond what it learned from: a line names the chamber."""
    model = model_in(tmp_path, kind)
    context = model.context(rows_at([*POINTS, [0.0, far]], high=100.0))
    found = [line for line in context.rows.warnings if line.startswith("base")]
    assert found == (
        [
            f"base ({kind}): it is known from {said}; beyond that it says little, and what it is off by may be taken "
            "for an effect"
        ]
        if said
        else []
    )
