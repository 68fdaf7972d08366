"""Places in a table that are not called x, y and z: a camera's u and v are the pixels of a marker."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig.log import Guess, guess_mapping

N = 120
P = np.repeat([0.0, 30, 10, 40, 20, 0, 50, 10, 30, 40, 0, 20], 10)
NOISE = np.random.default_rng(3).normal(0, 0.3, (N, 4))


def guess(folder: Path, **columns: np.ndarray) -> Guess:
    """The guess for a table of a pressure and these columns."""
    frame = pd.DataFrame({"time_s": np.arange(N) * 0.5, "p_set_kPa": P, **columns})
    frame.to_csv(folder / "t.csv", index=False)
    return guess_mapping(folder / "t.csv")


@pytest.mark.parametrize("sep", ["_", " ", "."])
def test_u_and_v_of_a_camera(tmp_path: Path, sep: str) -> None:
    """Columns u and v of one name are a marker's x and y in pixels, and that is said."""
    seen = {f"m1{sep}{a}": 300 + 2 * P + NOISE[:, i] for i, a in enumerate("uv")}
    seen |= {f"m2{sep}{a}": 200 + 3 * P + NOISE[:, 2 + i] for i, a in enumerate("uv")}
    found = guess(tmp_path, **seen)
    taken = [(o["column"], o["marker"], o["axis"], o["unit"]) for o in found.mapping["observables"]]
    assert taken == [(f"m{m}{sep}{a}", f"m{m}", x, "px") for m in (1, 2) for a, x in ("ux", "vy")]
    assert (
        f"columns 'm1{sep}u' and 'm1{sep}v' (and 2 more) are taken for places in an image, in px"
        in found.remarks
    )


@pytest.mark.parametrize("names", [("amp_v",), ("motor_u", "motor_v"), ("m_u", "m_v", "m_w"), ("b_u", "a_v")])
def test_volts_are_no_places(tmp_path: Path, names: tuple[str, ...]) -> None:
    """A v without its u, phases u, v and w, and what belongs to a motor are volts as before."""
    found = guess(tmp_path, **{name: 2 + 0.01 * P + NOISE[:, i] for i, name in enumerate(names)})
    observed = {o["column"]: o for o in found.mapping["observables"]}
    assert not any("marker" in o for o in observed.values())
    assert all(observed[name]["unit"] == "V" for name in names if name.endswith("_v"))


@pytest.mark.parametrize(("name", "unit"), [("Zusatz", "kg"), ("Last", "N"), ("Charge utile", "g")])
def test_a_weight_in_any_language_is_no_input(tmp_path: Path, name: str, unit: str) -> None:
    """What stands still in holds and is a mass, or a force that is called a load, hung on the body: it is beside what
    was measured.
    """
    hung = np.repeat([0.0, 0.5, 0.0, 1.0, 0.5, 1.0], 20)
    column = f"{name} [{unit}]"
    found = guess(tmp_path, **{column: hung, "force_N": 0.1 * P - hung + 0.1 * NOISE[:, 0]})
    assert [a["column"] for a in found.mapping["actuation"]] == ["p_set_kPa"]
    assert found.mapping["covariates"] == [{"column": column, "name": name, "unit": unit}]


