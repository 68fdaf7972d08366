"""labrig.history: what changed on a rig, from its runs alone."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import labrig
from labrig import LabrigError
from labrig.age import RunReadings, warning
from labrig_procedures import Hold


@pytest.fixture(scope="module")
def found(aged: Path) -> labrig.History:
    """The history of the rig that aged."""
    return labrig.history("bench", aged / "model.yaml", runs=aged / "runs")


def test_creep_that_doubled_is_named_with_its_day(found: labrig.History) -> None:
    """Its size is near what it really was before and after, and it is said that it came after the model was fitted."""
    changes = found.changes.set_index("name")
    assert {"creep", "error"} <= set(changes.index) <= {"creep", "error", "displacement"}
    creep = changes.loc["creep"]
    assert creep["date"].date().isoformat() == "2026-02-08"
    assert creep["noticed"] > creep["date"]
    assert creep["after"] / creep["before"] == pytest.approx(2.0, rel=0.15)
    assert creep["since_fit"]
    assert "creep" in creep["what"]
    assert found.headline().endswith("more.")


def test_effects_are_read_of_every_run(found: labrig.History) -> None:
    """Each run has the effect's size, with a standard deviation that covers what runs of the same rig differ by."""
    effects = found.effects
    assert list(effects["run"]) == [f"{day:02d}-0" for day in range(14)]
    early, late = effects["scale"][:6], effects["scale"][6:]
    assert early.std() < 2 * effects["sd"][:6].median()
    assert early.std() < 0.1 * early.mean()
    assert late.min() > 1.3 * early.max()


def test_the_table_has_everything(found: labrig.History) -> None:
    """Leaks and zeros of each chamber, each marker's place along three axes, noise, error, cameras, markers lost."""
    table = found.table
    count = table[table["run"] == "03-0"].groupby("group").size().to_dict()
    assert count["leak"] == count["zero"] == 4
    assert count["frame"] == 6
    assert count["marker"] > 3 * 10
    assert {"effect", "gain", "error", "floor", "lost"} <= set(count)
    floor = table[table["group"] == "floor"]
    assert ((floor["value"] > 0.03) & (floor["value"] < 0.3)).all()


def test_pictures_and_files(found: labrig.History, tmp_path: Path) -> None:
    """Every picture can be drawn, and saving writes JSON, HTML and a still picture."""
    assert {"effects", "softness", "error", "leaks", "zeros", "markers", "cameras", "lost"} == set(
        found.pictures
    )
    for name in found.pictures:
        assert found.plot(name).data
    with pytest.raises(LabrigError, match="no picture 'nothing'"):
        found.plot("nothing")
    report = found.save(tmp_path / "out")
    assert "creep" in report.read_text(encoding="utf-8")
    content = json.loads((report.parent / "history.json").read_text(encoding="utf-8"))
    assert content["changes"][0]["words"] == found.changes["what"][0]
    assert (report.parent / "history.png").stat().st_size > 10_000
    assert "creep" in repr(found)
    assert "creep" in found._repr_html_()


