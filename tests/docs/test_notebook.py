"""docs/how-to/notebook.md works as it stands."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

import labrig
from tests.rigs import RIG

pytestmark = pytest.mark.slow  # two diagnoses and an experiment

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "notebook.md"


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, few_effects: Callable[..., None]) -> Path:
    """The files that the page speaks of: a simulated rig that hides creep, its first run, a model, and a table.

    Creep is told from a few others; the notebook that the site runs tells it from all (test_site).
    """
    from labrig_drivers.simulated import hide, seal

    few_effects("creep", "leak", "drift", "hysteresis")
    monkeypatch.chdir(tmp_path)
    Path("rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    Path("table.csv").write_text("p_kPa,x_mm\n" + "".join(f"{p},{0.1 * p:.1f}\n" for p in range(0, 60, 3)))
    Path("model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\neffects: []\n", encoding="utf-8")
    seal(tmp_path, hide("creep", seed=1))
    labrig.run("capture", "rig.yaml", out="runs/first", captures=40)
    return tmp_path


def test_the_page_runs_and_the_error_falls(lab: Path) -> None:
    """Every block in order, in one session; the first takes ten lines from a run to a lower error."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len([line for line in blocks[0].splitlines() if line.strip()]) <= 10
    names: dict[str, object] = {}
    lines = blocks[0].strip().splitlines()
    exec("\n".join(lines[:-1]), names)
    assert eval(lines[-1], names) is True
    for block in blocks[1:]:
        exec(block, names)
    assert (lab / "diagnosis" / "report.html").is_file()
    assert labrig.open_run("runs/second").sizes["capture"] > 0
