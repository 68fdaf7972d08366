"""A second sensor beside the laboratory's force, and a model that knows both."""

from typing import TYPE_CHECKING, Any

import numpy as np

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
