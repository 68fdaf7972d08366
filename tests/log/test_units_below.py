"""Units in the row below the names: of every file, beside what the mapping says."""

from pathlib import Path

import pytest

from labrig import LabrigError
from labrig.log import import_guessed, import_table

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
