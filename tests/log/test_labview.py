"""Text files of LabVIEW: units above the columns, and rows whose clock is in the header."""

from pathlib import Path

import numpy as np
import pytest

from labrig.log import guess_mapping, import_guessed

P = np.repeat([0.0, 5, 10, 15, 20, 10], 20)
ANGLE = 4 * P + np.random.default_rng(3).normal(0, 0.2, len(P))


def lvm(decimal: str, clock: bool, channels: int = 2) -> Path:
    """A measurement of so many channels at 10 Hz, with a column of times or without."""
    tabs = "\t" * (channels + 1)
    each = [("Channels", str(channels)), ("Date", "2019/04/23"), ("Time", "14:02:11.3382")]
    named = {"Y_Unit_Label": ("psi", "deg"), "X_Dimension": ("Time",) * 2, "X0": ("0.0E+0",) * 2}
    named["Delta_X"] = ("0.100000",) * 2
    head = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\n"
    head += f"X_Columns\t{'One' if clock else 'No'}\n***End_of_Header***\t\n\t\n"
    head += "".join(f"{name}\t{value}{tabs}\n" for name, value in each)
    head += "".join(f"{name}\t" + "\t".join(v[:channels]) + "\t\n" for name, v in named.items())
    head += f"***End_of_Header***{tabs}\nX_Value\t" + "\t".join(["P set", "Angle"][:channels]) + "\tComment\n"
    rows = "".join(
        (f"{0.1 * i:.4f}" if clock else "") + "".join(f"\t{v:.4f}" for v in (p, a)[:channels]) + "\t\n"
        for i, (p, a) in enumerate(zip(P, ANGLE, strict=True))
    )
    Path("t.lvm").write_text((head + rows).replace(".", decimal))
    return Path("t.lvm")


@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("clock", [True, False])
def test_units_and_clock_of_the_header(desk: Path, decimal: str, clock: bool) -> None:
    """The units over the columns are those of the columns, and without a column of times Delta_X is the clock."""
    run, guess, _ = import_guessed([lvm(decimal, clock)], Path("run"))
    mapping = guess.mapping
    assert [(a["name"], a["unit"]) for a in mapping["actuation"]] == [("P set", "psi")]
    assert [(o["name"], o["unit"]) for o in mapping["observables"]] == [("Angle", "deg")]
    assert mapping["time"] == ({"column": "X_Value", "unit": "s"} if clock else {"rate_hz": 10.0})
    assert run["commanded"].to_numpy().ravel().tolist() == P[::20].tolist()
    assert not any("is not said" in line for line in guess.remarks if "X_Value" not in line)


def test_a_step_that_is_no_time(desk: Path) -> None:
    """Delta_X of a spectrum is a frequency, and no clock."""
    path = lvm(".", clock=False)
    path.write_text(path.read_text().replace("Dimension\tTime\tTime", "Dimension\tFrequency\tFrequency"))
    assert "time" not in guess_mapping(path).mapping


def test_the_unit_of_lengths_above_the_names(tmp_path: Path) -> None:
    """Places of which the header says the unit are in it, however large they are."""
    rows = "".join(f"{i / 10},{p},{p / 100:.3f},{p / 50:.3f}\n" for i, p in enumerate(P))
    for unit, written in (("Meters", "m"), ("Millimeters", "mm"), ("Centimeters", "cm")):
        path = tmp_path / "t.csv"
        path.write_text(f"Format Version,1.23,Length Units,{unit}\n\nTime,p_set_kPa,m1 X,m1 Y\n{rows}")
        assert {o["unit"] for o in guess_mapping(path).mapping["observables"]} == {written}
