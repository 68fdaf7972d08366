"""The documentation as a site: it builds without a warning, loads nothing from elsewhere, and lacks no effect."""

import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import labrig
from labrig.effects._registry import shipped

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "docs" / "pictures" / "effects"

pytestmark = pytest.mark.slow  # the notebook is run, with a diagnosis


class Loads(HTMLParser):
    """What a page makes a browser load: addresses of scripts, styles, pictures and frames."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag in ("script", "img", "iframe", "source", "video"):
            self.addresses.append(given.get("src") or "")
        if tag == "link" and given.get("rel") != "canonical":
            self.addresses.append(given.get("href") or "")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built in a folder of its own; a warning of the build is an error."""
    folder = tmp_path_factory.mktemp("site")
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), done.stderr
    return folder


def test_every_effect_has_its_page(site: Path) -> None:
    """With its meaning, its source, its picture and its experiment; and every picture is of an effect that there is."""
    overview = (site / "effects" / "index.html").read_text(encoding="utf-8")
    for name, effect in shipped().items():
        text = re.sub(r"<[^>]*>", "", (site / "effects" / f"{name}.html").read_text(encoding="utf-8"))
        text = " ".join(text.split())
        for said in (effect.meaning, effect.experiment, effect.signature):
            assert " ".join(said.split())[1:30] in text, (name, said)
        assert (site / "pictures" / "effects" / f"{name}.png").stat().st_size < 40_000
        assert f'href="{name}.html"' in overview
    assert {path.stem for path in PICTURES.glob("*.png")} == set(shipped())


def test_the_pictures_are_of_runs_in_which_the_effect_was_found(site: Path) -> None:
    """What a page quotes: the error fell to less than half in the run that its picture is drawn from."""
    for name in shipped():
        figures = json.loads((PICTURES / f"{name}.json").read_text(encoding="utf-8"))
        assert figures["error_mm"]["model"] < 0.5 * figures["error_mm"]["base"], name


def test_every_public_name_has_its_entry(site: Path) -> None:
    """The reference lists what `dir(labrig)` lists, with its text."""
    page = (site / "reference" / "api.html").read_text(encoding="utf-8")
    for name in labrig.__all__:
        assert name.startswith("_") or f'id="labrig.{name}"' in page, name
    assert "which is nearer" in page


def test_the_notebook_ran_and_the_error_fell(site: Path) -> None:
    """The page shows what its cells gave: a diagnosis of creep, figures, and the better model on a new run."""
    page = (site / "tutorial-notebook.html").read_text(encoding="utf-8")
    assert "identified: creep, sure" in page
    assert "“improved” is nearer to the measurements than “model”" in page
    assert page.count("Plotly.newPlot") == 3
    notebook = json.loads((ROOT / "docs" / "tutorial-notebook.ipynb").read_text(encoding="utf-8"))
    assert not any(cell.get("outputs") for cell in notebook["cells"])


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    """No script, style, font or picture has an address on the network."""
    for page in site.rglob("*.html"):
        far = [a for a in Loads(page.read_text(encoding="utf-8")).addresses if re.match(r"(\w+:)?//", a)]
        assert not far, (page.name, far)
    for style in site.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*['\"]?(https?:)?//", style.read_text(encoding="utf-8")), (
            style.name
        )