@pytest.mark.parametrize("name", ["shot", "scan"])
def test_what_was_shot_at_a_set_point_is_its_number(tmp_path: Path, name: str) -> None:
    """A number that several rows of a set-point share names the capture, and is no measurement."""
    found = guess(tmp_path, **{name: np.arange(N) // 10, "force_N": 0.1 * P + 0.1 * NOISE[:, 0]})
    assert found.mapping["capture"] == {"column": name}
    assert [o["column"] for o in found.mapping["observables"]] == ["force_N"]


def test_shots_that_are_numbered_one_by_one_are_no_captures(tmp_path: Path) -> None:
    """Ten shots of one set-point with a number each are one capture; the number is left out, and that is said."""
    found = guess(tmp_path, shot=np.arange(N), force_N=0.1 * P + 0.1 * NOISE[:, 0])
    assert found.mapping["capture"] == {"per": "segment"}
    assert "column 'shot' counts rows and is left out" in found.remarks


def test_the_pressure_of_a_syringe_was_measured(tmp_path: Path) -> None:
    """Where volumes are commanded their pressure is an answer, and no sensor of them in another unit; that is said."""
    volume = np.repeat([0.0, 30, 10, 40, 20, 0, 50, 10, 30, 40, 0, 20], 10)
    seen = {"p_bag_kPa": 0.8 * volume + NOISE[:, 0], "angle_deg": 2 * volume + NOISE[:, 1]}
    frame = pd.DataFrame({"time_s": np.arange(N) * 0.5, "V_syringe_ml": volume, **seen})
    frame.to_csv(tmp_path / "t.csv", index=False)
    found = guess_mapping(tmp_path / "t.csv")
    assert [a["column"] for a in found.mapping["actuation"]] == ["V_syringe_ml"]
    assert [o["column"] for o in found.mapping["observables"]] == ["p_bag_kPa", "angle_deg"]
    assert "covariates" not in found.mapping
    assert any("is what 'V_syringe_ml' makes in a closed volume" in line for line in found.remarks)


def test_points_that_are_called_p(tmp_path: Path) -> None:
    """P1.X in mm is a coordinate of a point, whatever else is called p."""
    seen = {f"P{m}.{a} [mm]": 10.0 * m + P / 9 + NOISE[:, i] for m in (1, 2) for i, a in enumerate("XYZ")}
    found = guess(tmp_path, **seen)
    assert {o["marker"] for o in found.mapping["observables"]} == {"P1", "P2"}


@pytest.mark.parametrize("called", ["P0{}.{}", "P0{}_{}", "P0{} {}", "P0{} ({})"])
@pytest.mark.parametrize("axes", ["XYZ", "xy"])
@pytest.mark.parametrize("command", ["p_set_kPa", "p1_set_kPa"])
def test_points_that_say_no_unit(tmp_path: Path, called: str, axes: str, command: str) -> None:
    """P01.X, P01.Y, P02.X ... are places of points beside a command; that they are, and their unit, is said."""
    seen = {
        called.format(m, a): 20.0 * m + (5 - i) * P / 40 * (-1) ** m + NOISE[:, i]
        for m in (1, 2)
        for i, a in enumerate(axes)
    }
    pd.DataFrame({"time_s": np.arange(N) * 0.5, command: P, **seen}).to_csv(tmp_path / "t.csv", index=False)
    found = guess_mapping(tmp_path / "t.csv")
    taken = [(o["marker"], o["axis"], o["unit"]) for o in found.mapping["observables"]]
    assert taken == [(f"P0{m}", a.lower(), "mm") for m in (1, 2) for a in axes]
    assert any("look like coordinates of markers" in line for line in found.assumed)
    assert any("taken as mm: they look like markers; say the unit" in line for line in found.assumed)


def test_pressures_of_chambers_x_and_y_are_no_points(tmp_path: Path) -> None:
    """What was set without a unit, and the sensors of that, stay pressures though they have an x and a y."""
    order = [P, np.roll(P, 20), np.roll(P, 40), np.roll(P, 60)]
    called = [f"p{m}_{a}" for m in (1, 2) for a in "xy"]
    force = 0.1 * P + 0.1 * NOISE[:, 0]
    for more in ("", "_set"):
        columns = {f"{name}{more}": u for name, u in zip(called, order, strict=True)}
        if more:
            columns |= {name: u + NOISE[:, i] for i, (name, u) in enumerate(zip(called, order, strict=True))}
        pd.DataFrame({"time_s": np.arange(N) * 0.5, **columns, "force_N": force}).to_csv(
            tmp_path / "t.csv", index=False
        )
        found = guess_mapping(tmp_path / "t.csv")
        assert [a["column"] for a in found.mapping["actuation"]] == [f"{name}{more}" for name in called]
        assert [o["column"] for o in found.mapping["observables"]] == ["force_N"]


@pytest.mark.parametrize(("unit", "markers"), [("_mm", {"marker"}), ("", set()), ("_Nm", set())])
def test_mx_my_mz(tmp_path: Path, unit: str, markers: set[str]) -> None:
    """mx, my and mz are a place where their unit is a length: else they may be moments, or of a magnetometer."""
    seen = {f"m{a}{unit}": 10.0 * i + P / 9 + NOISE[:, i] for i, a in enumerate("xyz")}
    found = guess(tmp_path, **seen)
    assert {o["marker"] for o in found.mapping["observables"] if "marker" in o} == markers
