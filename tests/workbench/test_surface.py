"""The surface in a real browser: its names follow it, and can be read wherever they stand; it is made ahead."""

import json
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from time import monotonic, sleep

import pytest

from labrig.view import ERROR_SCALE
from labrig.workbench import _compare, open_desk
from labrig.workbench._views import kept
from tests.browsers import NO_WEBGL
from tests.workbench.conftest import Asker, served

NAMES = "all => all.flatMap(e => e.data.filter(t => t.mode === 'text' && t.visible).flatMap(t => t.text))"
OTHER_SCALE = """([run, scale]) => {
    for (const old of document.querySelectorAll(".surface")) old.dataset.old = "true";
    location.hash = `#/run/${run}/compare?scale=${scale}`;
}"""
SHOWN = """e => ({
    shades: e.data[0].marker.color,
    inks: e.data.filter(t => t.mode === "text" && t.text[0] !== "c1").flatMap(t => t.textfont.color),
    behind: getComputedStyle(document.documentElement).getPropertyValue("--raised").trim(),
})"""


@pytest.fixture(scope="module")
def bench(shared_bench):
    """The one that the tests of this file share."""
    return shared_bench


@pytest.fixture
def shown(bench, make_run):
    """The run that the pages show."""
    return "run" if (bench.desk.folder / "run").exists() else make_run()


def _compared(page, run):
    page.evaluate("run => location.hash = `#/run/${run}/compare`", run)
    page.wait_for_selector("[data-drawn]")


def _light(colour):
    """Relative luminance of #rrggbb, as WCAG has it."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    red, green, blue = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def _contrast(one, other):
    low, high = sorted(map(_light, (one, other)))
    return (high + 0.05) / (low + 0.05)


def _under(shade):
    """The colour of the surface where the error has this shade."""
    a, b = next(two for two in pairwise(ERROR_SCALE) if shade <= two[1][0])
    share = (shade - a[0]) / (b[0] - a[0])
    parts = [[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for _, colour in (a, b)]
    return "#" + "".join(f"{round(x + share * (y - x)):02x}" for x, y in zip(*parts, strict=True))


def test_the_names_follow_the_surface(open_page, shown):
    """The surface is shown before plotly has made the letters of its names; then each name is there once."""
    page = open_page()
    _compared(page, shown)
    page.wait_for_selector(".surface[data-names=all]")
    names = page.locator(".surface:visible").evaluate_all(NAMES)
    assert sorted(names) == ["m0", "m1", "m2", "m3"]


PAINTED = """canvas => {
    const { width, height } = canvas;
    const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
    const seen = [...Array(width * height).keys()].filter(n => data[4 * n + 3] > 0);
    const ends = all => [all.reduce((a, b) => Math.min(a, b)), all.reduce((a, b) => Math.max(a, b))];
    return { x: ends(seen.map(n => n % width)), y: ends(seen.map(n => Math.floor(n / width))), size: [width, height] };
}"""


@pytest.mark.slow
def test_the_surface_is_drawn_flat_until_plotly_is_there(open_page, shown):
    """While the drawing library is under way a flat picture of the surface stands in its place, beside the verdict."""
    page = open_page()
    held = []
    page.route("**/plotly.js", lambda route: held.append(route))
    page.reload()
    page.evaluate("run => location.hash = `#/run/${run}/compare`", shown)
    page.wait_for_selector(".surface canvas.flat")
    assert "error" in page.locator("h1").inner_text()
    page.wait_for_function("performance.getEntriesByName('surface').length > 0")
    painted = page.locator("canvas.flat").first.evaluate(PAINTED)
    ends = list(zip((painted["x"], painted["y"]), painted["size"], strict=True))
    for (low, high), size in ends:
        assert 0 < low < high < size
        assert abs((low + high) / 2 - size / 2) < size / 4
    assert any(high - low > size / 3 for (low, high), size in ends)
    for route in held:
        route.continue_()
    page.wait_for_selector("[data-drawn]")
    assert page.locator("canvas.flat").count() == 0
    assert page.locator(".surface .gl-container, .surface .svg-container").count() > 0


def test_without_webgl_the_surface_stays_flat(open_page, shown):
    """A browser over a remote desktop: the surface is drawn flat for every capture, and one line says why."""
    page = open_page()
    page.add_init_script(NO_WEBGL)
    page.reload()
    _compared(page, shown)
    assert "no WebGL" in page.locator("figcaption:visible").inner_text()
    seen = []
    for capture in ("2", "5", "2"):
        page.click(f"[data-capture='{capture}']")
        page.wait_for_selector(f"[data-drawn='{capture}'] canvas.flat:visible")
        seen.append(page.locator("canvas.flat:visible").evaluate_all("all => all.map(e => e.toDataURL())"))
    assert len(seen[0]) == 2
    assert all(one != other for one, other in zip(seen[0], seen[1], strict=True))
    assert seen[2] == seen[0]
    assert page.locator(".surface .svg-container").count() == 0


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_names_can_be_read_on_and_beside_the_surface(open_page, shown, theme):
    """By day and at night a name stands out of the colour under it, and can be seen where it leaves the surface."""
    page = open_page()
    page.emulate_media(color_scheme=theme)
    page.reload()
    for scale in ("1~16", "0.0001~0.0002"):  # the palest colours, and the darkest
        page.evaluate(OTHER_SCALE, [shown, scale])
        page.wait_for_selector(".surface:not([data-old])[data-names=all]")
        seen = page.locator(".surface").first.evaluate(SHOWN)
        assert len(seen["inks"]) == len(seen["shades"]) == 4
        for ink, shade in zip(seen["inks"], seen["shades"], strict=True):
            assert _contrast(ink, _under(shade)) > 2.4
            assert _contrast(ink, seen["behind"]) > 1.6


def test_another_capture_is_another_surface(open_page, shown):
    """With each capture the markers of both surfaces stand elsewhere; back again they are where they were."""
    page = open_page()
    _compared(page, shown)
    place = "all => all.filter(e => e.data).map(e => [e.data[0].x, e.data[0].marker.color].join())"
    seen = []
    for capture in ("2", "5", "2"):
        page.click(f"[data-capture='{capture}']")
        page.wait_for_selector(f"[data-drawn='{capture}'] .surface[data-names=all]")
        seen.append(page.locator(".surface:visible").evaluate_all(place))
    assert len(seen[0]) == len(seen[1]) == 2
    assert all(one != other for one, other in zip(seen[0], seen[1], strict=True))
    assert seen[2] == seen[0]


def _views(folder: Path) -> list[Path]:
    return list((folder / ".workbench" / "views").glob("*.json"))


@pytest.fixture
def newest(bench, make_run, tmp_path):
    """A workbench of its own with a run that nobody has looked at, and the run's name."""
    run = make_run("newest", captures=10)
    folder = tmp_path / "lab"
    folder.mkdir()
    shutil.move(bench.desk.folder / run, folder / run)
    shutil.copy(bench.desk.folder / "model.yaml", folder)
    with served(folder) as running:
        yield running, run


