"""What a notebook has at hand is taken as it is: a DataFrame as a table, a function as a model."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig import LabrigError

RNG = np.random.default_rng(5)
PRESSURE = RNG.uniform(0.0, 60.0, (40, 2))


def predict(actuation: np.ndarray) -> np.ndarray:
    """A bellows that bends in proportion."""
    return (actuation @ [0.3, -0.2])[:, None]


def frame(gain: float = 1.0) -> pd.DataFrame:
    """A campaign of it, with the noise of a protractor."""
    angle = gain * predict(PRESSURE)[:, 0] + RNG.normal(0, 0.05, 40)
    return pd.DataFrame({"p1_kPa": PRESSURE[:, 0], "p2_kPa": PRESSURE[:, 1], "angle_deg": angle})


@pytest.fixture(autouse=True)
def _there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def names() -> list[str]:
    """What lies in the folder."""
    return sorted(path.name for path in Path().iterdir())


def test_a_frame_is_a_table() -> None:
    """Its values come back to the last digit; it is kept beside the run, where the guessed mapping names it."""
    given = frame()
    run = labrig.import_table(given, "mine")
    np.testing.assert_allclose(run["commanded"].values, PRESSURE, rtol=1e-15)
    assert names() == ["mine", "mine.frame-1.parquet", "mine.map.yaml"]
    again = labrig.import_table("mine.map.yaml", "again", given.iloc[:30])
    assert (again.sizes["capture"], labrig.open_run("mine").sizes["capture"]) == (30, 40)


def test_frames_are_sessions() -> None:
    """Several are sessions of one run, as files are."""
    run = labrig.import_table(frame(), "mine", [frame()])
    assert run.sizes["capture"] == 80
    assert len(set(run["session"].values.tolist())) == 2


@pytest.mark.parametrize("stamps", [pd.date_range("2026-03-01", periods=40, freq="4s"), pd.RangeIndex(40)])
def test_an_index_of_dates_is_the_clock(stamps: pd.Index) -> None:
    """Captures that are four seconds apart are four seconds apart; a mere count of the rows is no column."""
    run = labrig.import_table(frame().set_index(stamps), "mine")
    times = np.diff(run["event_time_s"].values)
    dated = isinstance(stamps, pd.DatetimeIndex)
    assert np.median(times) == pytest.approx(4.0 if dated else 1.0)


def test_a_frame_that_is_refused_leaves_nothing() -> None:
    """A value that no file holds, a column that the mapping needs, a run that is there: one line, no new file."""
    labrig.import_table(frame(), "mine")
    before = names()
    kept = Path("mine.frame-1.parquet").read_bytes()
    wrong: list[tuple[tuple[Any, ...], str]] = [
        ((frame().assign(o=object()), "other"), "the DataFrame can't be kept as a table: .*object"),
        (("mine.map.yaml", "other", frame().drop(columns="p1_kPa")), "has no column 'p1_kPa'"),
        ((frame(2.0), "mine"), "^mine exists already"),
        ((frame()["p1_kPa"], "other"), "a pandas.Series was given: .* or a DataFrame"),
        ((frame(), "nowhere/other"), "the folder nowhere does not exist"),
        (("none.csv", "other"), "^none.csv: there is no such table"),
    ]
    for arguments, text in wrong:
        with pytest.raises(LabrigError, match=text):
            labrig.import_table(*arguments)
        assert names() == before
    assert Path("mine.frame-1.parquet").read_bytes() == kept


def test_the_file_of_another_run_is_not_replaced() -> None:
    """A file of the frame's name belongs to somebody; with `replace` it is the run's own."""
    labrig.import_table(frame(), "mine")
    Path("other.frame-1.parquet").write_text("somebody's")
    with pytest.raises(LabrigError, match=r"other.frame-1.parquet exists already"):
        labrig.import_table("mine.map.yaml", "other", frame())
    assert Path("other.frame-1.parquet").read_text() == "somebody's"
    assert (
        labrig.import_table("mine.map.yaml", "mine", frame().iloc[:20], replace=True).sizes["capture"] == 20
    )


def test_a_function_is_a_model() -> None:
    """It is compared as one in a file is, by itself or as `Model.of` has it."""
    run = labrig.import_table(frame(1.2), "mine")
    Path("own.py").write_text("def predict(u):\n    return 0.3 * u[:, :1] - 0.2 * u[:, 1:]\n")
    Path("model.yaml").write_text("base: {kind: python, file: own.py}\n")
    in_file = labrig.compare(run, "model.yaml").error["model"]
    assert in_file > 1.0
    for model in (predict, labrig.Model.of(predict, learned=True)):
        assert labrig.compare(run, model).error["model"] == pytest.approx(in_file)


def test_an_object_that_counts_as_nothing_is_a_model() -> None:
    """A callable that is empty, as a network without layers of its own may be, is a function all the same."""

    class Empty:
        def __len__(self) -> int:
            return 0

        def __call__(self, actuation: np.ndarray) -> np.ndarray:
            return predict(actuation)

    run = labrig.import_table(frame(), "mine")
    assert labrig.compare(run, Empty()).error == labrig.compare(run, predict).error
    with pytest.raises(LabrigError, match="exists only in this session"):
        labrig.Model.of(Empty()).save("model.yaml")


def test_a_function_with_memory_is_a_model() -> None:
    """A step from a state, as in a model.yaml."""
    run = labrig.import_table(frame(), "mine")

    def step(state: Any, u: np.ndarray, _dt_s: float) -> tuple[Any, np.ndarray]:
        return state, predict(u[None])[0]

    model = labrig.Model.of(step, state=[0.0])
    assert labrig.compare(run, model).error["model"] == pytest.approx(
        labrig.compare(run, predict).error["model"]
    )
    with pytest.raises(LabrigError, match=r"^the function step: a step needs the state"):
        labrig.compare(run, step)


def test_a_function_that_is_wrong_is_named() -> None:
    """Its failure, a wrong shape, something that is none, a field that is wrong: one line that names it."""
    run = labrig.import_table(frame(), "mine")

    def broken(actuation: np.ndarray) -> np.ndarray:
        return actuation["p1"]

    with pytest.raises(
        LabrigError, match=r"^the function broken failed on 16 rows of 2 chambers: IndexError"
    ):
        labrig.compare(run, broken)
    with pytest.raises(LabrigError, match="a function is needed, and a int was given"):
        labrig.Model.of(3)  # type: ignore[arg-type]
    with pytest.raises(LabrigError, match=r"^predict: max_step_s: should be greater than 0, not -1"):
        labrig.Model.of(predict, max_step_s=-1.0)


def test_a_wrong_shape_names_the_last_columns() -> None:
    """What is no marker's comes last, and is what a function most often forgets."""
    places = {f"m{m}.{a}": 1.0 * m + np.arange(4) for m in range(3) for a in "xyz"}
    table = pd.concat([frame().iloc[:4][["p1_kPa", "p2_kPa"]], pd.DataFrame(places)], axis=1)
    run = labrig.import_table(table.assign(force_N=1.5 * np.arange(4)), "mine")
    with pytest.raises(LabrigError, match=r"m0\.x, m0\.y, m0\.z, m1\.x, \.\.\., m2\.z, force \(10 in all\)$"):
        labrig.compare(run, lambda u: np.zeros((len(u), 9)))