def test_a_second_call_opens_no_log(
    aged: Path, found: labrig.History, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a run says is kept beside it, and is read anew once its log or the model is another."""
    import labrig.age._read as module

    opened: list[str] = []
    read = module.open_run
    monkeypatch.setattr(module, "open_run", lambda path: opened.append(path.name) or read(path))
    again = labrig.history(aged / "rig.yaml", aged / "model.yaml", runs=aged / "runs")
    assert opened == []
    assert again.summary == found.summary
    with (aged / "runs" / "04-0" / "log.000.mcap").open("ab") as file:
        file.write(b"\x00" * 9)
    labrig.history("bench", aged / "model.yaml", runs=aged / "runs", where="started < '2026-02-08'")
    assert opened == ["04-0"]
    labrig.history("bench", aged / "base.yaml", runs=aged / "runs", where="started < '2026-02-04'")
    assert opened == ["04-0", "00-0", "01-0"]


def test_the_warning_before_a_campaign(aged: Path, found: labrig.History) -> None:
    """One line names what changed since the model was fitted; a model that was fitted after it is not warned of."""
    model = labrig.Model.load(aged / "model.yaml")
    said = warning("bench", model, aged / "runs")
    assert said.startswith("rig bench is not what model.yaml was fitted to: ")
    assert "creep" in said
    assert "\n" not in said
    assert warning("another", model, aged / "runs") == ""
    anew = labrig.improve([aged / "runs" / f"{day:02d}-0" for day in (12, 13)], aged / "base.yaml", "creep")
    anew.model.save(aged / "anew.yaml")
    labrig.history("bench", aged / "anew.yaml", runs=aged / "runs")
    assert warning("bench", labrig.Model.load(aged / "anew.yaml"), aged / "runs") == ""


def test_what_came_back_is_no_warning(found: labrig.History) -> None:
    """A quantity that is where it was when the model was fitted is not warned of."""
    from labrig.age import lasting

    there = next(c for c in found.summary["changes"] if c["name"] == "creep")
    back = there | {"before": there["after"], "after": there["before"], "noticed": 12}
    assert [c["name"] for c in lasting({"changes": [there]})] == ["creep"]
    assert lasting({"changes": [there, back]}) == []


def test_a_leak_and_a_moved_marker_are_told_apart(tmp_path: Path, measured: Callable[..., Path]) -> None:
    """A leak shows as the chambers' leak rates, in % a minute, and not as a marker that moved."""
    from labrig.age._known import Known
    from labrig.age._read import readings_of

    leak = {"effects": [{"name": "leak", "amplitude": 0.05}], "unit": "mm", "seed": 3}
    simulated = {"simulated": {"surface": "membrane", "seed": 1, "hidden": leak}}
    run = labrig.open_run(measured(tmp_path, 0, **simulated))
    tight = labrig.open_run(measured(tmp_path, 1))
    (tmp_path / "rig.yaml").write_text((tmp_path.parent / "rig-1-0.yaml").read_text(), encoding="utf-8")
    (tmp_path / "base.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n", encoding="utf-8")
    known = Known(labrig.Model.load(tmp_path / "base.yaml"))
    leaking = {r.key: r for r in readings_of(run, known) if r}
    holding = {r.key: r for r in readings_of(tight, known) if r}
    for chamber in ("c1", "c2", "c3", "c4"):
        there, here = leaking["leak", chamber], holding["leak", chamber]
        assert there.value[0] > 0.3
        assert abs(here.value[0]) < 5 * (here.sd or 0)
        held = np.asarray(run["measured"].sel(chamber=chamber))[-2]
        hold_s = np.asarray(run["hold_s"])[-2]
        settled = np.asarray(run["settled"])[-2]
        fall = -np.polyfit(hold_s[settled], np.log(held[settled]), 1)[0] * 6000.0
        assert there.value[0] == pytest.approx(fall, rel=0.1)
    moved = max(np.linalg.norm(r.value) for r in leaking.values() if r.group == "marker")
    assert moved < 0.6


def test_other_programmes_of_the_rig_count_too(
    aged: Path, measured: Callable[..., Path], tmp_path: Path
) -> None:
    """A run of another procedure is a kind of its own, and its readings are there."""
    runs = tmp_path / "runs"
    shutil.copytree(aged / "runs" / "00-0", runs / "00-0")
    measured(runs, 1, procedure=Hold(durations_s=(10.0,), shares=(0.5,), recovery_s=5.0))
    found = labrig.history("bench", aged / "model.yaml", runs=runs)
    assert list(found.runs["procedure"]) == ["check", "hold"]
    assert len({run["kind"] for run in found.summary["runs"]}) == 2


def test_what_cannot_be_read_is_left_out_and_said(aged: Path, tmp_path: Path) -> None:
    """A run that does not fit the model is named with the reason, and the others are shown; none at all is an error."""
    runs = tmp_path / "runs"
    for name in ("00-0", "01-0"):
        shutil.copytree(aged / "runs" / name, runs / name, ignore=shutil.ignore_patterns("readings.json"))
    (tmp_path / "rig.yaml").write_text((aged / "rig.yaml").read_text().replace("c4", "d4"), encoding="utf-8")
    (tmp_path / "base.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n", encoding="utf-8")
    with pytest.raises(LabrigError, match="none of the 2 runs of bench fits the model"):
        labrig.history("bench", tmp_path / "base.yaml", runs=runs)
    with pytest.raises(LabrigError, match=r"holds no runs of the rig 'nobody' \(it has runs of bench"):
        labrig.history("nobody", aged / "model.yaml", runs=runs)


def test_readings_survive_being_kept(aged: Path, found: labrig.History) -> None:
    """What is kept beside a run says when it was, and is the same when it is read again."""
    from labrig.age._read import from_content, kept

    contents = kept(aged / "runs" / "07-0").values()
    content = next(c for c in contents if any(r["group"] == "effect" for r in c["readings"]))
    again = from_content("07-0", content)
    assert isinstance(again, RunReadings)
    assert again.date == "2026-02-09 02:40"
    own = found.table[(found.table["run"] == "07-0") & (found.table["group"] == "effect")]["value"]
    assert [r.value[0] for r in again.readings if r.group == "effect"] == pytest.approx(list(own))


def test_what_is_said_of_a_run_counts_from_then_on(aged: Path, tmp_path: Path) -> None:
    """An effect that is ruled out in a run is not read of it, though it was before; damaged notes stop it once only."""
    runs = tmp_path / "runs"
    for name in ("00-0", "01-0", "02-0"):
        shutil.copytree(aged / "runs" / name, runs / name)

    def read() -> list[str]:
        return list(labrig.history("bench", aged / "model.yaml", runs=runs).effects["run"])

    assert read() == ["00-0", "01-0", "02-0"]
    labrig.rule_out(runs / "01-0", "creep")
    assert read() == ["00-0", "02-0"]
    (runs / "01-0" / "notes.yaml").write_text("ruled_out: [creeping slowly]\n", encoding="utf-8")
    assert read() == ["00-0", "02-0"]
    (runs / "01-0" / "notes.yaml").unlink()
    assert read() == ["00-0", "01-0", "02-0"]


def test_a_base_that_is_fitted_to_runs_is_fitted_once(aged: Path, tmp_path: Path) -> None:
    """A static map is fitted to the first run alone: fitted to each, it would hide that the rig has changed."""
    (tmp_path / "static.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    found = labrig.history("bench", tmp_path / "static.yaml", runs=aged / "runs")
    table = found.table
    error = table[table["group"] == "error"]["value"].to_numpy()
    each = [
        labrig.compare(aged / "runs" / f"{day:02d}-0", tmp_path / "static.yaml").error["model"]
        for day in (0, 12)
    ]
    assert error[0] == pytest.approx(each[0], rel=0.25)
    assert error[12] > 1.3 * each[1]
    assert "error" in set(found.changes["group"])
