"""A rig's history as pictures."""

from typing import Any

import pytest

from labrig.view import history_pictures

DAYS = ["2026-02-03 08:15", "2026-03-09 10:00"]


def history(dates: list[str]) -> Any:
    """The content of history.json of a rig whose error was 0.2 mm in each run."""
    error = {"group": "error", "name": "error", "unit": "mm", "runs": [*range(len(dates))]}
    error |= {"value": [[0.2]] * len(dates), "sd": [0.01] * len(dates)}
    runs = [{"run": date, "date": date, "procedure": "capture", "kind": "a"} for date in dates]
    return {"runs": runs, "quantities": [error], "changes": [], "fitted_until": None}


@pytest.mark.parametrize("count", [1, 2])
def test_a_single_run_stands_at_its_date(count: int) -> None:
    """The axis of one run has its date and time, on the days around it; of several it is left to the plot."""
    axis = history_pictures(history(DAYS[:count]))["error"]()["layout"]["xaxis"]
    assert axis["type"] == "date"
    assert axis.get("tickvals") == (DAYS[:1] if count == 1 else None)
    assert axis.get("range") == (["2026-02-02 08:15:00", "2026-02-04 08:15:00"] if count == 1 else None)
