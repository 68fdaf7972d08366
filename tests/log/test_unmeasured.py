"""Rows at which nothing was measured: they are history, and that is said."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig.log import import_guessed

P = np.random.default_rng(1).permutation(np.repeat([0.0, 10, 20, 30], 10))


@pytest.mark.parametrize("lost", [[18], [18, 30, 31]])
def test_set_points_without_a_measurement(desk: Path, lost: list[int]) -> None:
    """Set-points of which nothing was measured are no captures, and how many, where and why is said."""
    force = 0.5 * P + 0.01 * np.arange(40)
    force[lost] = np.nan
    pd.DataFrame({"t_s": 10 * np.arange(40.0), "p_set_kPa": P, "force_N": force}).to_csv("t.csv", index=False)
    run, _, _ = import_guessed([Path("t.csv")], Path("run"))
    assert run.sizes["capture"] == 40 - len(lost)
    have, more = ("has", "") if len(lost) == 1 else ("have", ", ...")
    assert (
        f"t.csv: {len(lost)} of 40 rows {have} no measurement (line 20{more}): what was commanded there is history, "
        "and there is nothing to compare" in run.attrs["import_remarks"]
    )


def test_nothing_is_said_of_single_gaps_within_a_hold(desk: Path) -> None:
    """A hold of which some rows were measured is a capture, and no set-point is said to be lost."""
    force = np.repeat([0.0, 5, 10, 15], 10) + 0.01 * np.arange(40)
    force[[3, 17]] = np.nan
    frame = {"t_s": np.arange(40.0), "p_set_kPa": np.repeat([0.0, 10, 20, 30], 10), "force_N": force}
    pd.DataFrame(frame).to_csv("t.csv", index=False)
    run, _, _ = import_guessed([Path("t.csv")], Path("run"))
    assert not any("no measurement" in line for line in run.attrs["import_remarks"])
