"""labrig investigate, as a person types it, on simulated rigs that hide something."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

Run = Callable[..., tuple[int, str, str]]
LINE = ("investigate", "--rig", "rig.yaml", "--model", "model.yaml", "--budget")


def kept(folder: Path) -> dict[str, Any]:
    """What the investigation of a folder knows."""
    return json.loads((folder / "investigation" / "investigation.json").read_text())


def test_a_budget_that_is_too_small(lab, labrig: Run) -> None:
    """It is said how much would do; nothing is measured, and no folder is left."""
    folder = lab("nothing")
    code, _, err = labrig(*LINE, 1)
    assert code == 2
    assert err == "labrig: a budget of 1 min is too little to begin with; give it 4 or more\n"
    assert not (folder / "investigation").exists()


def test_help_does_not_allow_what_is_refused(labrig: Run) -> None:
    """No lowest budget is named that a first campaign could not be made of."""
    out = labrig("investigate", "--help")[1]
    assert "x>=1.0" not in out
    assert "on most rigs 4" in " ".join(out.replace("│", " ").split())


@pytest.mark.slow
def test_an_investigation_is_interrupted_goes_on_and_ends_with_a_better_model(
    lab, labrig: Run, monkeypatch: pytest.MonkeyPatch, few_effects
) -> None:
    """Ctrl-C in the second run: vented, said where things are; --resume measures only what is missing.

    The hidden leak is named, confirmed on captures recorded after the verdict, and in the new model.
    """
    few_effects("leak", "creep", "drift", "hysteresis")
    from labrig.investigation import _bench

    folder = lab("leak")
    true_run, calls = _bench.run, []

    def interrupted(*arguments: Any, **more: Any) -> Path:
        calls.append(arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt("stopped by Ctrl-C; the chambers are vented")
        return true_run(*arguments, **more)

    monkeypatch.setattr(_bench, "run", interrupted)
    line = (*LINE, 5)
    code, _, err = labrig(*line)
    assert code == 130
    assert (
        "stopped by Ctrl-C; the chambers are vented; 1 round is in investigation; to resume: labrig " in err
    )
    assert "--resume" in err
    assert kept(folder)["state"] == "interrupted"
    code, _, err = labrig(*line)
    assert (code, err) == (
        2,
        "labrig: investigation is not empty; choose another folder, or go on with what is there (--resume, "
        "resume=True)\n",
    )
    code, out, _ = labrig(*line, "--resume")
    assert code == 0
    state = kept(folder)
    assert len(calls) == 1 + len(state["rounds"])
    named = state["rounds"][-1]["effects"]
    assert state["state"] == "settled"
    assert "leak" in named
    assert state["confirmation"]["after"] < 0.3 * state["confirmation"]["before"]
    assert state["minutes"] <= 5
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
        f"labrig: investigation is finished (settled): see {Path('investigation/report.html')}, or begin anew in "
        "another folder\n",
    )
