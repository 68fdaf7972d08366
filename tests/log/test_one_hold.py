"""A table whose input stands still all through: one hold, whatever its rows are; no hold where something else moved."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from tests.log.one_force import run_of

from .test_streams import NOISE, N, T, imported

LEAK = 50 * np.exp(-T / 40)
DRIVEN = np.sin(2 * np.pi * T / 10)


def held(u: np.ndarray, force: np.ndarray, **more: object):
    """A run of an input (n,) and a force (n,), cut by the plateaus of the input."""
    return run_of(pd.DataFrame({"t": T[: len(u)], "p": u, "F": force}), **more)


@pytest.mark.parametrize(
    ("u", "force"),
    [
        (np.full(N, 50.0), LEAK + 0.1 * NOISE),
        (np.full(N, 50.0), NOISE),
        (np.zeros(N), LEAK),
        (np.full(N, 50.0), LEAK + 20 * np.exp(-T) * np.cos(5 * T)),
        (np.full(N, 50.0), 20 + np.round(0.4 * NOISE)),
        (50 + 0.1 * NOISE, LEAK),
        (50 + np.round(0.1 * NOISE, 1), LEAK),
    ],
    ids=["leak", "noise", "vented", "vibration", "flicker", "noisy input", "rounded input"],
)
def test_a_single_plateau_is_one_capture(desk: Path, u: np.ndarray, force: np.ndarray) -> None:
    """Whether a leak, noise or a vibration at its beginning is all that is seen: all rows are of one hold."""
    run = held(u, force)
    assert (run.sizes["capture"], run.sizes["time"]) == (1, N)
    assert run["commanded"].values[0] == pytest.approx(u.mean())
    assert run["hold_s"].values[0] == pytest.approx(T)
    assert run.attrs["import_remarks"] == []


def test_a_single_plateau_was_actuated_before(desk: Path) -> None:
    """What `settle_s` says of a hold counts for the only one, too."""
    run = held(np.full(N, 50.0), LEAK, settle_s=3)
    assert run["hold_s"].values[0] == pytest.approx(T + 3.0)
    assert run["event_time_s"].values == pytest.approx([-3.0])


@pytest.mark.parametrize("force", [DRIVEN, DRIVEN + 0.05 * NOISE], ids=["exact", "noisy"])
def test_what_something_else_drives_is_no_hold(desk: Path, force: np.ndarray) -> None:
    """A body that goes to and fro while no input moves was moved by something else: no row is lost, and it is said."""
    run = held(np.full(N, 50.0), force)
    assert run.sizes["capture"] == N
    assert any("no input moves, and 'F' goes back and forth" in r for r in run.attrs["import_remarks"])


def test_each_session_and_file_may_be_one_hold(desk: Path) -> None:
    """Files of one plateau each are a capture each."""
    for name, level in (("a.csv", 20.0), ("b.csv", 50.0)):
        pd.DataFrame({"t": T, "p": level, "F": LEAK}).to_csv(name, index=False)
    run = held(np.full(N, 50.0), LEAK, table=["a.csv", "b.csv"])
    assert run["commanded"].values[:, 0].tolist() == [20.0, 50.0]


def test_one_step_and_a_plateau_are_one_hold(desk: Path) -> None:
    """Two rows before the only plateau are its history, and are not compared."""
    run = imported(np.r_[0.0, 25.0, np.full(N - 2, 50.0)], capture={"per": "segment"})
    assert (run.sizes["capture"], run.sizes["time"]) == (1, N - 2)
    assert run["event_commanded"].values[:, 0].tolist() == [0.0, 25.0, 50.0]
    assert run.attrs["import_remarks"] == [
        f"t.csv: 1 hold; 2 of {N} rows beside it, where the input moves, are history and are not compared"
    ]


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_one_hold_is_diagnosed_without_a_warning_of_numpy(desk: Path) -> None:
    """What is asked from one capture to the next is not asked of one: no mean of nothing is taken."""
    rng = np.random.default_rng(0)
    t = np.arange(40) * 0.5
    bent = 30 * np.exp(-t / 40)
    places = {
        f"m{i}.{a}_mm": scale * (i + 1) * bent + rng.normal(0, 0.05, 40)
        for i in range(2)
        for a, scale in (("x", 1.0), ("y", 0.1), ("z", -0.5))
    }
    frame = pd.DataFrame({"t_s": t, "p_set_kPa": 50.0, **places})
    run = labrig.import_table(frame, "run")
    assert run.sizes["capture"] == 1
    k = [scale * (i + 1) * 0.6 for i in range(2) for scale in (1.0, 0.1, -0.5)]
    found = labrig.diagnose(run, lambda u: u[:, :1] * np.array(k))
    assert np.isfinite(found.error["base"])


@pytest.mark.parametrize("rows", [1, 2, 3, 4])
@pytest.mark.parametrize("seen", [True, False])
def test_a_vent_of_one_row_between_holds(desk: Path, rows: int, seen: bool) -> None:
    """Rows that follow each other at one command are a hold, however few, and the vent between two is none of them: a
    capture where it was measured, and history where it was not.
    """
    p = [50.0, 12.5, 81.0, 33.0, 64.5, 20.0, 90.0, 47.0]
    u = np.array([v for one in p for v in (0.0, *rows * [one])])
    force = np.where((u == 0) & (not seen), np.nan, u / 9 + 0.01 * NOISE[: len(u)])
    run = run_of(pd.DataFrame({"t": 4.0 * np.arange(len(u)), "p": u, "F": force}))
    held = [v for one in p for v in ([0.0] if seen else []) + [one]]
    assert run["commanded"].values.ravel().tolist() == held
    assert run.sizes["time"] == rows
    assert run["event_commanded"].values.ravel().tolist() == u[np.r_[True, np.diff(u) != 0]].tolist()


def test_a_row_on_the_way_between_holds_is_none(desk: Path) -> None:
    """A row that a command took on its way from hold to hold is history."""
    u = np.repeat([0.0, 40.0, 80.0, 40.0, 0.0], [6, 1, 6, 1, 6])
    run = run_of(pd.DataFrame({"t": np.arange(20.0), "p": u, "F": u / 9 + 0.01 * NOISE[:20]}))
    assert run["commanded"].values.ravel().tolist() == [0.0, 80.0, 0.0]
