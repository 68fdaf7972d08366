"""Effects inside a simulator's mechanics: a parameter that is off is named, measured, and right beyond the data."""

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig.diagnosis import compare, diagnose
from labrig.model import Model
from labrig.physics import Shell, load_shell

HOLD_S = np.array([3.0, 3.5, 4.0])
SURPLUS = 0.04


def measured(known: Shell, true: Shell, pressure_kpa: np.ndarray, seed: int):
    """A campaign of settled shapes of `true`, exactly solved, with 0.05 mm of noise."""
    import xarray as xr

    noise = np.random.default_rng(seed)
    at_markers = known.spline.basis(known.marker_uv)
    shapes = [at_markers @ true.solve(p).control_mm.reshape(-1, 3) for p in pressure_kpa]
    n, chambers = pressure_kpa.shape
    position = np.array(shapes)[:, None] + 0.05 * noise.normal(size=(n, len(HOLD_S), *shapes[0].shape))
    start = 10.0 * np.arange(n)
    return xr.Dataset(
        {
            "commanded": (("capture", "chamber"), pressure_kpa, {"units": "kPa"}),
            "hold_s": (("capture", "time"), np.tile(HOLD_S, (n, 1))),
            "time_s": (("capture", "time"), start[:, None] + HOLD_S),
            "event_time_s": ("event", start),
            "event_commanded": (("event", "chamber"), pressure_kpa),
            "position_mm": (("capture", "time", "marker", "axis"), position),
            "rest_mm": (("marker", "axis"), at_markers @ known.control_rest_mm.reshape(-1, 3)),
        },
        coords={
            "chamber": list(known.chamber_names),
            "chamber_min": ("chamber", np.zeros(chambers)),
            "chamber_max": ("chamber", np.full(chambers, 60.0)),
            "session": ("capture", ["s"] * n),
            "event_session": ("event", ["s"] * n),
            "event_of": ("capture", np.arange(n)),
            "repeat": ("capture", [""] * n),
            "marker": list(known.marker_names),
            "axis": list("xyz"),
        },
    )


@pytest.mark.slow
def test_a_tighter_sheet_is_named_and_right_beyond_the_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pre-stretch that the simulator does not have is found as such, and ends most of the error, also at
    pressures that no capture had."""
    monkeypatch.chdir(tmp_path)
    shell = yaml.safe_load((files("labrig.physics") / "shells" / "membrane4.yaml").read_text("utf-8"))
    shell["control_points"] = [12, 12]
    Path("small.yaml").write_text(yaml.safe_dump(shell))
    rig = {
        "name": "small",
        "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "simulated": {"shell": "small.yaml"},
    }
    Path("rig.yaml").write_text(yaml.safe_dump(rig))
    Path("model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    known = load_shell("small.yaml")
    true = known.changed(prestretch_1=known.parameters["prestretch_1"].value + SURPLUS)
    rng = np.random.default_rng(0)
    data = measured(known, true, rng.uniform(0, 36, (36, 4)), 1)
    result = diagnose(data, Model.load("model.yaml"))
    assert result.summary["verdict"] == "identified"
    assert result.summary["effects"] == ["tension"]
    assert result.improved is not None
    entry = result.improved.file.effects[0]
    assert entry.form == "inside the simulator"
    assert entry.parameters["prestretch"].value == pytest.approx(SURPLUS, rel=0.2)
    beyond = measured(known, true, rng.uniform(36, 60, (8, 4)), 2)
    before = compare(beyond, Model.load("model.yaml")).summary["error"]["model"]
    after = compare(beyond, result.improved).summary["error"]["model"]
    assert after < 0.2 * before
