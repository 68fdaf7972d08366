"""labrig next and labrig investigate, as a person types them, and the procedure files between them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

Run = Callable[..., tuple[int, str, str]]
CHAMBERS = [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)]
RIG = {
    "name": "bench",
    "chambers": CHAMBERS,
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated", "rate_hz": 20},
    "simulated": {"surface": "membrane", "seed": 0, "hidden": "sealed.json"},
}
MODEL = "base: {kind: simulator, rig: rig.yaml}\neffects: []\n"
ON_OFF = [
    {"pressure_kpa": {"c1": 42, "c2": 36, "c3": 30, "c4": 45}, "hold_s": 4.0, "repeat": "on"},
    {"repeat": "off"},
]


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Makes a folder with a simulated rig that hides something, and its model, and goes there."""
    from drivers.simulated import hide, seal

    def make(hidden: str, seed: int = 1, **rig: Any) -> Path:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "rig.yaml").write_text(yaml.safe_dump({**RIG, **rig}))
        (tmp_path / "model.yaml").write_text(MODEL)
        seal(tmp_path, hide(hidden, seed=seed))
        return tmp_path

    return make


def test_a_procedure_in_a_file(lab, labrig: Run) -> None:
    """A YAML file is a procedure: options go over it, it is dry-run and run, and what it repeats is labelled."""
    from labrig import open_run

    folder = lab("nothing")
    (folder / "on_off.yaml").write_text(
        yaml.safe_dump({"procedure": "programme", "points": ON_OFF, "rounds": 3})
    )
    code, out, err = labrig("run", "on_off.yaml", "--rig", "rig.yaml", "--dry-run", "--rounds", 2)
    assert (code, err) == (0, "")
    assert "12 steps, 4 captures on rig bench" in out
    assert labrig("run", "on_off.yaml", "--rig", "rig.yaml", "--out", "run")[0] == 0
    run = open_run("run")
    assert run["repeat"].values.tolist() == ["on", "off"] * 3
    assert run["commanded"].values[0].tolist() == [42, 36, 30, 45]
    assert (
        labrig("run", "on_off.yaml", "--help")[1].count("programme: Set-points in the order of a file") == 1
    )


def test_points_that_need_a_person_are_left_out(lab, labrig: Run) -> None:
    """They are done only if somebody says that he is there; then the note comes first, and time for it."""
    folder = lab("nothing")
    points = [*ON_OFF, {"note": "turn the base", "by_hand": True}]
    (folder / "p.yaml").write_text(yaml.safe_dump({"procedure": "programme", "points": points}))
    alone = labrig("run", "p.yaml", "--rig", "rig.yaml", "--dry-run")[1]
    attended = labrig("run", "p.yaml", "--rig", "rig.yaml", "--dry-run", "--by-hand")[1]
    assert "turn the base" not in alone
    assert "note     text turn the base" in attended
    assert "settle   duration_s 60.0" in attended


@pytest.mark.parametrize(
    ("content", "error"),
    [
        (
            "procedure: programme\npoints: [{hold_s: -1}]\n",
            "p.yaml: points.0.hold_s: Input should be greater than 0 (and 1 more)",
        ),
        ("points: []\n", "p.yaml: a procedure file begins with its name, such as `procedure: programme`"),
        (
            "procedure: programme\npoints: [{pressure_kpa: {c9: 1}}]\n",
            "rig bench has no chamber c9; it has c1, c2, c3, c4",
        ),
        (
            "procedure: programme\npoints: [{pressure_kpa: {c1: 99}}]\n",
            "1 limits would be broken; nothing was moved",
        ),
    ],
)
def test_bad_procedure_files(lab, labrig: Run, content: str, error: str) -> None:
    """One line, exit code 2."""
    folder = lab("nothing")
    (folder / "p.yaml").write_text(content)
    code, _, err = labrig("run", "p.yaml", "--rig", "rig.yaml", "--dry-run")
    assert code == 2
    assert err == f"labrig: {error}\n"


