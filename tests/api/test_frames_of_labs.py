"""A DataFrame is imported as it comes out of a notebook: with an index, levels of names, text among its numbers."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig import LabrigError

HOLDS = np.random.default_rng(0).uniform(0, 60, 30).round(1)


@pytest.fixture(autouse=True)
def _there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def frame() -> pd.DataFrame:
    """Thirty holds of one pressure, of five rows each, and two markers that move with it."""
    p = np.repeat(np.r_[0.0, HOLDS[1:]], 5)
    places = {
        f"m{n}.{a}": k * n * p + 10.0 * n for n in (1, 2) for k, a in zip((0.1, 0.2, 0.3), "xyz", strict=True)
    }
    return pd.DataFrame({"t_s": 2.0 * np.arange(150), "p_set_kPa": p, **places})


def sizes(given: pd.DataFrame) -> tuple[object, ...]:
    """What became of a frame: its captures, inputs and markers, and how far the clock goes."""
    run = labrig.import_table(given, "run", replace=True)
    markers = run["marker"].values.tolist() if "marker" in run.coords else []
    return run.sizes["capture"], run["chamber"].values.tolist(), markers, float(np.nanmax(run["time_s"]))


AS_IT_IS = (30, ["p_set"], ["m1", "m2"], 298.0)


@pytest.mark.parametrize("drop", [True, False])
def test_what_is_in_the_index_is_a_column(drop: bool) -> None:
    """The levels of an index count, also where one of them is a column as well."""
    assert sizes(frame()) == AS_IT_IS
    assert sizes(frame().set_index("t_s", drop=drop)) == AS_IT_IS
    assert sizes(frame().set_index(["p_set_kPa", "t_s"], drop=drop)) == AS_IT_IS


@pytest.mark.parametrize("order", ["axis first", "marker first"])
def test_a_pivoted_frame_has_markers(order: str) -> None:
    """A long table that was pivoted, as its refusal asks for, has names of two levels: they are those of markers."""
    wide = frame()
    long = pd.concat(
        [
            wide[["t_s", "p_set_kPa"]].assign(marker=m, **{a: wide[f"{m}.{a}"] for a in "xyz"})
            for m in ("m1", "m2")
        ]
    ).sort_values(["t_s", "marker"])
    with pytest.raises(LabrigError, match="pivot it"):
        labrig.import_table(long, "long")
    pivoted = long.pivot(index=["t_s", "p_set_kPa"], columns="marker", values=["x", "y", "z"])
    if order == "marker first":
        pivoted = pivoted.swaplevel(axis=1)
    assert sizes(pivoted) == AS_IT_IS
    assert sizes(pivoted.reset_index()) == AS_IT_IS
    pivoted.to_parquet("pivoted.parquet")
    assert labrig.import_table("pivoted.parquet", "from_file").sizes["capture"] == 30


def test_a_thinned_frame_keeps_its_clock() -> None:
    """The numbers of the rows that are left are no clock where a column is one."""
    captures, *_, last_s = sizes(frame().iloc[::2])
    assert (captures, last_s) == (30, 296.0)


def test_text_among_numbers_is_said() -> None:
    """Cells of several kinds in a column are read as those of a text file are."""
    odd = frame().astype({"m1.x": object})
    odd.iloc[7, 2] = "n/a"
    run = labrig.import_table(odd, "run")
    assert np.isnan(run["position_mm"].sel(marker="m1", axis="x").values[1, 2])
    odd.iloc[9, 2] = "lost"
    with pytest.raises(
        LabrigError, match=r"^the DataFrame, row 10: column 'm1\.x' .* holds 'lost', not a number"
    ):
        labrig.import_table(odd, "other")


def test_decimal_commas_in_some_columns() -> None:
    """Numbers that are text with decimal commas are numbers, beside columns that are numbers already."""
    written = frame().assign(p_set_kPa=lambda f: f["p_set_kPa"].map(lambda v: str(v).replace(".", ",")))
    assert sizes(written) == AS_IT_IS
    assert labrig.open_run("run")["commanded"].values[1:, 0].tolist() == HOLDS[1:].tolist()


def test_two_columns_of_one_name_are_named() -> None:
    """The refusal says which name comes twice, not all that there are."""
    twice = pd.concat([frame(), frame()[["m1.x"]]], axis=1)
    with pytest.raises(LabrigError, match=r"^the DataFrame has several columns called 'm1\.x': rename"):
        labrig.import_table(twice, "run")
