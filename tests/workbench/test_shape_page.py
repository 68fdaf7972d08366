"""Shape in a real browser: from a target to its pressures and to scans of it, with keys and labels, wide and narrow."""

import shutil
from typing import Any

import pytest

from tests.browsers import NO_WEBGL
from tests.shapes import write_lab
from tests.workbench.conftest import served

pytestmark = pytest.mark.usefixtures("browser")

UNNAMED = """() => [...document.querySelectorAll("main input:not([type=file]), main select, main button")]
    .filter((each) => !(each.labels?.length || each.getAttribute("aria-label") || each.textContent.trim()))
    .map((each) => each.outerHTML)"""
STARTS_S = 120_000


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A workbench for a simulated rig with a scanner, a model of it, two targets."""
    folder = write_lab(tmp_path_factory.mktemp("shape") / "lab")
    with served(folder, folder / "rig.yaml") as running:
        yield running


@pytest.fixture(scope="module")
def found(bench):
    """The name of what was found for the target that is out of reach."""
    from labrig.ik import solve_files, write_solved

    folder = bench.desk.folder
    solved = solve_files([folder / "bodies" / "far.ply"], folder / "model.yaml")
    (folder / "shapes" / "far").mkdir(parents=True)
    write_solved(solved, "model.yaml", folder / "shapes" / "far" / "ik.json")
    return "shapes/far"


def _shape(page: Any, **query: str) -> None:
    words = "&".join(f"{name}={value}" for name, value in query.items())
    page.evaluate("hash => location.hash = hash", f"#/shape?{words}")
    page.wait_for_selector("#shape-range b")


@pytest.mark.slow
def test_with_keys_alone_from_a_target_to_its_pressures(open_page, bench):
    """Alt+7 opens it; the target is chosen and the search begun without a mouse; pressures and both surfaces appear."""
    page = open_page()
    page.wait_for_selector("#steps a")
    page.keyboard.press("Alt+7")
    page.wait_for_selector("#shape-range b")
    assert page.is_disabled("#shape-find")
    assert page.inner_text("#shape-why") == "choose a target"
    page.focus("#shape-target")
    page.keyboard.type("near")
    page.wait_for_selector("#shape-find:not([disabled])")
    assert "0 to 60 kPa in each of 9 chambers (c1, c2" in page.inner_text("#shape-range")
    assert page.evaluate(UNNAMED) == []
    for _ in range(30):
        if page.evaluate("document.activeElement.id") == "shape-find":
            break
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.wait_for_selector("#shape-pressures")
    rows = page.locator("#shape-pressures tbody tr").all_inner_texts()
    assert [row.split()[0] for row in rows] == [f"c{n}" for n in range(1, 10)]
    assert float(rows[8].split()[1]) == pytest.approx(50.0, abs=1.0)
    assert page.inner_text("#shape-saved code") == "shapes/near/ik.json"
    page.wait_for_selector(".pair[data-drawn]")
    assert page.locator("#shape-found .surface .gl-container").count() == 2
    assert (bench.desk.folder / "shapes" / "near" / "report.html").is_file()


def test_what_is_out_of_reach_is_said(open_page, found):
    """Chambers at a limit are marked, and where the surface stays away stands in words, in a narrow window too."""
    page = open_page()
    page.set_viewport_size({"width": 420, "height": 900})
    _shape(page, found=found)
    page.wait_for_selector("#shape-gaps li")
    assert page.inner_text("tr[data-chamber=c9] td:last-child") == "at its highest"
    assert page.inner_text("tr[data-chamber=c1] td:last-child") == ""
    assert "mm around" in page.inner_text("#shape-gaps li >> nth=0")
    assert page.evaluate("document.documentElement.scrollWidth") <= 420
    page.click("#shapes-before a >> nth=0")
    page.wait_for_selector("#shape-found h2:has-text('far.ply')")


def test_turned_together_or_drawn_flat(open_page, found, browser, bench):
    """The camera of one view is that of the other; without WebGL both are drawn all the same, which is said."""
    page = open_page()
    _shape(page, found=found)
    page.wait_for_selector(".pair[data-drawn]")
    camera = """async () => {
        const [one, other] = document.querySelectorAll("#shape-found .surface");
        await window.Plotly.relayout(one, { "scene.camera": { eye: { x: 0.2, y: 0.3, z: 2 } } });
        await new Promise((resolve) => setTimeout(resolve, 100));
        return other.layout.scene.camera.eye;
    }"""
    assert page.evaluate(camera) == {"x": 0.2, "y": 0.3, "z": 2}
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    context.add_init_script(NO_WEBGL)
    flat = context.new_page()
    flat.goto(bench.address)
    _shape(flat, found=found)
    flat.wait_for_selector(".pair[data-drawn]")
    colours = """() => [...document.querySelectorAll("#shape-found canvas.flat")].map((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(Array.from({ length: data.length / 4 }, (_, k) => data.slice(4 * k, 4 * k + 4).join())).size;
    })"""
    assert all(count > 10 for count in flat.evaluate(colours))
    assert "no WebGL" in flat.inner_text("#shape-found")
    context.close()


def test_a_target_is_sent_from_the_page(open_page, bench, tmp_path):
    """It is chosen at once; on Choose, where tables are dropped, a shape leads here as well."""
    page = open_page()
    shutil.copy(bench.desk.folder / "near.ply", tmp_path / "mine.ply")
    _shape(page)
    page.set_input_files("#shape input[type=file]", tmp_path / "mine.ply")
    page.wait_for_selector("#shape-sent:has-text('2400 triangles')")
    assert page.input_value("#shape-target") == "targets/mine.ply"
    page.evaluate("location.hash = '#/choose'")
    page.set_input_files(".step.choose input[type=file]", tmp_path / "mine.ply")
    page.wait_for_selector("#shape-range b")
    assert page.input_value("#shape-target") == "targets/mine-2.ply"


@pytest.mark.slow
def test_a_check_starts_once_it_was_seen_and_answered_for(open_page, bench):
    """Its plan stands with the limits, a box must be checked, other boxes need another plan; then scans are shown."""
    page = open_page()
    _shape(page, target="near.ply")
    page.click("#check-plan:not([disabled])")
    page.wait_for_selector("#check-start")
    words = page.inner_text("#check-shown")
    assert "Every set-point lies within the limits: 0 to 60 kPa, at most 400 kPa/s in each chamber." in words
    assert "cancel, End and VENT stop it" in words
    assert page.inner_text("#check-start-why") == "it starts once the box is checked"
    page.check("#check-mine")
    assert page.is_enabled("#check-start")
    page.fill("#check-refine", "2")
    assert page.is_disabled("#check-start")
    assert "show the plan first" in page.inner_text("#check-start-why")
    page.fill("#check-refine", "0")
    page.check("#check-fast")
    page.fill("#check-out", "runs/checked")
    assert page.evaluate(UNNAMED) == []
    page.click("#check-start:not([disabled])")
    page.wait_for_selector("#check-found", timeout=STARTS_S)
    assert "near.ply: realised to 0.0" in page.inner_text("#check-standing h2")
    assert page.inner_text("#check-ended") == "runs/checked: completed; the chambers are vented."
    cells = page.locator("#check-found tbody tr >> nth=0").locator("td").all_inner_texts()
    assert cells[:2] == ["near.ply", "the whole model"]
    assert all(0.0 < float(cell.split(" /")[0]) < 0.3 for cell in cells[2:7])
    assert page.locator("#checks-before a").all_inner_texts() == ["runs/checked"]
    with page.context.expect_page() as opened:
        page.click("#check-found a")
    opened.value.wait_for_selector("h1:has-text('Realised to 0.0')")


def test_a_page_that_was_not_opened_for_the_rig_starts_nothing(browser, bench):
    """It sees the plan, and why it may not begin."""
    page = browser.new_page()
    page.goto(bench.address.split("#")[0])
    _shape(page, target="near.ply")
    page.click("#check-plan:not([disabled])")
    page.wait_for_selector("#check-mine")
    page.check("#check-mine")
    assert page.is_disabled("#check-start")
    assert (
        page.inner_text("#check-start-why")
        == "only the page that `labrig workbench --rig` opened moves the rig"
    )
    page.close()


def test_who_has_no_model_is_led_to_one(browser, tmp_path):
    """The simulator of a rig of the folder is a click away; how the workbench is opened for the rig is said."""
    folder = write_lab(tmp_path / "lab")
    (folder / "model.yaml").unlink()
    with served(folder) as running:
        page = browser.new_page()
        page.goto(running.address)
        page.evaluate("location.hash = '#/shape?target=near.ply'")
        page.wait_for_selector("#shape-why:has-text('a model is needed')")
        assert page.inner_text("#check .command code") == "labrig workbench . --rig rig.yaml"
        page.click("[data-simulator='rig.yaml']")
        page.wait_for_selector("#shape-find:not([disabled])")
        assert page.input_value("#shape-model") == "rig-simulator.yaml"
        page.close()


def test_what_is_missing_or_wrong_stands_on_the_page(browser, bench, monkeypatch):
    """A package with the command that adds it; a search that failed with the reason; a name that holds nothing."""
    (bench.desk.folder / "broken.ply").write_bytes(b"ply\n")
    page = browser.new_page()
    page.goto(bench.address)
    _shape(page, target="broken.ply")
    page.click("#shape-find:not([disabled])")
    page.wait_for_selector("#shape-found .wrong:has-text('broken.ply has no complete PLY header')")
    (bench.desk.folder / "broken.ply").unlink()
    _shape(page, found="nothing")
    page.wait_for_selector("#shape-found .wrong:has-text('holds no pressures for a shape')")
    monkeypatch.setattr("labrig._extras.find_spec", lambda name: None)
    page.reload()
    page.wait_for_selector("#shape-lacks:has-text(\"pip install '.[scan]'\")")
    assert page.is_disabled("#shape-find")
    page.close()
