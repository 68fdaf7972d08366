"""Cells that hold a number and its unit: what they are in, and what a mapping may say of them."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table

from .conftest import FRAME, F, P


def with_units(frame: pd.DataFrame) -> pd.DataFrame:
    """The table with the unit in each cell."""
    return pd.DataFrame(
        {
            "time_s": frame["time_s"],
            "set": [f"{p / 100:.2f} bar" for p in frame["p1_kpa"]],
            "scale": [f"{f:.4f}N" for f in frame["force_n"]],
            "room": [f"{21 + t / 10:.1f}°C" for t in frame["time_s"]],
        }
    )


@pytest.mark.parametrize("name", ["t.csv", "t.xlsx"])
def test_units_in_the_cells(desk: Path, name: str) -> None:
    """`0.30 bar` in each cell: the column is numbers, and its unit is that of the cells; a gap stays one."""
    frame = with_units(FRAME)
    frame.loc[13, "scale"] = None
    frame.loc[17, "scale"] = "n/a"
    frame.to_csv(name, index=False) if name.endswith("csv") else frame.to_excel(name, index=False)
    run, guess, _ = import_guessed([Path(name)], Path("run"))
    assert guess.mapping["actuation"] == [{"column": "set", "name": "set", "unit": "bar"}]
    assert guess.mapping["observables"] == [{"column": "scale", "name": "scale", "unit": "N"}]
    assert guess.mapping["covariates"] == [{"column": "room", "name": "room", "unit": "degC"}]
    assert run["commanded"].to_numpy()[:, 0] == pytest.approx(P[::10] / 100)
    seen = run["observed"].to_numpy()[:, :, 0].ravel()
    assert seen[np.isfinite(seen)] == pytest.approx(np.delete(F, [13, 17]), abs=1e-4)


def test_a_unit_that_the_cells_contradict(desk: Path) -> None:
    """A mapping that calls kPa what the cells call bar is refused, not believed; one with a scale says what it does."""
    with_units(FRAME).to_csv("t.csv", index=False)
    mapping = guess_mapping("t.csv").mapping
    mapping["actuation"][0]["unit"] = "kPa"
    Path("m.yaml").write_text(yaml.safe_dump(mapping))
    with pytest.raises(
        LabrigError,
        match=r"'set' \(actuation set\) is in bar, as the table says, and in kPa, as the mapping does; ",
    ):
        import_table(Path("m.yaml"), Path("run"))
    mapping["actuation"][0]["scale"] = 100
    Path("m.yaml").write_text(yaml.safe_dump(mapping))
    import_table(Path("m.yaml"), Path("run"))
    assert labrig.open_run("run")["commanded"].to_numpy()[:, 0] == pytest.approx(P[::10])


def test_cells_of_two_units_are_no_column_of_numbers(desk: Path) -> None:
    """mbar in some rows and bar in others: labrig converts nothing silently, and says that it leaves the column out."""
    frame = with_units(FRAME)
    frame.loc[30:, "scale"] = [f"{1000 * f:.1f} mN" for f in F[30:]]
    frame["other"] = F
    frame.to_csv("t.csv", index=False)
    guess = guess_mapping("t.csv")
    assert [o["column"] for o in guess.mapping["observables"]] == ["other"]
    assert any("'scale' holds no numbers" in r for r in guess.remarks)


def test_a_sensor_of_a_temperature_in_another_unit(desk: Path) -> None:
    """Degrees of two scales differ by more than a factor: 68 degF are 20 degC."""
    warm = np.repeat([20.0, 40.0, 30.0, 50.0], 10)
    frame = {
        "t": np.arange(40),
        "T_set [degC]": warm,
        "T_meas [degF]": warm * 1.8 + 32,
        "force [N]": warm / 7,
    }
    pd.DataFrame(frame).to_csv("t.csv", index=False)
    Path("m.yaml").write_text(
        "table: t.csv\ntime: {column: t, unit: s}\nactuation: [{column: 'T_set [degC]', name: T, unit: degC}]\n"
        "measured: [{column: 'T_meas [degF]', name: T, unit: degF}]\n"
        "observables: [{column: 'force [N]', name: force, unit: N}]\n"
    )
    assert import_table(Path("m.yaml"), Path("run"))["measured"].to_numpy().ravel() == pytest.approx(warm)
