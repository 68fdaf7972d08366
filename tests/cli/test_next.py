"""labrig next, as a person types it, and the procedure files that it writes."""

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

from labrig import LabrigError
from labrig.model import Model

Run = Callable[..., tuple[int, str, str]]
ON_OFF = [
    {"pressure_kpa": {"c1": 42, "c2": 36, "c3": 30, "c4": 45}, "hold_s": 4.0, "repeat": "on"},
    {"repeat": "off"},
]


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
            "p.yaml, line 2: points: entry 1: hold_s: should be greater than 0, not -1",
        ),
        ("points: []\n", "p.yaml: a procedure file begins with its name, such as `procedure: programme`"),
        (
            "procedure: programme\npoints: [{pressure_kpa: {c9: 1}}]\n",
            "rig bench has no chamber c9; it has c1, c2, c3, c4",
        ),
        (
            "procedure: programme\npoints: [{pressure_kpa: {c1: 99}}]\n",
            "1 limit would be broken; nothing was moved",
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


@pytest.mark.slow
def test_next_writes_a_procedure_that_settles(lab, labrig: Run, few_effects, monkeypatch) -> None:
    """On and off at one level leaves a loop's name open; the file that next writes runs, and the name is right.

    The programme tells it from two others; in the end it is told from all of them.
    """
    folder, whole = lab("hysteresis"), Model.library
    few_effects("hysteresis", "friction", "creep")
    (folder / "on_off.yaml").write_text(
        yaml.safe_dump({"procedure": "programme", "points": ON_OFF, "rounds": 10})
    )
    assert labrig("run", "on_off.yaml", "--rig", "rig.yaml", "--out", "run")[0] == 0
    code, out, err = labrig(
        "next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o", "next.yaml", "--minutes", 3
    )
    assert (code, err) == (0, "")
    assert "why this one: " in out
    assert ("14 of 20 such promises were kept" in out) == (" yes " in out)
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
    with monkeypatch.context() as patch:
        patch.setattr(Model, "library", whole)
        assert labrig("diagnose", "run", "run2", "--model", "model.yaml")[0] == 0
    found = json.loads((folder / "diagnosis" / "diagnosis.json").read_text())
    assert (found["verdict"], found["effects"]) == ("identified", ["hysteresis"])

    code, out, err = labrig("next", "run", "--model", "model.yaml", "--minutes", 1)
    assert (code, err) == (0, "")
    assert f"set-points: {Path('next', 'programme.csv')}" in out
    assert "procedure" not in out

    code, _, err = labrig("next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o", "next.yaml")
    assert (code, err) == (2, "labrig: next.yaml exists; choose another name, or overwrite it with --force\n")


def test_next_refuses_another_rig(lab, labrig: Run) -> None:
    """A rig with other chambers than the run's, and a file that is no YAML file: one line each."""
    folder = lab("nothing")
    (folder / "p.yaml").write_text(yaml.safe_dump({"procedure": "programme", "points": ON_OFF}))
    assert labrig("run", "p.yaml", "--rig", "rig.yaml", "--out", "run")[0] == 0
    other = yaml.safe_load((folder / "rig.yaml").read_text())
    other["chambers"] = other["chambers"][:2]
    (folder / "other.yaml").write_text(yaml.safe_dump(other))
    code, _, err = labrig("next", "run", "--model", "model.yaml", "--rig", "other.yaml", "-o", "next.yaml")
    assert code == 2
    assert err == "labrig: other.yaml: its chambers (c1, c2) are not those of run (c1, c2, c3, c4)\n"
    code, _, err = labrig("next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o", "next.txt")
    assert (code, err) == (2, "labrig: next.txt: a procedure file ends in .yaml\n")


def test_a_programme_that_is_no_procedure_is_shown(lab, labrig: Run, monkeypatch) -> None:
    """Where a procedure file is refused, what was proposed is printed all the same, before the reason."""

    def refuse(*_: object) -> None:
        raise LabrigError("these set-points are in ml")

    lab("leak")
    proposed = SimpleNamespace(summary={}, to_rule_out=(), save=refuse)
    monkeypatch.setattr("labrig.propose_experiment", lambda *_, **__: proposed)
    monkeypatch.setattr("labrig.cli._tables.print_experiment", lambda _: print("SHOWN"))
    code, out, err = labrig("next", "run", "--model", "model.yaml", "-o", "next.yaml")
    assert (code, out, err) == (2, "SHOWN\n", "labrig: these set-points are in ml\n")
