"""When an imported record began: its first date, where its clock holds dates."""

from pathlib import Path

import pytest

from labrig.catalogue import list_runs, newest_first
from labrig.log import import_table, read_run_yaml

MAP = """\
time: {column: t, %s}
actuation: [{column: p, name: c1, unit: kPa, min: 0, max: 60}]
observables: [{column: x, name: x, unit: mm}]
"""


def _imported(folder: Path, name: str, unit: str, cells: list[str]) -> Path:
    rows = [f"{cell},{10 * (k // 4)},{k}" for k, cell in enumerate(cells)]
    (folder / f"{name}.csv").write_text("\n".join(["t,p,x", *rows]) + "\n", encoding="utf-8")
    (folder / f"{name}.map.yaml").write_text(MAP % unit, encoding="utf-8")
    import_table(folder / f"{name}.map.yaml", folder / name, [folder / f"{name}.csv"])
    return folder / name


@pytest.mark.parametrize(
    ("unit", "cells", "started"),
    [
        ("unit: date", [f"2024-03-05 10:00:{k:02d}" for k in range(12)], "2024-03-05 10:00:00"),
        ("unit: date", [f"2024-03-05T10:00:{k:02d}+02:00" for k in range(12)], "2024-03-05 08:00:00"),
        ("unit: s", [str(1_700_000_000 + k) for k in range(12)], "2023-11-14 22:13:20"),
        ("unit: date", [f"10:00:{k:02d}" for k in range(12)], ""),
        ("unit: s", [str(k) for k in range(12)], ""),
    ],
)
def test_a_record_with_dates_began_at_the_first(
    tmp_path: Path, unit: str, cells: list[str], started: str
) -> None:
    """In run.yaml and in the list of runs; a clock without dates says nothing of when."""
    run = _imported(tmp_path, "run", unit, cells)
    assert [row.started for row in list_runs(tmp_path)] == [started]
    assert bool(read_run_yaml(run).get("started")) == bool(started)


def test_the_newest_are_first_also_where_no_date_says_when(tmp_path: Path) -> None:
    """A run without dates stands where it was imported, before those that were recorded earlier."""
    _imported(tmp_path, "dated", "unit: date", [f"2024-03-05 10:00:{k:02d}" for k in range(12)])
    _imported(tmp_path, "counted", "unit: s", [str(k) for k in range(12)])
    assert [row.run for row in newest_first(tmp_path, list_runs(tmp_path))] == ["counted", "dated"]
