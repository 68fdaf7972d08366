"""Where model and measurement count a turn, or a quaternion's sign, in different ways, that is no error."""

import numpy as np
import pytest
import xarray as xr

from labrig.diagnosis import prepared, rows_from
from labrig.model import Model
from tests.naming import verdict_of


def angle(lab, degrees: np.ndarray) -> xr.Dataset:
    """The lab's force (n, T, 1) as an angle."""
    return lab.dataset(degrees).assign_coords(unit=("observable", ["deg"]))


def test_a_turn_is_no_error(make_lab) -> None:
    """A model that goes on to 300 degrees, and a sensor that begins again at 180: nothing is missing."""
    lab = make_lab(force=True)
    lab.reach = np.array([[120.0, 100.0, 80.0]])
    true = lab.predict(lab.u) + lab.noise(0.3, 0.5)
    seen = (true + 180) % 360 - 180
    assert verdict_of(angle(lab, seen), lab.model()).verdict == "nothing_missing"


@pytest.mark.parametrize("zero", [170.0, 180.0])
def test_an_angle_with_another_zero(make_lab, zero: float) -> None:
    """A sensor that was mounted the other way round is off by the same in each row, not by a turn more in some."""
    lab = make_lab(force=True)
    data = angle(lab, lab.predict(lab.u) + zero + lab.noise(0.3, 0.5))
    assert prepared(rows_from(data), lab.model()).context.residual.std() < 1.0


def test_what_counts_turns_stays(make_lab) -> None:
    """An angle that was seen over more than a turn is what it says, however far the model is off."""
    lab = make_lab(force=True)
    lab.reach = np.array([[300.0, 300.0, 300.0]])
    data = angle(lab, lab.predict(lab.u) + 360.0 + lab.noise(0.3, 0.5))
    residual = prepared(rows_from(data), lab.model()).context.residual
    assert np.median(residual) == pytest.approx(360.0, abs=1.0)


def test_a_quaternion_is_on_the_model_s_side(make_lab) -> None:
    """A tracker that gives the other sign of what the model says, in all rows or in some: the residual is noise."""
    lab = make_lab(chambers=2, force=True)
    half = np.deg2rad(lab.u.mean(axis=2))
    turn = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=2)
    sign = np.where(np.arange(lab.captures) % 3, -1.0, 1.0)[:, None, None]
    seen = sign * (turn + 0.003 * lab.random.normal(size=turn.shape))
    data = lab.dataset(np.zeros((*half.shape, 1)))
    data = data.drop_vars(["observed", "observable", "unit", "marker_of", "axis_of"])
    names = {"observable": ["qw", "qx", "qy", "qz"], "unit": ("observable", ["1"] * 4)}
    data = data.assign(observed=(("capture", "time", "observable"), seen)).assign_coords(
        names | {"marker_of": ("observable", [""] * 4), "axis_of": ("observable", [""] * 4)}
    )
    (lab.folder / "turn.py").write_text(
        "import numpy as np\n\n\ndef predict(u):\n    half = np.deg2rad(u.mean(axis=1))\n"
        "    return -np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=1)\n"
    )
    (lab.folder / "turn.yaml").write_text("base: {kind: python, file: turn.py, function: predict}\n")
    residual = prepared(rows_from(data), Model.load(lab.folder / "turn.yaml")).context.residual
    assert residual.std() == pytest.approx(0.003, rel=0.1)
