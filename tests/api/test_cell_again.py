"""A cell that imports a DataFrame is run again: after it failed, in place of a run, and after the run was removed."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig import LabrigError

PLACE = {"day1", "day1.frame-1.parquet", "day1.map.yaml"}


@pytest.fixture(autouse=True)
def _there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def frame(gain: float = 0.1) -> pd.DataFrame:
    """Forty set-points of one pressure, and a force in proportion."""
    p = np.random.default_rng(0).uniform(0, 60, 40).round(1)
    return pd.DataFrame({"t_s": 4.0 * np.arange(40), "p_set_kPa": p, "force_N": gain * p})


def broken() -> pd.DataFrame:
    """The same, where one command is not known."""
    return frame().assign(p_set_kPa=lambda x: x["p_set_kPa"].where(x.index != 7))


def there() -> dict[str, bytes]:
    """What lies in the folder; of the run its log."""
    return {
        path.name: (path / "log.000.mcap" if path.is_dir() else path).read_bytes()
        for path in Path().iterdir()
    }


def gain_of(run: object) -> float:
    """The gain of a run's frame."""
    return float((run["observed"].values[:, 0, 0] / run["commanded"].values[:, 0])[0])  # type: ignore[index]


def edit() -> str:
    """Somebody's correction of the guessed mapping, and what it is now."""
    text = Path("day1.map.yaml").read_text().replace("name: force", "name: pull")
    Path("day1.map.yaml").write_text(text)
    return text


def test_a_cell_that_failed_works_once_its_frame_is_corrected() -> None:
    """Nothing is in its way: no file of the frame is left, and the guess is made anew."""
    for _ in range(2):
        with pytest.raises(LabrigError, match=r"^the DataFrame, row 8: column 'p_set_kPa'") as error:
            labrig.import_table(broken(), "day1")
        assert str(error.value).endswith('use it: labrig.import_table("day1.map.yaml", "day1", frame)')
        assert set(there()) == {"day1.map.yaml"}
    labrig.import_table(frame(), "day1")
    assert set(there()) == PLACE


def test_a_mapping_that_was_corrected_after_a_failure_is_used_as_the_error_says() -> None:
    """It is imported with the frame; a cell that would guess anew leaves it alone, and says so."""
    with pytest.raises(LabrigError):
        labrig.import_table(broken(), "day1")
    text = edit()
    for replace in (False, True):
        with pytest.raises(
            LabrigError, match=r"^day1.map.yaml was edited, .* a guess does not replace it: use it"
        ):
            labrig.import_table(frame(), "day1", replace=replace)
        assert there() == {"day1.map.yaml": text.encode()}
    run = labrig.import_table("day1.map.yaml", "day1", frame())
    assert run["observable"].values.tolist() == ["pull"]


def test_a_guess_replaces_a_guess() -> None:
    """The run, its frame and its mapping are those of the second frame, and nothing else is left."""
    labrig.import_table(frame(), "day1")
    with pytest.raises(LabrigError, match=r"^day1 exists already; choose another name, or say replace=True"):
        labrig.import_table(frame(0.2), "day1")
    second = frame(0.2).rename(columns={"force_N": "pull_N"})
    assert gain_of(labrig.import_table(second, "day1", replace=True)) == pytest.approx(0.2)
    assert set(there()) == PLACE
    assert "pull_N" in Path("day1.map.yaml").read_text()
    assert gain_of(labrig.import_table("day1.map.yaml", "again")) == pytest.approx(0.2)


def test_a_guess_that_fails_replaces_nothing() -> None:
    """Run, frame and mapping are as they were to the last byte, and the error says that they are."""
    labrig.import_table(frame(), "day1")
    before = there()
    with pytest.raises(LabrigError, match=r"^the DataFrame, row 8: .*: day1 is as it was$"):
        labrig.import_table(broken(), "day1", replace=True)
    assert there() == before


def test_no_guess_replaces_what_somebody_said() -> None:
    """A mapping that was edited, or a run that was imported with one, stays, and so does another's file."""
    labrig.import_table(frame(), "day1")
    guessed = Path("day1.map.yaml").read_text()
    edit()
    before = there()
    with pytest.raises(LabrigError, match=r"day1.map.yaml was edited"):
        labrig.import_table(frame(0.2), "day1", replace=True)
    assert there() == before
    labrig.import_table("day1.map.yaml", "day1", replace=True)
    Path("day1.map.yaml").write_text(guessed)
    before = there()
    with pytest.raises(
        LabrigError, match=r"^day1 was imported with a mapping, and a guess does not replace it"
    ):
        labrig.import_table(frame(0.2), "day1", replace=True)
    assert there() == before
    Path("day1.frame-1.parquet").write_text("somebody's")
    for mapping in (frame(0.2), "day1.map.yaml"):
        with pytest.raises(
            LabrigError, match=r"day1.frame-1.parquet exists already, and labrig did not write it"
        ):
            labrig.import_table(mapping, "day1", frame(0.2), replace=True)
    assert Path("day1.frame-1.parquet").read_text() == "somebody's"


def test_what_a_removed_run_leaves_is_in_nobodys_way() -> None:
    """The frame and the guessed mapping beside a run that is gone are written anew; they come back where that fails."""
    labrig.import_table(frame(), "day1")
    kept = there()["day1.frame-1.parquet"]
    shutil.rmtree("day1")
    with pytest.raises(LabrigError, match="row 8"):
        labrig.import_table(broken(), "day1")
    assert there()["day1.frame-1.parquet"] == kept
    assert gain_of(labrig.import_table(frame(0.2), "day1")) == pytest.approx(0.2)
    assert set(there()) == PLACE


def test_what_was_assumed_is_on_the_run() -> None:
    """A clock that stands still, an empty column and a unit that nobody said are said in Python, also by `open_run`; a
    count of rows is not, and a mapping of one's own assumes nothing.
    """
    odd = frame().assign(t_s=0.0, y_mm=np.nan, index=range(40)).rename(columns={"force_N": "force"})
    run = labrig.import_table(odd, "day1")
    assert run.attrs["assumed"] == [
        "column 'y_mm' is empty and is left out",
        "column 't_s' is called a time but stands still: left out",
        "no column is a time: rows are taken as 1 s apart; say so under 'time:' if not",
        "the unit of 'force' is not said: written as 1",
    ]
    assert run.attrs["warnings"] == []
    assert "# column 'index' counts rows and is left out\n" in Path("day1.map.yaml").read_text()
    assert labrig.open_run("day1").attrs["assumed"] == run.attrs["assumed"]
    assert labrig.import_table("day1.map.yaml", "again").attrs["assumed"] == []
