"""Units in the row below the names: of every file, beside what the mapping says."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table

NAMES = "t,p_set,x,y,z"
ROWS = "".join(f"\n{t},{t % 3 * 10},{t % 3},{t % 3 * 2},{t % 3 * 3}.5" for t in range(24))
MAP = """
table: a.csv
format: {units_row: true}
time: {column: t, unit: s}
actuation: [{column: p_set, name: p, unit: kPa}]
observables: [{column: x, name: x, unit: mm}]
"""


def write(name: str, units: str) -> Path:
    """A table with a row of units."""
    Path(name).write_text(f"{NAMES}\n{units}{ROWS}\n")
    return Path(name)


@pytest.mark.parametrize("units", ["s,kPa,cm,cm,cm", "s,bar,mm,mm,mm", "ms,kPa,mm,mm,mm"])
def test_files_in_different_units(desk: Path, units: str) -> None:
    """Two files whose rows of units differ are not taken for one unit: the second is refused by name."""
    tables = [write("a.csv", "s,kPa,mm,mm,mm"), write("b.csv", units)]
    with pytest.raises(
        LabrigError, match=r"^b\.csv: column '\w+' \(.*\) is in (cm|bar|ms), as the table says"
    ):
        import_guessed(tables, Path("run"))
    assert not Path("run").exists()


def test_a_mapping_of_yesterday(desk: Path) -> None:
    """A mapping that calls a unit otherwise than today's table is refused, and one that spells it otherwise is not."""
    Path("m.yaml").write_text(MAP)
    write("a.csv", "sec,bar,mm,mm,mm")
    with pytest.raises(
        LabrigError, match=r"'p_set' \(actuation p\) is in bar, as the table says, and in kPa"
    ):
        import_table(Path("m.yaml"), Path("run"))
    write("a.csv", "sec,kPa,millimeter,mm,mm")
    assert import_table(Path("m.yaml"), Path("run"))["observed"].max() == 2


def test_a_row_of_wrong_units(desk: Path) -> None:
    """Who knows better than the row of units leaves it out, or gives a scale."""
    write("a.csv", "s,bar,mm,mm,mm")
    Path("m.yaml").write_text(MAP.replace("units_row: true", "units_row: false"))
    assert import_table(Path("m.yaml"), Path("one"))["commanded"].max() == 20
    Path("m.yaml").write_text(MAP.replace("unit: kPa}", "unit: kPa, scale: 100}"))
    assert import_table(Path("m.yaml"), Path("two"))["commanded"].max() == 2000


@pytest.mark.parametrize(("times", "unit"), [(1.0, "kPa"), (0.01, "1")])
def test_a_command_beside_its_sensor(tmp_path: Path, times: float, unit: str) -> None:
    """A command without a unit is in that of its sensor where both have one size, and that is said; else in none."""
    p = np.tile([0.0, 10, 20, 30, 20, 10], 10)
    noise = np.random.default_rng(5).normal(0, 0.1, (60, 2))
    frame = pd.DataFrame(
        {
            "t_s": np.arange(60.0),
            "p_cmd": times * p,
            "p_meas_kPa": p + noise[:, 0],
            "bend_deg": p + noise[:, 1],
        }
    )
    frame.to_csv(tmp_path / "t.csv", index=False)
    guess = guess_mapping(tmp_path / "t.csv")
    assert [a["unit"] for a in guess.mapping["actuation"]] == [unit]
    said = "the unit of 'p_cmd' is not said: taken as kPa, in which its sensor 'p_meas_kPa' has its size"
    assert (said in guess.remarks) == (unit == "kPa")