def test_what_is_to_last_needs_a_file() -> None:
    """A function is not saved and has no history: whoever opens the file tomorrow does not have it."""
    with pytest.raises(
        LabrigError, match=r"function predict, which exists only in this session: .* Write it to predict\.py"
    ):
        labrig.Model.of(predict).save("model.yaml")
    with pytest.raises(LabrigError, match="exists only in this session"):
        labrig.history("rig", predict, runs=".")  # type: ignore[arg-type]
    assert names() == []


def test_a_frame_that_was_to_replace_another_and_could_not_leaves_it() -> None:
    """What a run was made of stays as it was where a new frame is refused, and no second copy of it is left."""
    labrig.import_table(frame(), "mine")
    before, kept = names(), Path("mine.frame-1.parquet").read_bytes()
    wrong = frame().drop(columns="p1_kPa")
    with pytest.raises(LabrigError, match="has no column 'p1_kPa'"):
        labrig.import_table("mine.map.yaml", "mine", wrong, replace=True)
    with pytest.raises(LabrigError, match="can't be kept as a table"):
        labrig.import_table("mine.map.yaml", "mine", frame().assign(o=object()), replace=True)
    assert names() == before
    assert Path("mine.frame-1.parquet").read_bytes() == kept
    assert labrig.import_table("mine.map.yaml", "mine", frame(), replace=True).sizes["capture"] == 40
    assert names() == before
