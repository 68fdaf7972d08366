"""Mistakes in a table that nobody described are refused with their line, or said: a guess goes on over none."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed

N = 40
P = np.repeat([10.0, 30.0, 20.0, 0.0], 10)
FORCE = 0.5 * P + 0.01 * np.arange(N)


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder of the test."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(name: str = "t.csv", **columns: object) -> Path:
    """A table of a clock, a pressure in four holds and a force, and whatever else is given."""
    frame = {"time_s": np.arange(N), "p_set_kPa": P, "force_N": FORCE.round(3), **columns}
    pd.DataFrame(frame).to_csv(name, index=False)
    return Path(name)


def with_words(values: object, words: dict[int, str]) -> list[str]:
    """Numbers as text, with words in some rows."""
    return [words.get(i, str(v)) for i, v in enumerate(np.asarray(values).tolist())]


@pytest.mark.parametrize("blank", ["", "NaN", "err"])
def test_a_clock_with_a_blank_is_refused(blank: str) -> None:
    """A gap in the clock is refused with its line, as with a mapping: rows are not taken for 1 s apart."""
    path = write(time_s=with_words(2 * np.arange(N), {17: blank, 30: blank}))
    with pytest.raises(LabrigError, match=r"line 19: column 'time_s' \(time\) is empty or NaN"):
        guess_mapping(path)
