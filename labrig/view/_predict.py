"""What the live view compares the markers with: the simulator that a model starts from."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.view._live import Predict


def live_predict(model: Path, markers: Sequence[str] = ()) -> Predict:
    """A function from pressures (C,) kPa to `markers` (M, 3) mm, by the base of `model`.

    Without its effects, which need a campaign's history. Raises `LabrigError` where the base is no simulator, or lacks
    a marker.
    """
    from labrig.model import read_model_file
    from labrig.physics import load_surface, of_rig_file, read_rig_file

    base = read_model_file(model).base
    if base.kind != "simulator":
        raise LabrigError(
            f"{model}: base: the live view needs a simulator to predict with, this is '{base.kind}'"
        )
    path = model.parent / base.rig
    with of_rig_file(path):
        surface = load_surface(read_rig_file(path), path.parent, base.parameters)
    names = list(surface.marker_names)
    for marker in markers:
        if marker not in names:
            raise LabrigError(f"{path}: the simulator knows nothing of marker {marker!r}, which the rig has")
    order = [names.index(marker) for marker in markers or names]

    def predict(pressure_kpa: Floats) -> Floats:
        return np.asarray(surface.predict(pressure_kpa[None])[0], dtype=float)[order]

    return predict
