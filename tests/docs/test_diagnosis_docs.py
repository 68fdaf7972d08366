"""The how-tos of the diagnosis: their files are written, their commands run, in their order.

The tutorial is followed in tests/cli/test_demo.py, on the demo that it begins with.
"""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig.diagnosis import diagnose
from labrig.log import Mapping
from labrig.model import read_model_file
from tests.pages import DOCS, Run, blocks, follow

PAGES = (
    "tutorial-hidden-effect.md",
    "how-to/your-data.md",
    "how-to/add-an-effect.md",
    "reference/mapping.md",
    "reference/model.md",
    "reference/diagnosis.md",
)


@pytest.fixture(autouse=True)
def _desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_your_data(labrig: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """The smallest case works as it is written."""
    printed = follow("how-to/your-data.md", labrig, monkeypatch)
    assert printed["labrig import --mapping map.yaml -o run"] == (
        "run: 12 captures, 1 actuated, 1 observable, 1 session\n"
    )
    assert "error, N rms" in printed["labrig compare run --model model.yaml"]
    errors = [
        float(re.findall(r"│ +([\d.]+) │", printed[f"labrig compare run --model {model}.yaml"])[0])
        for model in ("model", "lag")
    ]
    assert errors[1] < errors[0]  # a lag that is shorter than the wait before each row


def test_an_effect_of_your_own(labrig: Run, monkeypatch: pytest.MonkeyPatch, make_lab) -> None:
    """The page's effect is found in data in which the weather moves the pressures, and its share comes back."""
    page = "how-to/add-an-effect.md"
    printed = follow(page, labrig, monkeypatch)
    shown = printed["labrig effects show barometer"]
    assert shown.startswith(
        "barometer (acts on pressure)\n\nThe pressure controller holds an absolute pressure"
    )
    lab = make_lab(chambers=2, captures=60, sessions=6)
    weather_hpa = 1013 + 15 * lab.random.normal(size=6)[lab.session] + lab.random.normal(size=60)
    u = lab.u - 0.09 * (weather_hpa - weather_hpa[0])[:, None, None]
    data = lab.dataset(lab.predict(u) + lab.noise(), {"barometer": ("hPa", weather_hpa)})
    result = diagnose(data, lab.model())
    assert (result.summary["verdict"], result.summary["effects"]) == ("identified", ["barometer"])
    assert result.improved is not None
    share = result.improved.file.effects[0].parameters["share"].value
    assert share == pytest.approx(0.9, abs=0.1)
    calm = lab.dataset(lab.predict(lab.u) + lab.noise(), {"barometer": ("hPa", weather_hpa)})
    assert np.isfinite(weather_hpa).all()
    assert diagnose(calm, lab.model()).summary["verdict"] == "nothing_missing"


def test_the_model_of_the_reference_is_one() -> None:
    """The example file, and each entry that the page shows, is read without complaint."""
    text, *entries = (t for language, t in blocks("reference/model.md") if language == "yaml")
    Path("model.yaml").write_text(text)
    assert [e.name for e in read_model_file(Path("model.yaml")).effects] == ["leak"]
    named = []
    for entry in (e for e in entries if e.startswith("- name")):
        Path("model.yaml").write_text(f"base: {{kind: static}}\neffects:\n{entry}")
        named += [e.name for e in read_model_file(Path("model.yaml")).effects]
    assert named == ["leak", "regulator"]


def test_the_reference_names_every_field_of_a_mapping() -> None:
    """What the reader accepts is what the page lists."""
    page = (DOCS / "reference/mapping.md").read_text("utf-8")
    listed = set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))
    assert listed == set(Mapping.model_fields)
    assert yaml.safe_load("{payload: 52}") == {"payload": 52}


def test_the_reference_has_the_verdicts_and_fields(make_lab) -> None:
    """Every verdict, and every key of a real diagnosis, is explained or shown."""
    from labrig.cli._tables import _VERDICTS

    page = (DOCS / "reference/diagnosis.md").read_text("utf-8")
    assert set(re.findall(r"^\| `(\w+)` \| .* \| .* \|$", page, re.MULTILINE)) == set(_VERDICTS)
    fields = set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.*?) \| .* \|$", page, re.MULTILINE))))
    assert fields >= {"effects_considered", "unnamed", "rivals", "ranking", "probability"}
    lab = make_lab(chambers=2, captures=20)
    summary = diagnose(lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()).summary
    shown = next(t for language, t in blocks("reference/diagnosis.md") if language == "text")
    assert set(re.findall(r'"(\w+)":', shown)) >= set(summary)


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    """Every relative link of these pages is a file of the project."""
    for target in re.findall(r"\]\(([^)#]+)\)", (DOCS / page).read_text("utf-8")):
        if "://" not in target:
            assert (DOCS / page).parent.joinpath(target).is_file(), target
