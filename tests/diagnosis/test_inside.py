"""Effects inside a simulator's mechanics: a parameter that is off is named, measured, and right beyond the data."""

from collections.abc import Callable
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from labrig.diagnosis import compare, improve
from labrig.model import Model
from labrig.physics import Shell, load_shell
from tests.naming import verdict_of

SURPLUS = 0.04


def measured(known: Shell, true: Shell, pressure_kpa: np.ndarray, seed: int):
    """A campaign of settled shapes of `true`, exactly solved, with 0.05 mm of noise, as the benchmark makes it."""
    benchmark = run_path(str(Path(__file__).parents[2] / "benchmarks" / "extrapolate.py"))
    clean = benchmark["positions"](known, true, pressure_kpa)[:, None]
    noise = np.random.default_rng(seed).normal(size=(len(clean), len(benchmark["HOLD_S"]), *clean.shape[2:]))
    return benchmark["campaign"](known, pressure_kpa, clean + 0.05 * noise)


@pytest.mark.slow
def test_a_tighter_sheet_is_named_and_right_beyond_the_data(
    small_rig: Callable[[int], None],
) -> None:
    """A pre-stretch that the simulator does not have is found as such, and ends most of the error, also at
    pressures that no capture had."""
    small_rig(10)
    Path("model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    known = load_shell("small.yaml")
    true = known.changed(prestretch_1=known.parameters["prestretch_1"].value + SURPLUS)
    rng = np.random.default_rng(0)
    data = measured(known, true, rng.uniform(0, 36, (24, 4)), 1)
    assert "tension" in verdict_of(data, Model.load("model.yaml")).effects
    result = improve(data, Model.load("model.yaml"), ["tension"])
    assert result.improved is not None
    entry = result.improved.file.effects[0]
    assert entry.form == "inside the simulator"
    assert entry.parameters["prestretch"].value == pytest.approx(SURPLUS, rel=0.2)
    beyond = measured(known, true, rng.uniform(36, 60, (4, 4)), 2)
    before = compare(beyond, Model.load("model.yaml")).summary["error"]["model"]
    after = compare(beyond, result.improved).summary["error"]["model"]
    assert after < 0.2 * before