def test_next_writes_a_procedure_that_settles(lab, labrig: Run) -> None:
    """On and off at one level leaves a loop's name open; the file that next writes runs, and the name is right."""
    folder = lab("hysteresis")
    (folder / "on_off.yaml").write_text(
        yaml.safe_dump({"procedure": "programme", "points": ON_OFF, "rounds": 10})
    )
    assert labrig("run", "on_off.yaml", "--rig", "rig.yaml", "--out", "run")[0] == 0
    code, out, err = labrig(
        "next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o", "next.yaml", "--minutes", 3
    )
    assert (code, err) == (0, "")
    assert "why this one: " in out
    assert "to run it: labrig run next.yaml --rig rig.yaml --dry-run" in out
    report = json.loads((folder / "next" / "next.json").read_text())
    assert report["verdict"] in {"confounded", "identified"}
    assert "hysteresis" in report["separates"]
    assert report["captures"] == len(yaml.safe_load((folder / "next.yaml").read_text())["points"])
    assert "<h2>The probes</h2>" in (folder / "next" / "report.html").read_text()
    dry = labrig("run", "next.yaml", "--rig", "rig.yaml", "--dry-run")
    assert dry[0] == 0
    assert f"{report['captures']} captures on rig bench" in dry[1]
    assert labrig("run", "next.yaml", "--rig", "rig.yaml", "--out", "run2", "--seed", 1)[0] == 0
    assert labrig("diagnose", "run", "run2", "--model", "model.yaml")[0] == 0
    found = json.loads((folder / "diagnosis" / "diagnosis.json").read_text())
    assert (found["verdict"], found["effects"]) == ("identified", ["hysteresis"])

    code, _, err = labrig("next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o", "next.yaml")
    assert (code, err) == (2, "labrig: next.yaml exists; choose another name, or overwrite it with --force\n")


def test_next_refuses_another_rig(lab, labrig: Run) -> None:
    """A rig with other chambers than the run's, and a file that is no YAML file: one line each."""
    folder = lab("nothing")
    (folder / "p.yaml").write_text(yaml.safe_dump({"procedure": "programme", "points": ON_OFF}))
    assert labrig("run", "p.yaml", "--rig", "rig.yaml", "--out", "run")[0] == 0
    other = {**RIG, "chambers": CHAMBERS[:2]}
    (folder / "other.yaml").write_text(yaml.safe_dump(other))
    code, _, err = labrig("next", "run", "--model", "model.yaml", "--rig", "other.yaml", "-o", "next.yaml")
    assert code == 2
    assert err == "labrig: other.yaml: its chambers (c1, c2) are not those of run (c1, c2, c3, c4)\n"
    code, _, err = labrig("next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o", "next.txt")
    assert (code, err) == (2, "labrig: next.txt: a procedure file ends in .yaml\n")


def test_a_budget_that_is_too_small(lab, labrig: Run) -> None:
    """It is said how much would do, and nothing is measured."""
    folder = lab("nothing")
    code, _, err = labrig("investigate", "--rig", "rig.yaml", "--model", "model.yaml", "--budget", 1)
    assert code == 2
    assert err == "labrig: --budget 1 min is too little to begin with; give it 4 or more\n"
    assert list((folder / "investigation").iterdir()) == []


def test_an_investigation_is_interrupted_goes_on_and_ends_with_a_better_model(
    lab, labrig: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the second run: vented, said where things are; --resume measures only what is missing.

    The hidden leak is named, confirmed on captures recorded after the verdict, and in the new model.
    """
    from labrig.cli import _investigate_runs

    folder = lab("leak")
    true_run, calls = _investigate_runs.run, []

    def interrupted(*arguments: Any, **more: Any) -> Path:
        calls.append(arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt("stopped by Ctrl-C; the chambers are vented")
        return true_run(*arguments, **more)

    def kept() -> dict[str, Any]:
        return json.loads((folder / "investigation" / "investigation.json").read_text())

    monkeypatch.setattr(_investigate_runs, "run", interrupted)
    line = ["investigate", "--rig", "rig.yaml", "--model", "model.yaml", "--budget", "8"]
    code, _, err = labrig(*line)
    assert code == 130
    assert (
        "stopped by Ctrl-C; the chambers are vented; 1 rounds are in investigation; go on with: labrig "
        in err
    )
    assert "--resume" in err
    assert kept()["state"] == "interrupted"
    code, _, err = labrig(*line)
    assert (code, err) == (
        2,
        "labrig: investigation is not empty; choose another --out, or go on with --resume\n",
    )
    code, out, _ = labrig(*line, "--resume")
    assert code == 0
    state = kept()
    assert len(calls) == 1 + len(state["rounds"])
    assert (state["state"], state["rounds"][-1]["effects"]) == ("settled", ["leak"])
    assert state["confirmation"]["after"] < 0.3 * state["confirmation"]["before"]
    assert state["minutes"] <= 8
    assert "settled: Leak: with it the error falls from " in out
    new = yaml.safe_load((folder / "investigation" / "model.new.yaml").read_text())
    assert [e["name"] for e in new["effects"]] == ["leak"]
    page = (folder / "investigation" / "report.html").read_text()
    for each in state["rounds"]:
        assert f'href="{each["report"]}"' in page
        assert (folder / "investigation" / each["report"]).is_file()
    code, _, err = labrig(*line, "--resume")
    assert (code, err) == (
        2,
        "labrig: investigation is finished (settled): there is nothing to go on with\n",
    )
