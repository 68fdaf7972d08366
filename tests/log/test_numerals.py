"""Decimal signs and the signs between thousands: 1.200,5 and 1,200.5 and 1'200.5 are one number."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
import yaml

from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table

STEPS = [1200, 2400, 300, 0, 1500, 600, 2100, 900, 1800] * 3
TAKEN = "of column 'p [mbar]' is taken to part thousands; correct 'decimal:' under 'format:' if not"
MAP = {
    "table": "t.csv",
    "format": {"separator": ";"},
    "time": {"column": "t [s]", "unit": "s"},
    "actuation": [{"column": "p [mbar]", "name": "p", "unit": "mbar"}],
    "observables": [{"column": "angle [deg]", "name": "angle", "unit": "deg"}],
}


def grouped(value: float, digits: int, signs: str) -> str:
    """A number with the first of two signs between its thousands, and the second as its decimal sign."""
    return f"{value:,.{digits}f}".translate(str.maketrans(",.", signs))


def table(written: Callable[[float], str], angle: str, path: str = "t.csv") -> None:
    """Pressures as they are written, and an angle beside them that is near a hundredth of each."""
    rows = [f"{10 * i};{written(p)};{angle.format(p // 100)}" for i, p in enumerate(STEPS)]
    Path(path).write_text("\n".join(["t [s];p [mbar];angle [deg]", *rows]) + "\n", encoding="utf-8")


def mapped(**form: str) -> list[float]:
    """The set-points that a mapping finds in the table."""
    Path("map.yaml").write_text(yaml.safe_dump(MAP | {"format": {"separator": ";", **form}}))
    return import_table(Path("map.yaml"), Path("mapped"))["commanded"].values.ravel().tolist()


@pytest.mark.parametrize(
    ("signs", "digits", "angle", "decimal"),
    [
        (".,", 0, "{},31", ","),
        (".,", 1, "{},31", ","),
        (".,", 0, "{}", ","),
        (",.", 0, "{}.31", "."),
        (",.", 1, "{}.31", "."),
        ("'.", 0, "{}.31", "."),
        ("\u2019.", 1, "{}.31", "."),
        (" ,", 1, "{},31", ","),
        ("\u202f,", 0, "{},31", ","),
    ],
)
def test_a_sign_between_thousands_is_no_decimal_sign(
    desk: Path, signs: str, digits: int, angle: str, decimal: str
) -> None:
    """Numbers in groups of three are whole, however a country parts them; a guess and a mapping read them alike."""
    table(lambda p: grouped(p, digits, signs), angle)
    run, guess, _ = import_guessed([Path("t.csv")], Path("run"))
    assert run["commanded"].values.ravel().tolist() == STEPS
    called = {",": "comma", ".": "dot"}.get(signs[0], "sign")
    assert f"the {called} in {grouped(1200, digits, signs)!r} {TAKEN}" in guess.remarks
    assert guess.mapping["format"].get("decimal", ".") == decimal
    assert mapped(decimal=decimal) == STEPS


def test_most_columns_with_thousands_do_not_outvote_a_decimal_comma(desk: Path) -> None:
    """One column with decimal commas tells that the dots of all the others part thousands."""
    rows = [f"{10 * i};{grouped(p, 0, '.,')};{grouped(2 * p, 0, '.,')};8,93" for i, p in enumerate(STEPS)]
    Path("t.csv").write_text("\n".join(["t [s];p1 [mbar];p2 [mbar];angle [deg]", *rows]) + "\n")
    run, guess, _ = import_guessed([Path("t.csv")], Path("run"))
    assert run["commanded"].values.tolist() == [[p, 2 * p] for p in STEPS]
    assert run["observable"].values.tolist() == ["angle"]
    assert sum("(and 1 more) is taken to part thousands" in line for line in guess.remarks) == 1


@pytest.mark.parametrize(
    ("written", "decimal", "found"),
    [
        ("{:.2f}", ",", "1200.00"),
        (("1.200", "{}"), ",", "1.200"),
        (("0,120", "{}"), ".", "0,120"),
        (("1,200", "{}"), ".", "1,200"),
    ],
)
def test_a_sign_that_is_neither_is_refused(
    desk: Path, written: str | tuple[str, str], decimal: str, found: str
) -> None:
    """A dot beside decimal commas before other than three digits, or where 2400 has none, is no number; vice versa."""
    first, rest = (written, written) if isinstance(written, str) else written
    table(lambda p: (first if p == STEPS[0] else rest).format(p), "{}")
    with pytest.raises(LabrigError) as error:
        mapped(decimal=decimal)
    assert str(error.value) == (
        f"t.csv, line 2: column 'p [mbar]' (actuation p) holds {found!r}, not a number where {decimal!r} is the "
        "decimal sign"
    )


@pytest.mark.parametrize(("sign", "other"), [(",", "."), (".", ",")])
def test_a_decimal_sign_that_may_part_thousands_is_said(desk: Path, sign: str, other: str) -> None:
    """Where all decimals of a file have three digits, what was taken is said."""
    table(lambda p: f"{1 + p / 10000:.3f}".replace(".", sign), "{}")
    run, guess, _ = import_guessed([Path("t.csv")], Path("run"))
    assert run["commanded"].values.ravel().tolist() == pytest.approx([1 + p / 10000 for p in STEPS])
    line = (
        f"the {'comma' if sign == ',' else 'dot'} in '1{sign}120' is read as a decimal sign; if it parts thousands, "
        f"write 'decimal: \"{other}\"' under 'format:'"
    )
    assert line in guess.remarks
    table(lambda p: f"{p / 10000:.3f}".replace(".", sign), "{}")
    assert not any("decimal sign" in line for line in guess_mapping(Path("t.csv")).remarks)


def test_many_columns_of_three_decimals_leave_no_doubt(desk: Path) -> None:
    """Where every number of many columns has three digits behind its dot, that is no sign between thousands."""
    places = (f"{10 + p / 700:.3f},{-80 - p / 900:.3f},{300 + p / 500:.3f},{1 + p / 300:.3f}" for p in STEPS)
    rows = [f"{10 * i},{p},{place}" for i, (p, place) in enumerate(zip(STEPS, places, strict=True))]
    Path("t.csv").write_text("\n".join(["t [s],p [mbar],m1 x,m1 y,m1 z,m2 x", *rows]) + "\n")
    assert not any("decimal sign" in line for line in guess_mapping(Path("t.csv")).remarks)


def test_commas_that_part_thousands_are_said_once(desk: Path, labrig) -> None:
    """Of numbers in quotes the command says in one line what it took their commas for, and so does a mapping."""
    rows = [f'{10 * i},"{p:,.0f}",{p / 50:.2f}' for i, p in enumerate(STEPS)]
    Path("t.csv").write_text("\n".join(["t [s],p [mbar],angle [deg]", *rows]) + "\n")
    code, out, _ = labrig("import", "t.csv", "-o", "run")
    assert (code, out.count("part thousands")) == (0, 1)
    assert f"note: the comma in '1,200' {TAKEN}\n" in out
    _, out, _ = labrig("import", "--mapping", "run.map.yaml", "-o", "again")
    assert f"note: t.csv: the comma in '1,200' {TAKEN}\n" in out


def test_cells_of_text_in_a_workbook(desk: Path) -> None:
    """Numbers that a workbook holds as text are read as those of a text table, beside numbers that are numbers."""
    frame = pd.DataFrame({"t [s]": [10 * i for i in range(len(STEPS))]})
    frame["p [mbar]"] = [grouped(p, 0, ".,") for p in STEPS]
    frame["angle [deg]"] = pd.Series([p / 50 + 0.31 for p in STEPS], dtype=object)
    frame.loc[::2, "angle [deg]"] = [f"{p / 50 + 0.31:.2f}".replace(".", ",") for p in STEPS[::2]]
    frame.to_excel("t.xlsx", index=False)
    run, _, _ = import_guessed([Path("t.xlsx")], Path("run"))
    assert run["commanded"].values.ravel().tolist() == STEPS
    assert run["observed"].values.ravel().tolist() == pytest.approx([p / 50 + 0.31 for p in STEPS])


def test_a_column_with_the_other_decimal_sign_says_so(desk: Path) -> None:
    """A column that has decimal commas where all others have points is left out, with what stands there."""
    rows = [f"{i / 8};{p};{p / 64};{p / 50:.2f}" for i, p in enumerate(STEPS)]
    rows = [row[: row.rindex(";")] + row[row.rindex(";") :].replace(".", ",") for row in rows]
    Path("t.csv").write_text("\n".join(["t [s];p [mbar];F [N];angle [deg]", *rows]) + "\n")
    remarks = guess_mapping(Path("t.csv")).remarks
    assert (
        "column 'angle [deg]' holds '24,00', no number where '.' is the decimal sign, and is left out"
        in remarks
    )


@pytest.mark.parametrize("separator", [",", ";"])
def test_what_stands_for_no_number_parts_no_thousands(desk: Path, separator: str) -> None:
    """Numbers of three decimals keep their points where a whole number, -999, stands for those that were lost."""
    rows = [
        [f"{i}.5", f"{p / 10}"] + ["-999" if (i + k) % 9 == 4 else f"{20 + k + i / 50:.3f}" for k in range(4)]
        for i, p in enumerate(STEPS)
    ]
    head = ["t [s]", "p_set [kPa]", *(f"m1_{axis} [mm]" for axis in "xyz"), "F [N]"]
    Path("t.csv").write_text("\n".join(separator.join(row) for row in [head, *rows]) + "\n")
    run, guess, _ = import_guessed([Path("t.csv")], Path("run"))
    assert guess.mapping["time"] == {"column": "t [s]", "unit": "s"}
    assert run["commanded"].values.ravel().tolist() == [p / 10 for p in STEPS]
    assert run["position_mm"].values.ravel()[0] == 20
