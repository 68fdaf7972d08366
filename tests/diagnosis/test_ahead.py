"""A clock that is ahead: what is measured at the end of a hold is of the next set-point."""

from pathlib import Path

import numpy as np
import pandas as pd

import labrig

STEP_S, HOLD_S, AHEAD_S = 0.1, 6.0, 0.7


def test_a_clock_that_is_ahead_is_told_of(tmp_path: Path) -> None:
    """Holds whose last rows are of the next one, from a rig that follows within some tenths of a second, have no name;
    what carries the error is said, and not that nothing recorded does.
    """
    random = np.random.default_rng(11)
    level = random.permutation(np.repeat(np.arange(0.0, 61.0, 10.0), 6))
    fine = np.repeat(level, round(HOLD_S / STEP_S))
    followed, last = np.empty_like(fine), 0.0
    for i, now in enumerate(fine):  # implicit Euler of a lag of 0.15 s
        last += STEP_S / (0.15 + STEP_S) * (now - last)
        followed[i] = last
    seen = np.concatenate([followed[round(AHEAD_S / STEP_S) :], np.full(round(AHEAD_S / STEP_S), last)])
    frame = pd.DataFrame(
        {
            "t [s]": STEP_S * np.arange(len(fine)),
            "p_set [kPa]": fine,
            "bend [deg]": 1.2 * seen + random.normal(0, 0.15, len(fine)),
        }
    )
    run = labrig.import_table(frame, tmp_path / "run")
    (tmp_path / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    found = labrig.diagnose(run, tmp_path / "model.yaml")
    assert (found.verdict, found.sure, found.possible) == ("unknown", [], [])
    assert found.summary["carried_by"] == "what is ahead of the input"
