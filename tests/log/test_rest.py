"""Where markers are at rest, guessed from rows at which nothing is commanded."""

from pathlib import Path

import numpy as np
import pytest

import labrig
from labrig.log import guess_mapping, import_guessed

REST = np.array([[0.0, 0.0, 0.0], [0.03, 0.02, 0.0], [0.06, 0.0, 0.01]])


def write(path: Path, lowest_kpa: float = 0.0, rest: np.ndarray = REST, unit: str = "m") -> Path:
    """Holds of one chamber that lifts three markers, 0.5 mm by kPa."""
    names = [f"m{k}_{a} [{unit}]" for k in range(len(rest)) for a in "xyz"]
    lines = [",".join(["time [s]", "p [kPa]", *names])]
    for i in range(60):
        p = max(lowest_kpa, 10.0 * ((i // 10) % 3))
        lines.append(",".join(map(str, [i, p, *(rest + np.array([0, 0, 5e-4 * p])).ravel().round(6)])))
    path.write_text("\n".join(lines) + "\n")
    return path


def test_rest_is_where_nothing_is_commanded(tmp_path: Path) -> None:
    """Rows with every input at zero give the rest positions, in mm, and it is said; the run has them."""
    path = write(tmp_path / "t.csv")
    guess = guess_mapping(path)
    found = [guess.mapping["markers"][f"m{k}"]["rest"] for k in range(3)]
    assert found == pytest.approx(1000 * REST, abs=1e-3)
    assert any("their mean over 20 rows" in remark for remark in guess.remarks)
    run, _, _ = import_guessed([path], tmp_path / "run")
    assert run["rest_mm"].to_numpy() == pytest.approx(1000 * REST, abs=1e-3)
    assert "rest_mm" in labrig.open_run(tmp_path / "run")


def test_where_nobody_knows_it_is_said(tmp_path: Path) -> None:
    """Without a row at zero there is no guess, and the remark shows how to say it."""
    guess = guess_mapping(write(tmp_path / "t.csv", lowest_kpa=5.0))
    assert "markers" not in guess.mapping
    assert any("markers: {m0: {rest: [x, y, z]}}" in remark for remark in guess.remarks)


@pytest.mark.parametrize(("rest", "unit"), [(0 * REST, "m"), (REST, "px")])
def test_what_is_no_position_has_no_rest(tmp_path: Path, rest: np.ndarray, unit: str) -> None:
    """Displacements, which are all zero at rest, and pixels are not taken for places."""
    assert "markers" not in guess_mapping(write(tmp_path / "t.csv", rest=rest, unit=unit)).mapping


def test_an_axis_in_its_own_unit(tmp_path: Path) -> None:
    """A height in um beside places in mm keeps its unit: the run and the rest positions are in mm on every axis."""
    path = write(tmp_path / "t.csv", rest=1000 * REST, unit="mm")
    path.write_text(path.read_text().replace("_z [mm]", "_z [um]"))
    guess = guess_mapping(path)
    assert {o["axis"]: o["unit"] for o in guess.mapping["observables"]} == {"x": "mm", "y": "mm", "z": "um"}
    run, _, _ = import_guessed([path], tmp_path / "run")
    in_mm = 1000 * REST * [1, 1, 1e-3]
    assert run["rest_mm"].to_numpy() == pytest.approx(in_mm, abs=1e-3)
    assert run["position_mm"].to_numpy()[0, 0, 1:] == pytest.approx(in_mm[1:], abs=1e-3)


def test_a_marker_that_was_lost_is_not_at_rest(tmp_path: Path) -> None:
    """A number that stands for a lost marker (-999) is no place at rest either; where none is left, that is said."""
    path = write(tmp_path / "t.csv", unit="mm", rest=1000 * REST)
    lines = [line.split(",") for line in path.read_text().splitlines()]
    for i, line in enumerate(lines[1:]):
        line[2:5] = ["-999"] * 3 if i in (2, 3, 15) else [f"{0.001 * (i % 3 - 1):.3f}"] * 3
    path.write_text("\n".join(map(",".join, lines)) + "\n")
    assert guess_mapping(path).mapping["markers"]["m0"]["rest"] == pytest.approx([0, 0, 0], abs=1e-3)
    path.write_text("\n".join(map(",".join, [lines[0], lines[3], lines[4], *lines[11:31]])) + "\n")
    guess = guess_mapping(path)
    assert "markers" not in guess.mapping
    assert any("in no row with every input at 0 was every marker seen" in line for line in guess.remarks)
