"""Sensors of several kinds: a second one beside the laboratory's force, two beside its markers; and models of them."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tests.conftest import HIGH_KPA

if TYPE_CHECKING:
    import xarray as xr

    from labrig.model import Model


def two_sensors(lab: Any, force: np.ndarray, second: "np.ndarray | float") -> "xr.Dataset":
    """A campaign of the lab's force (n, T, 1), N, and of a second sensor that reads `second` in volts."""
    data = lab.dataset(force)
    first = data["observed"].values
    both = np.concatenate(
        [first, np.where(np.isfinite(first), second, np.nan)], axis=2
    )  # no rows in the padding
    names = {"observable": ["force", "voltage"], "unit": ("observable", ["N", "V"])}
    none = {"marker_of": ("observable", ["", ""]), "axis_of": ("observable", ["", ""])}
    data = data.drop_vars(["observed", "observable", "unit", "marker_of", "axis_of"])
    return data.assign(observed=(("capture", "time", "observable"), both)).assign_coords(names | none)


def model_of_both(lab: Any) -> "Model":
    """The lab's model with the second sensor beside the force, to which it is equal."""
    model = lab.model()
    path = lab.folder / "base.py"
    path.write_text(
        path.read_text() + "\n\nalone = predict\n\n\ndef predict(u):\n    return np.tile(alone(u), (1, 2))\n"
    )
    return type(model).load(lab.folder / "model.yaml")


_REACH = {"force": ("N", 40.0, 0.1), "voltage": ("V", 2.0, 0.01)}
"""Two sensors: unit, how far a full chamber moves each (the next ones less), noise of rows and of captures."""


def beside_markers(lab: Any, positions: np.ndarray, u: np.ndarray) -> "tuple[xr.Dataset, Model]":
    """A campaign of the lab's markers (n, T, K), and of a force and a voltage that see its chambers at pressures u

    (n, T, C) and have noise of their own; and a model of both.
    """
    less = np.linspace(1.0, 0.5, lab.chambers)
    reach = np.stack([most * less for _, most, _ in _REACH.values()], axis=1)
    noise = np.array([size for *_, size in _REACH.values()])
    x = u / HIGH_KPA
    clean = x * (1 + lab.bent) / (1 + lab.bent * x) @ reach
    n, T, K = clean.shape
    seen = clean + noise * (lab.random.normal(size=(n, T, K)) + lab.random.normal(size=(n, 1, K)))
    data = lab.dataset(positions)
    data["observed"] = (
        ("capture", "time", "observable"),
        np.where(np.isfinite(lab.hold_s)[:, :, None], seen, np.nan),
    )
    data = data.assign_coords(
        observable=list(_REACH),
        unit=("observable", [unit for unit, *_ in _REACH.values()]),
        marker_of=("observable", ["", ""]),
        axis_of=("observable", ["", ""]),
    )
    model, path = lab.model(), lab.folder / "base.py"
    path.write_text(
        path.read_text()
        + "\n\nmarkers = predict\n\n\ndef predict(u):\n"
        + f"    x = u / {HIGH_KPA}\n    x = x * {1 + lab.bent} / (1 + {lab.bent} * x)\n"
        + f"    return np.concatenate([markers(u), x @ np.array({reach.tolist()})], axis=-1)\n"
    )
    return data, type(model).load(lab.folder / "model.yaml")
