"""Absolute pressures are not taken for gauge pressures: 14.7 psia is vented."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table
from labrig.tables._names import take_apart

GAUGE = np.repeat([0.0, 30.0, 20.0, 0.0, 10.0, 25.0], 5)
AIR = {"kPa": 101.325, "bar": 1.01325, "psi": 14.6959}
KPA = {"kPa": 1.0, "bar": 100.0, "psi": 6.894757}


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder of the test."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(columns: dict[str, Any], below: list[str] | None = None) -> Path:
    """A table of a clock, some pressures and a force; with a row of units below the names."""
    frame = pd.DataFrame({"t": np.arange(30.0), **columns, "force": 2 * GAUGE + 1})
    names, rows = frame.to_csv(index=False).split("\n", 1)
    Path("t.csv").write_text("\n".join([names, *([",".join(below)] if below else []), rows]))
    return Path("t.csv")


@pytest.mark.parametrize(
    ("name", "absolute"),
    [
        ("p_psia", True),
        ("p [bar(a)]", True),
        ("p_barA", True),
        ("p [kPa abs]", True),
        ("p / kPa abs", True),
        ("p_kPaA", True),
        ("p_abs_kPa", True),
        ("Druck absolut [mbar]", True),
        ("p_psig", False),
        ("p [bar(g)]", False),
        ("p (kPa(g))", False),
        ("p_Pa", False),
        ("abs_force_N", False),
    ],
)
def test_a_name_says_that_a_pressure_is_absolute(name: str, absolute: bool) -> None:
    """In its unit, or in a word where its unit is one of pressure."""
    assert take_apart(name).absolute == absolute


@pytest.mark.parametrize(
    ("name", "unit"),
    [("p_psia", "psi"), ("p_set [bar(a)]", "bar"), ("p_set [kPa abs]", "kPa"), ("p_kPaA", "kPa")],
)
def test_of_an_absolute_command_the_air_is_taken_off(name: str, unit: str) -> None:
    """A guess takes off one standard atmosphere, and says so; a mapping that takes nothing off is asked."""
    path = write({name: GAUGE / KPA[unit] + AIR[unit]})
    run, guess, written = import_guessed([path], Path("run"))
    (entry,) = guess.mapping["actuation"]
    assert (entry["unit"], entry["offset"]) == (unit, -AIR[unit])
    assert run["commanded"].values.min() == pytest.approx(0.0, abs=1e-6)
    said = f"{name!r} is an absolute pressure: one standard atmosphere, {AIR[unit]:g} {unit}, is taken off"
    assert any(line.startswith(said) for line in guess.remarks)
    mapping = yaml.safe_load(written.read_text())
    del mapping["actuation"][0]["offset"]
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    again = import_table(Path("map.yaml"), Path("again"))
    assert any(f"column {name!r} is called an absolute" in line for line in again.attrs["import_remarks"])


def test_a_gauge_pressure_is_as_it_is_written() -> None:
    """Nothing is taken off, and nothing is said."""
    run, guess, _ = import_guessed([write({"p_set_psig": GAUGE})], Path("run"))
    assert "offset" not in guess.mapping["actuation"][0]
    assert not any("absolute" in line for line in [*guess.remarks, *run.attrs["import_remarks"]])


def test_an_absolute_sensor_is_compared_with_a_gauge_command() -> None:
    """The air is taken off the sensor alone, also where it has another unit; a barometer keeps its number."""
    noise = 0.1 * np.sin(np.arange(30))
    path = write(
        {"p_set_kPa": GAUGE, "p_meas_bara": 1.01325 + (GAUGE + noise) / 100, "p_amb [kPa abs]": 99.0}
    )
    run, guess, _ = import_guessed([path], Path("run"))
    (sensor,) = guess.mapping["measured"]
    assert (sensor["unit"], sensor["scale"], sensor["offset"]) == ("kPa", 100.0, -101.325)
    assert np.nanmax(np.abs(run["measured"] - run["commanded"])) < 0.2
    assert all("offset" not in entry for entry in guess.mapping["covariates"])


def test_a_row_of_units_says_it() -> None:
    """What the row below the names says of a pressure counts as its name does."""
    guess = guess_mapping(write({"p": GAUGE + 101.325}, ["s", "kPa abs", "N"]))
    assert guess.mapping["actuation"] == [{"column": "p", "name": "p", "unit": "kPa", "offset": -101.325}]


@pytest.mark.parametrize(("unit", "plain", "air"), [("psia", "psi", 14.6959), ("bar(a)", "bar", 1.01325)])
def test_an_absolute_unit_in_a_mapping_is_refused(unit: str, plain: str, air: float) -> None:
    """It says what to write: the unit, and the offset with one atmosphere less; where it is observed, the unit."""
    write({"p": GAUGE})
    mapping: dict[str, Any] = {
        "table": "t.csv",
        "time": {"column": "t"},
        "actuation": [{"column": "p", "name": "p", "unit": unit, "offset": 0.5}],
        "observables": [{"column": "force", "name": "F", "unit": "N"}],
    }
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    with pytest.raises(LabrigError) as error:
        import_table(Path("map.yaml"), Path("run"))
    assert str(error.value) == (
        f"map.yaml: actuation 'p': unit {unit!r} is an absolute pressure; write 'unit: {plain}, offset: "
        f"{0.5 - air:.6g}' (less one standard atmosphere; the air's own pressure is better)"
    )
    mapping["actuation"][0]["unit"], mapping["observables"][0]["unit"] = "kPa", unit
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    with pytest.raises(LabrigError) as error:
        import_table(Path("map.yaml"), Path("run"))
    assert str(error.value).endswith(f"'F': unit {unit!r} is an absolute pressure; write 'unit: {plain}'")
