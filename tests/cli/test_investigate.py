"""labrig investigate, as a person types it, on simulated rigs that hide something."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from labrig.rig import RigConfig

Run = Callable[..., tuple[int, str, str]]
RIG = """
name: bench
chambers: [{name: c1, max_kpa: 60}]
pressure: {kind: simulated}
mocap: {kind: simulated}
simulated: {surface: membrane}
"""
LINE = ("investigate", "--rig", "rig.yaml", "--model", "model.yaml", "--budget")


def kept(folder: Path) -> dict[str, Any]:
    """What the investigation of a folder knows."""
    return json.loads((folder / "investigation" / "investigation.json").read_text())


def test_a_budget_that_is_too_small(lab, labrig: Run) -> None:
    """It is said how much would do; nothing is measured, and no folder is left."""
    folder = lab("nothing")
    code, _, err = labrig(*LINE, 1)
    assert code == 2
    assert err == "labrig: --budget 1 min is too little to begin with; give it 4 or more\n"
    assert not (folder / "investigation").exists()


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

    monkeypatch.setattr(_investigate_runs, "run", interrupted)
    line = (*LINE, 7)
    code, _, err = labrig(*line)
    assert code == 130
    assert (
        "stopped by Ctrl-C; the chambers are vented; 1 rounds are in investigation; to resume: labrig " in err
    )
    assert "--resume" in err
    assert kept(folder)["state"] == "interrupted"
    code, _, err = labrig(*line)
    assert (code, err) == (
        2,
        "labrig: investigation is not empty; choose another --out, or continue it with --resume\n",
    )
    code, out, _ = labrig(*line, "--resume")
    assert code == 0
    state = kept(folder)
    assert len(calls) == 1 + len(state["rounds"])
    named = state["rounds"][-1]["effects"]
    assert state["state"] == "settled"
    assert "leak" in named
    assert state["confirmation"]["after"] < 0.3 * state["confirmation"]["before"]
    assert state["minutes"] <= 7
    assert "with it the error falls from " in out
    new = yaml.safe_load((folder / "investigation" / "model.new.yaml").read_text())
    assert [e["name"] for e in new["effects"]] == named
    page = (folder / "investigation" / "report.html").read_text()
    for each in state["rounds"]:
        assert f'href="{each["report"]}"' in page
        assert (folder / "investigation" / each["report"]).is_file()
    code, _, err = labrig(*line, "--resume")
    assert (code, err) == (
        2,
        f"labrig: investigation is finished (settled): see {Path('investigation/report.html')}, or begin anew with "
        "another --out\n",
    )


def test_whatever_is_named_an_investigation_comes_to_its_end(lab, labrig: Run) -> None:
    """On a rig that creeps, what one run names is evaluated on all later ones: no round ends in an error."""
    folder = lab("creep")
    code, out, err = labrig(*LINE, 5)
    assert code == 0, err
    state = kept(folder)
    assert state["state"] in {"settled", "open", "out of budget"}
    assert state["conclusion"] in out
    assert state["minutes"] <= 5
    assert len(state["rounds"]) >= 2
    assert not any("can't act" in warning for warning in state["warnings"])


@pytest.mark.parametrize(
    ("verdict", "rounds", "drop", "asked"),
    [
        ("confounded", ["capture"], None, "confounded"),
        ("identified", ["capture"], None, "identified"),
        ("identified", ["capture", "experiment"], None, None),
        ("identified", ["capture", "experiment", "confirmation"], 0.5, "unknown"),
        ("identified", ["capture", "confirmation"], 0.5, "unknown"),
        ("identified", ["capture", "confirmation"], 0.9, "identified"),
        ("unknown", ["capture", "experiment"], None, "unknown"),
        ("unknown", ["capture", "experiment", "experiment"], None, None),
    ],
)
def test_what_the_next_programme_is_asked_to_settle(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    verdict: str,
    rounds: list[str],
    drop: float | None,
    asked: str | None,
) -> None:
    """What is possible, once; where least is known, if nothing has a name or a name did not hold on fresh captures."""
    from labrig import LabrigError, diagnosis
    from labrig.cli import _investigate_steps as steps

    calls = []

    def propose(*_: Any, summary: dict[str, Any], **__: Any) -> None:
        calls.append(summary["verdict"])
        raise LabrigError("enough")

    monkeypatch.setattr(diagnosis, "propose_experiment", propose)
    settings = steps.Settings(tmp_path, tmp_path, 30.0, tmp_path, 0, 0.9, realtime=False)
    now = steps.Investigation(settings, rounds=[{"programme": p, "verdict": verdict} for p in rounds])
    monkeypatch.setattr(steps.Investigation, "opened", lambda _: [])
    if drop is not None:
        now.confirmation = {"drop": drop, "effects": ["leak"]}
    result = diagnosis.Result({"verdict": verdict, "effects": ["leak"]}, {}, [], {}, [], None)
    bench = steps.Bench(RigConfig.model_validate(yaml.safe_load(RIG)), tmp_path)
    assert steps._experiment(now, bench, None, result, 10.0, None) is None  # type: ignore[arg-type]
    assert calls == ([asked] if asked else [])
