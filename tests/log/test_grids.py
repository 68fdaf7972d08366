"""Depth maps: a grid of heights is as many observables as can be used, from all over it."""

from pathlib import Path

import numpy as np
import pytest

from labrig.log import import_guessed

T, P = np.arange(40) * 5.0, np.random.default_rng(1).uniform(0, 60, 40)


def imported(folder: Path, heights: np.ndarray) -> tuple[list[str], list[str]]:
    """The observables of a file with these heights (40, ...) beside a clock and a command, and what is said of it."""
    np.savez(
        folder / "map.npz", t=T, p_cmd=P, Z=heights + np.random.default_rng(2).normal(0, 1, heights.shape)
    )
    run, guess, _ = import_guessed([folder / "map.npz"], folder / "run")
    names = [str(name) for name in run["observable"].values]
    return names, [line for line in guess.remarks if "array" in line]


@pytest.mark.parametrize(("shape", "step"), [((30, 40), 2), ((36, 63), 3), ((700,), 2)])
def test_a_wide_grid_is_thinned_out_and_that_is_said(
    tmp_path: Path, shape: tuple[int, ...], step: int
) -> None:
    """Of a grid with too many points no corner is taken for the whole: each axis is read to its end, in even steps."""
    names, said = imported(tmp_path, np.zeros((40, *shape)))
    places = np.array([[int(k) for k in name.split(".")[1:]] for name in names])
    assert (places % step == 0).all()
    assert (places.max(axis=0) > np.array(shape) - 1 - step).all()
    wide, left = int(np.prod(shape)), len(names)
    assert said == [
        f"array 'Z' has {wide} numbers a row: one in {step} along each axis is read, {left} in all"
    ]


def test_coordinates_stay_together(tmp_path: Path) -> None:
    """Of many points with three coordinates each, points are left out, and no coordinate."""
    names, _ = imported(tmp_path, np.zeros((40, 300, 3)))
    assert {name.split(".")[2] for name in names} == {"0", "1", "2"}
    assert len(names) == 450


def test_a_small_grid_is_whole(tmp_path: Path) -> None:
    """Every point is there, and nothing is said; what lies beside it without a clock is named."""
    names, said = imported(tmp_path, np.zeros((40, 9, 8)))
    assert (len(names), said) == (72, [])
    np.savez(
        tmp_path / "two.npz",
        t=T,
        p_cmd=P,
        Z=np.random.default_rng(3).normal(0, 1, (40, 9)),
        x_mm=np.arange(9.0),
    )
    _, guess, _ = import_guessed([tmp_path / "two.npz"], tmp_path / "two")
    assert [line for line in guess.remarks if "clock" in line] == [
        "part '#9' ('x_mm'; 9 rows) has no clock to join it by and is left out"
    ]
