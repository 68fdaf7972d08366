"""A table of one's own that is imported once more: in another unit, by a better clock, in the place of a run."""

from pathlib import Path

import pytest
import yaml

from labrig import LabrigError, open_run
from labrig.log import import_table
from tests.log.test_import import MAP, imported, table


def test_an_imported_run_is_replaced_when_asked(desk: Path, labrig) -> None:
    """Once a mapping is corrected, --replace puts the new run in the place of the old one; nothing else is replaced."""
    table().to_csv("t.csv", index=False)
    imported(MAP)
    corrected = {**MAP, "between_sessions": "vented"}
    with pytest.raises(
        LabrigError, match=r"run exists already; choose another name, or replace it \(--replace, "
    ):
        imported(corrected)
    assert labrig("import", "--mapping", "map.yaml", "-o", "run", "--replace")[0] == 0
    assert open_run("run").attrs["between_sessions"] == "vented"
    assert labrig("tag", "run", "good")[0] == 0
    Path("map.yaml").write_text(yaml.safe_dump({**MAP, "time": {"column": "no such", "unit": "s"}}))
    assert labrig("import", "--mapping", "map.yaml", "-o", "run", "--replace")[0] == 2
    assert open_run("run").attrs["between_sessions"] == "vented"
    assert labrig("import", "--mapping", "map.yaml", "-o", "run")[0] == 2
    Path("map.yaml").write_text(yaml.safe_dump(MAP))
    assert labrig("import", "--mapping", "map.yaml", "-o", "run", "--replace")[0] == 0
    assert "good" in labrig("runs", ".")[1]
    assert sorted(p.name for p in Path("run").iterdir()) == ["log.000.mcap", "notes.yaml", "run.yaml"]
    Path("mine").mkdir()
    Path("mine", "thesis.txt").write_text("important")
    code, _, err = labrig("import", "--mapping", "map.yaml", "-o", "mine", "--replace")
    assert (code, err) == (2, "labrig: mine is no imported run, and is not replaced; choose another name\n")
    assert Path("mine", "thesis.txt").read_text() == "important"


def test_a_run_that_cannot_be_replaced_stays(desk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the new run cannot be written, or not be put in place, the old one is there as it was, and nothing else."""
    table().to_csv("t.csv", index=False)
    imported(MAP)
    before, there = open_run("run"), sorted(p.name for p in Path().iterdir())
    rename = Path.rename

    def full(*arguments: object) -> None:
        raise OSError("no space left on device")

    def stuck(path: Path, target: Path) -> Path:
        return full() if path.suffix == ".partial" else rename(path, target)  # type: ignore[return-value]

    for name, failing in (("labrig.log._table._write_captures", full), ("pathlib.Path.rename", stuck)):
        with monkeypatch.context() as patch:
            patch.setattr(name, failing)
            with pytest.raises(OSError, match="no space left"):
                import_table(Path("map.yaml"), Path("run"), replace=True)
        assert open_run("run").equals(before)
        assert sorted(p.name for p in Path().iterdir()) == there


def test_a_guess_is_made_again_on_the_command_line(desk: Path, labrig) -> None:
    """With --replace a guess takes the place of one, and not of a run with a mapping."""
    table().to_csv("t.csv", index=False)
    for options in ((), ("--replace",)):
        assert labrig("import", "t.csv", "-o", "run", *options)[0] == 0
    imported(MAP, "own")
    code, _, err = labrig("import", "t.csv", "-o", "own", "--replace")
    assert (code, err) == (
        2,
        "labrig: own was imported with a mapping, and a guess does not replace it: choose another name, or import with "
        "the mapping\n",
    )


def two_days(scale: float) -> list[str]:
    """What is said of two files, of which the second has its coordinates times `scale`."""
    first, second = table(), table()
    second[["x", "F"]] *= scale
    first.to_csv("day1.csv", index=False)
    second.to_csv("day2.csv", index=False)
    run = imported({**MAP, "table": ["day1.csv", "day2.csv"]})
    return [line for line in run.attrs["warnings"] if "times as large" in line]


def test_files_in_two_units_are_asked_about(desk: Path) -> None:
    """Where one day's numbers are a thousand times as large as another's, it is said which, and in which unit."""
    assert two_days(1000.0) == [
        "observable 'm1.x' (and 1 more) is 1e+03 times as large in day2.csv as in day1.csv: are both in m?"
    ]


def test_files_that_differ_as_days_do_are_not_asked_about(desk: Path) -> None:
    """Ten times the force on another day may be physics."""
    assert two_days(10.0) == []


def test_a_clock_that_is_too_coarse_is_said(desk: Path) -> None:
    """Times in whole minutes do not say when in a hold a row was measured; single equal ones are nothing."""
    coarse = table().assign(t=[0, 0, 0, 1, 1, 1, 1, 2, 2])
    coarse.to_csv("t.csv", index=False)
    mapping = {key: value for key, value in MAP.items() if key != "hold"}
    (line,) = [line for line in imported(mapping).attrs["warnings"] if "finer clock" in line]
    assert line.startswith("t.csv: 6 of 9 rows have the time of the row before, it goes in steps of 60 s: ")
    coarse.assign(t=[0, 0, 1, 2, 3, 4, 5, 6, 7]).to_csv("t.csv", index=False)
    assert not [line for line in imported(mapping, "fine").attrs["warnings"] if "finer clock" in line]


def test_volts_become_pressures(desk: Path) -> None:
    """An amplifier's 0 to 10 V are 0 to 2 bar above 0.1: commanded, measured, observed and beside, each by its own."""
    frame = table()
    frame.to_csv("t.csv", index=False)
    scaled = {"scale": 0.2, "offset": 0.1}
    entries = {
        "actuation": [{**MAP["actuation"][0], **scaled}, MAP["actuation"][1]],
        "measured": [{**MAP["measured"][0], **scaled}],
        "observables": [{**o, **scaled} if o["name"] in ("force", "m1.x") else o for o in MAP["observables"]],
        "covariates": [{**MAP["covariates"][0], **scaled}],
    }
    plain, run = imported(MAP, "plain"), imported({**MAP, **entries})
    for name in ("commanded", "measured"):
        assert run[name].sel(chamber="c1").values == pytest.approx(
            0.2 * plain[name].sel(chamber="c1").values + 0.1, nan_ok=True
        )
        assert run[name].sel(chamber="c2").equals(plain[name].sel(chamber="c2"))
    force = run["observed"].sel(observable="force")
    assert force.values == pytest.approx(
        0.2 * plain["observed"].sel(observable="force").values + 0.1, nan_ok=True
    )
    assert run["covariates"].values == pytest.approx(0.2 * plain["covariates"].values + 0.1, nan_ok=True)
    where = {"marker": "m1", "axis": "x"}
    metres = 0.2 * plain["position_mm"].sel(where).values / 1000 + 0.1
    assert run["position_mm"].sel(where).values == pytest.approx(1000 * metres, nan_ok=True)


@pytest.mark.parametrize("scale", [0, ".nan"])
def test_a_scale_that_is_none_is_refused(desk: Path, scale: object) -> None:
    """Zero, or no number, would make every value the same: the line and the field are named."""
    table().to_csv("t.csv", index=False)
    Path("map.yaml").write_text(
        yaml.safe_dump(MAP).replace("column: F\n", f"column: F\n  scale: {scale}\n", 1)
    )
    with pytest.raises(LabrigError, match=r"map\.yaml, line \d+: observables.*scale"):
        import_table(Path("map.yaml"), Path("run"))