def test_the_newest_run_is_made_while_the_list_is_looked_at(newest, labrig):
    """What was compared elsewhere is ready when it is opened; what was not compared is left to a person."""
    running, run = newest
    folder, ask = running.desk.folder, Asker(running)
    ask("/api/runs")
    sleep(0.5)
    assert _views(folder) == []
    code, _, said = labrig(
        "compare", folder / run, "--model", folder / "model.yaml", "--out", folder / run / "model"
    )
    assert code == 0, said
    ask("/api/runs")
    end = monotonic() + 60
    while not _views(folder) and monotonic() < end:
        sleep(0.05)
    (view,) = _views(folder)
    assert json.loads(view.read_text()) == ask(f"/api/compare?run={run}&model=model.yaml")[1]


def test_what_two_ask_for_is_made_once(tmp_path, monkeypatch):
    """Who asks for what is being made waits for it."""
    desk = open_desk(tmp_path)
    (tmp_path / "run").mkdir()
    (tmp_path / "model.yaml").touch()
    made = []

    def asked(work, *keys):
        made.append(keys)
        sleep(0.2)
        return "{}"

    monkeypatch.setattr(desk.worker, "ask", asked)
    key = str(tmp_path / "run"), str(tmp_path / "model.yaml")
    with ThreadPoolExecutor(2) as pool:
        texts = list(pool.map(lambda _: kept(desk, _compare.view, key), range(2)))
    assert texts == ["{}", "{}"]
    assert len(made) == 1


def test_the_worker_has_imported_what_is_slow():
    """Opening the first run imports none of the large packages."""
    code = "import sys; from labrig.workbench._held import ready; ready(); print(*sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {"xarray", "pandas", "scipy.interpolate", "scipy.spatial"} <= set(ended.stdout.split())
